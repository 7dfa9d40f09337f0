//! Accepts a step of all unknowns: the largest length 1, 1/2, 1/4, .. that keeps
//! every point of the body the right side out and passes a filter on (constraint violation, force residual). Right up to where a
//! point would turn no step goes: from there programs take two to ten times the
//! applications (decision 21).

use super::program::Step;
use super::run::Run;
use crate::linalg::vector::{norm, ratio};
use crate::model::evaluate::Evaluation;
use crate::model::state::State;

constants! {
    /// Below this a smaller part of the increment leads further.
    const LEAST_LENGTH: f64 = 1.0 / 256.0;
    /// The same of a step that is taken without progress.
    const LEAST_NON_MONOTONE: f64 = 0.25;
    /// Least relative progress in one of the filter's measures.
    const LEAST_PROGRESS: f64 = 1e-4;
    /// Share of the least J that a step must leave.
    pub(crate) const JACOBIAN_SHARE: f64 = 0.2;
}

/// Why no length was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// Every length turned an element inside out: det F became negative.
    Jacobian,
    /// No length made the residuals or the energy smaller.
    Progress,
}

/// Moves the state along `step`, from the residuals `now`; it stays where no length
/// serves.
pub(crate) fn search(
    run: &mut Run<'_>,
    step: &Step,
    now: &Evaluation,
    (first_force, filter): (f64, &mut Vec<[f64; 2]>),
) -> Result<Evaluation, Refused> {
    let old = run.state.clone();
    filter.push(measures(run.state, now, first_force));
    let floor = now.least_jacobian.map(|least| JACOBIAN_SHARE * least);
    let mut refused = Refused::Jacobian;
    let mut length = 1.0;
    while length >= LEAST_LENGTH {
        step.apply(run.state, length);
        let trial = run.evaluate();
        if !is_inside_out(&trial, floor) {
            refused = Refused::Progress;
            let end = measures(run.state, &trial, first_force);
            let mut all = filter.iter();
            if run.model.is_linear()
                || all.all(|start| is_progress(&end, start, run.model.conditions.tolerance))
            {
                run.counters.step_length = length;
                return Ok(trial);
            }
        }
        run.state.clone_from(&old);
        length *= 0.5;
    }
    Err(refused)
}

/// Moves the state along `step` as far as every point keeps its share of the volume, whatever the
/// residuals say; the state stays where that is nowhere.
pub(crate) fn non_monotone_step(
    run: &mut Run<'_>,
    step: &Step,
    now: &Evaluation,
) -> Option<Evaluation> {
    let old = run.state.clone();
    let floor = now.least_jacobian.map(|least| JACOBIAN_SHARE * least);
    let mut length = 1.0;
    while length >= LEAST_NON_MONOTONE {
        step.apply(run.state, length);
        let trial = run.evaluate();
        if !is_inside_out(&trial, floor) {
            run.counters.step_length = length;
            return Some(trial);
        }
        run.state.clone_from(&old);
        length *= 0.5;
    }
    None
}

/// Whether some point has less volume left than a step must leave.
fn is_inside_out(trial: &Evaluation, floor: Option<f64>) -> bool {
    match (trial.least_jacobian, floor) {
        (Some(least), Some(floor)) => least.is_nan() || least <= floor,
        _ => false,
    }
}

/// Whether one of the filter's measures has fallen enough, or both are within the
/// tolerance.
fn is_progress(end: &[f64; 2], start: &[f64; 2], tolerance: f64) -> bool {
    let mut pairs = end.iter().zip(start);
    let better = pairs.any(|(after, before)| *after <= (1.0 - LEAST_PROGRESS) * before);
    better || end.iter().all(|&measure| measure <= tolerance)
}

/// Constraint violation and force residual.
fn measures(state: &State, now: &Evaluation, first_force: f64) -> [f64; 2] {
    let violation = ratio(now.gap_norm(state), state.scales.gap)
        + ratio(norm(&now.constraint), state.scales.constraint);
    [
        violation,
        ratio(norm(&now.force), now.force_scale(first_force)),
    ]
}
