//! Whether an equilibrium is a minimum of the energy or a saddle: the sign of the
//! least eigenvalue of the tangent among the motions that volume and contact admit,
//!
//! ```text
//! K x = l P x,   B x = 0,   C_A x = 0,   K = A - curvature,   P = int 2 mu eps : eps
//! ```
//!
//! by inverse iteration, one inexact solve on the present face a step. The motion of
//! the last increment is where the next starts, so that one step follows it; the
//! first takes a few from noise. Where l has become negative another equilibrium is
//! lower, and the body will snap or buckle into it. Found is the eigenvalue nearest to
//! zero: one that falls far below it within one increment may be missed.

use super::counters::Counters;
use super::evaluate::{Context, evaluate, mask};
use super::program::Program;
use super::state::State;
use super::watch::Watch;
use crate::linalg::vector::{dot, reproducible_noise, scale};
use crate::linalg::{LinearOperator, Workspace};
use crate::report::Stability;

/// Steps from noise.
const FIRST_STEPS: usize = 4;
/// Steps from the motion of the increment before.
const LATER_STEPS: usize = 1;
/// Accuracy of a step.
const ROUGH: Accuracy = Accuracy {
    level: 0.1,
    iterations: 40,
};
/// Of one step more where the sign is in doubt: what is left of volume and gap has
/// a stiffness of its own, negative under pressure.
const SHARP: Accuracy = Accuracy {
    level: 1e-4,
    iterations: 200,
};
/// Least eigenvalue that a rough step vouches for.
const DOUBTFUL: f64 = 0.1;

/// How far one step of inverse iteration is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Accuracy {
    /// Of the residual.
    pub(super) level: f64,
    /// Krylov iterations.
    pub(super) iterations: u32,
}

/// The softest motion.
#[derive(Clone, Debug)]
pub(crate) struct Softest {
    motion: Vec<f64>,
    /// l.
    pub(crate) eigenvalue: f64,
}

impl Softest {
    /// What the sign says.
    pub(crate) fn stability(&self) -> Stability {
        match self.eigenvalue > 0.0 {
            true => Stability::Minimum,
            false => Stability::Saddle,
        }
    }

    /// The motion, to be turned with the body.
    pub(super) fn motion_mut(&mut self) -> &mut [f64] {
        &mut self.motion
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        8 * self.motion.len() as u64
    }
}

/// Follows the softest motion to the present equilibrium; none for linear bodies,
/// and where a solve was stopped.
pub(super) fn follow(
    context: &Context<'_>,
    state: &mut State,
    watch: &Watch<'_>,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Option<Softest> {
    context.prepared.strain.as_ref()?;
    let drive = state.drive.clone();
    let now = evaluate(context, state, &drive, work);
    let mut scale_of_force = 0.0;
    let program = Program::new(
        context,
        state,
        &drive,
        (&now, None),
        &mut scale_of_force,
        watch,
        counters,
        work,
    );
    let (mut motion, steps) = match state.softest.take() {
        Some(softest) => (softest.motion, LATER_STEPS),
        None => (first_motion(context, state), FIRST_STEPS),
    };
    let mut eigenvalue = 0.0;
    let mut accuracies = vec![ROUGH; steps];
    while let Some(accuracy) = accuracies.pop() {
        let force = at_rest(context, &motion, work);
        let found = program.invert(state, force, accuracy, watch, counters, work)?;
        let length = dot(&found, &at_rest(context, &found, work)).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        motion = found;
        scale(&mut motion, 1.0 / length);
        eigenvalue = program.curvature_along(&motion, work);
        if accuracies.is_empty() && eigenvalue < DOUBTFUL && accuracy == ROUGH {
            accuracies.push(SHARP);
        }
    }
    Some(Softest { motion, eigenvalue })
}

fn first_motion(context: &Context<'_>, state: &State) -> Vec<f64> {
    let mut noise = reproducible_noise(state.displacement.len());
    mask(&context.prepared.held, &mut noise);
    noise
}

/// P x.
fn at_rest(context: &Context<'_>, x: &[f64], work: &mut Workspace) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    context.prepared.stiffness.apply(x, &mut product, work);
    mask(&context.prepared.held, &mut product);
    product
}
