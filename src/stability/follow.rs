//! The softest motion, followed from increment to increment by inverse iteration, one
//! inexact solve on the present face a step. The motion of the last increment is where the
//! next starts, so that one step follows it; the first takes a few from noise. Found is the
//! eigenvalue nearest to zero: one that falls far below it within one increment is missed,
//! so that a positive one says little.

use super::{NEUTRAL, first_motion};
use crate::linalg::vector::scale;
use crate::report::Stability;
use crate::sqp::lowest_mode::{LowestMode, at_rest, length_at_rest};
use crate::sqp::program::{Accuracy, QuadraticProgram};
use crate::sqp::run::Run;

constants! {
    /// Steps from noise.
    const FIRST_STEPS: usize = 4;
    /// Steps from the motion of the increment before.
    const LATER_STEPS: usize = 1;
    /// Least eigenvalue that an inexact step vouches for.
    const DOUBTFUL: f64 = 0.1;
}
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

/// Follows the softest motion to the equilibrium of `program`; none where a solve was stopped.
pub(super) fn certified_about(
    run: &mut Run<'_>,
    program: &QuadraticProgram<'_>,
) -> Option<LowestMode> {
    let known = run.learned.lowest_mode.take();
    let mut motion = first_motion(run, known.as_ref());
    let steps = known.map_or(FIRST_STEPS, |_| LATER_STEPS);
    let mut eigenvalue = 0.0;
    let mut accuracies = vec![ROUGH; steps];
    while let Some(accuracy) = accuracies.pop() {
        let force = at_rest(&run.model, &motion, run.work);
        let found = program.invert(run, force, accuracy)?;
        let length = length_at_rest(&run.model, &found, run.work);
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        motion = found;
        scale(&mut motion, 1.0 / length);
        eigenvalue = program.curvature_along(&motion, run.work);
        if accuracies.is_empty() && eigenvalue < DOUBTFUL && accuracy == ROUGH {
            accuracies.push(SHARP);
        }
    }
    Some(LowestMode {
        motion,
        eigenvalue,
        // Without a potential what lowers the energy may lead back.
        stability: if eigenvalue > -NEUTRAL || program.skew().is_some() {
            Stability::NotDetermined
        } else {
            Stability::Saddle
        },
    })
}
