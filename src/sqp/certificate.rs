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

use super::lowest_mode::LowestMode;
use super::program::{Accuracy, QuadraticProgram};
use super::run::Run;
use crate::linalg::vector::{dot, reproducible_noise, scale};
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::ending::Ending;
use crate::model::held::mask;
use crate::report::{Cause, Stability, Termination};

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

/// Looks whether a converged state of rubber is a minimum; a saddle is no end.
pub(crate) fn certify(run: &mut Run<'_>, ending: &mut Ending) {
    if ending.termination != Termination::Converged {
        return;
    }
    run.learned.lowest_mode = follow(run);
    let is_unknown = run.learned.lowest_mode.is_none() && run.model.is_rubber();
    if let Some(termination) = run.stopped().filter(|_| is_unknown) {
        ending.termination = termination;
        return;
    }
    let mode = run.learned.lowest_mode.as_ref();
    ending.stability = mode.map(LowestMode::stability);
    if ending.stability == Some(Stability::Saddle) {
        ending.termination = Termination::NotConverged;
        ending.cause = Some(Cause::UnstableEquilibrium);
    }
}

/// Follows the softest motion to the present equilibrium; none for linear bodies,
/// and where a solve was stopped.
fn follow(run: &mut Run<'_>) -> Option<LowestMode> {
    run.model.prepared.strain.as_ref()?;
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let (mut motion, steps) = match run.learned.lowest_mode.take() {
        Some(mode) => (mode.motion, LATER_STEPS),
        None => (first_motion(run), FIRST_STEPS),
    };
    let mut eigenvalue = 0.0;
    let mut accuracies = vec![ROUGH; steps];
    while let Some(accuracy) = accuracies.pop() {
        let force = at_rest(&run.model, &motion, &mut run.work);
        let found = program.invert(run, force, accuracy)?;
        let length = dot(&found, &at_rest(&run.model, &found, &mut run.work)).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        motion = found;
        scale(&mut motion, 1.0 / length);
        eigenvalue = program.curvature_along(&motion, &mut run.work);
        if accuracies.is_empty() && eigenvalue < DOUBTFUL && accuracy == ROUGH {
            accuracies.push(SHARP);
        }
    }
    Some(LowestMode { motion, eigenvalue })
}

/// A reproducible motion without symmetry `[displacement]`, zero in held components,
/// from which inverse iteration starts.
fn first_motion(run: &Run<'_>) -> Vec<f64> {
    let mut noise = reproducible_noise(run.state.displacement.len());
    mask(&run.model.prepared.held, &mut noise);
    noise
}

/// P x.
fn at_rest(model: &Model<'_>, x: &[f64], work: &mut Workspace) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    model.prepared.stiffness.apply(x, &mut product, work);
    mask(&model.prepared.held, &mut product);
    product
}
