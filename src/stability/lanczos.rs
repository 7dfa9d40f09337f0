//! Whether there is an unstable motion, by the Lanczos process on the tangent with its
//! constraints as stiff terms ([`crate::sqp::program`], `penalised`), from noise: where the
//! least eigenvalue found is positive, no motion that volume and contact admit lowers the energy,
//! but for a probability of a thousandth.
//! Where it is not the constraints are made stiffer; a motion that lowers the energy still is
//! projected on those that the constraints admit, and is the proof of a saddle if it does so there.
//! Between the two nothing is determined, and [`super::follow`] has the word. Cost: some twenty
//! products and applications where the body is far from unstable.

use super::{NEUTRAL, follow, motion_without_symmetry};
use crate::krylov::least_eigenvalue::Least;
use crate::linalg::vector::scale;
use crate::report::Stability;
use crate::sqp::lowest_mode::{LowestMode, length_at_rest};
use crate::sqp::program::{Accuracy, QuadraticProgram};
use crate::sqp::run::Run;

/// Stiffness of the constraints over what their metrics say, and steps at most. Soft ones take half
/// the steps, for they raise the largest eigenvalue least; where they do not do it shows in eight.
const TRIES: [(f64, usize); 4] = [(0.5, 80), (2.0, 80), (16.0, 80), (128.0, 80)];
/// How well a motion that lowers the energy keeps the constraints.
const KEPT: Accuracy = Accuracy {
    level: 1e-6,
    iterations: 200,
};

/// The softest motion of the present equilibrium, and whether there are unstable ones; none
/// where it was stopped.
pub(super) fn certified(run: &mut Run<'_>) -> Option<LowestMode> {
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let mut suspect = None;
    for tried in TRIES {
        let noise = motion_without_symmetry(run);
        match program.least_eigenvalue(run, noise, tried) {
            Least::Positive(motion, value) => {
                let length = length_at_rest(&run.model, &motion, run.work);
                return mode(run, motion, value / (length * length), Stability::Minimum);
            }
            Least::Negative(motion) => suspect = Some(motion),
            Least::NotFound(_) | Least::Nothing => break,
        }
    }
    // Loads without a potential may lead back what lowers the energy.
    let suspect = suspect.filter(|_| program.skew().is_none());
    let admitted = suspect.and_then(|motion| program.admitted(run, &motion, KEPT));
    if let Some(motion) = admitted {
        let length = length_at_rest(&run.model, &motion, run.work);
        let curvature = program.curvature_along(&motion, run.work);
        let eigenvalue = curvature / (length * length);
        if eigenvalue < -NEUTRAL {
            return mode(run, motion, eigenvalue, Stability::Saddle);
        }
    }
    follow::certified_about(run, &program)
}

/// The softest motion `motion`, scaled, with its eigenvalue.
fn mode(
    run: &mut Run<'_>,
    mut motion: Vec<f64>,
    eigenvalue: f64,
    stability: Stability,
) -> Option<LowestMode> {
    let length = length_at_rest(&run.model, &motion, run.work);
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    scale(&mut motion, 1.0 / length);
    Some(LowestMode {
        eigenvalue,
        motion,
        stability,
    })
}
