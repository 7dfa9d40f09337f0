//! Accepts a step of all unknowns: the largest length 1, 1/2, 1/4, .. that keeps
//! every point of the body the right side out all the way ([`super::longest_step`])
//! and passes a filter on (constraint violation, force residual). Right up to where a
//! point would turn no step goes: from there programs take two to ten times the
//! applications (decision 21).

use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation, evaluate, ratio};
use super::longest_step::{deformation_gradients, longest_step};
use super::program::Step;
use super::state::State;
use crate::linalg::Workspace;
use crate::linalg::vector::norm;

/// Below this a smaller part of the increment leads further.
const LEAST_LENGTH: f64 = 1.0 / 256.0;
/// Least relative progress in one of the filter's measures.
const LEAST_PROGRESS: f64 = 1e-4;
/// Share of the least J that a step must leave.
pub(super) const JACOBIAN_SHARE: f64 = 0.2;

/// Why no length was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// Every length turned an element inside out.
    Jacobian,
    /// No length made progress.
    Progress,
}

/// Moves `state` along `step`; the state stays where no length serves.
#[allow(clippy::too_many_arguments)]
pub(super) fn search(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    step: &Step,
    now: &Evaluation,
    first_force: f64,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Result<Evaluation, Refused> {
    let old = state.snapshot();
    let start = measures(state, now, first_force);
    let floor = now.least_jacobian.map(|least| JACOBIAN_SHARE * least);
    let mut refused = Refused::Jacobian;
    let mut longest = None;
    let mut length = 1.0;
    while length >= LEAST_LENGTH {
        step.apply(state, length);
        let trial = timed(&mut counters.seconds.contact, || {
            evaluate(context, state, drive, work)
        });
        let is_inside_out = match (trial.least_jacobian, floor) {
            (Some(least), Some(floor)) => least.is_nan() || least <= floor,
            _ => false,
        };
        if !is_inside_out {
            refused = Refused::Progress;
            let end = measures(state, &trial, first_force);
            let better = end
                .iter()
                .zip(&start)
                .any(|(after, before)| *after <= (1.0 - LEAST_PROGRESS) * before);
            let tolerable = end.iter().all(|&m| m <= context.tolerance);
            if context.is_linear() || better || tolerable {
                counters.step_length = length;
                return Ok(trial);
            }
        } else if longest.is_none() {
            let end = deformation_gradients(context, state);
            state.restore(&old);
            let start = deformation_gradients(context, state);
            let part = longest_step(&start, &end, floor.unwrap_or_default());
            longest = Some(part * length);
        }
        state.restore(&old);
        length *= 0.5;
        while longest.is_some_and(|longest| length > longest) && length >= LEAST_LENGTH {
            length *= 0.5;
        }
    }
    Err(refused)
}

/// Constraint violation and force residual.
fn measures(state: &State, now: &Evaluation, first_force: f64) -> [f64; 2] {
    let violation = ratio(now.gap_norm(&state.active), state.scales.gap)
        + ratio(norm(&now.constraint), state.scales.constraint);
    [
        violation,
        ratio(norm(&now.force), now.force_scale(first_force)),
    ]
}
