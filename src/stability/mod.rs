//! Whether an equilibrium is a minimum of the energy or a saddle: the sign of the least
//! eigenvalue of the tangent among the motions that volume and contact admit,
//!
//! ```text
//! K x = l P x,   B x = 0,   C_A x = 0,   K = A - curvature
//! ```
//!
//! | file | what it does | what it says |
//! |---|---|---|
//! | [`exact`] | counts the negative eigenvalues by a factor | minimum or saddle |
//! | [`lanczos`] | finds the least eigenvalue from noise | minimum or saddle, or not determined |
//! | [`follow`] | follows the eigenvalue nearest to zero | saddle, or not determined |
//!
//! Where l is negative another equilibrium is lower, and the body snaps or buckles into it.

mod exact;
mod follow;
mod lanczos;

use crate::linalg::vector::reproducible_noise;
use crate::model::ending::Ending;
use crate::model::held::mask;
use crate::report::{Cause, Stability, Termination};
use crate::scene::{OnInstability, StabilityCheck};
use crate::sqp::lowest_mode::LowestMode;
use crate::sqp::run::Run;

constants! {
    /// Eigenvalue over that at rest below which a motion lowers the energy: those of a body that is
    /// free to move as a whole are rounding.
    const NEUTRAL: f64 = 1e-6;
}

/// Looks whether a converged state of rubber is a minimum; a saddle is no end unless the
/// scene goes on along saddles.
pub(crate) fn certify(run: &mut Run<'_>, ending: &mut Ending) {
    if ending.termination != Termination::Converged || !run.model.is_rubber() {
        return;
    }
    let check = run.model.plan.decisions.stability.check;
    run.learned.lowest_mode = match check {
        StabilityCheck::Exact if run.model.plan.counts_motions() => exact::certified(run),
        StabilityCheck::Exact => lanczos::certified(run),
        StabilityCheck::Follow => lanczos::certified(run),
        StabilityCheck::Off => None,
    };
    let mode = run.learned.lowest_mode.as_ref();
    let is_unknown = mode.is_none() && check != StabilityCheck::Off;
    ending.stability = Some(mode.map_or(Stability::NotDetermined, |mode| mode.stability));
    if let Some(termination) = run.stopped().filter(|_| is_unknown) {
        (ending.termination, ending.stability) = (termination, None);
        return;
    }
    let goes_on = run.model.plan.problem.settings.on_instability == OnInstability::Continue;
    if ending.stability == Some(Stability::Saddle) && !goes_on {
        ending.termination = Termination::NotConverged;
        ending.cause = Some(Cause::UnstableEquilibrium);
    }
}

/// The motion that the search for the softest starts from: that of the equilibrium before,
/// or one without symmetry `[displacement]`, zero in held components.
fn first_motion(run: &Run<'_>, known: Option<&LowestMode>) -> Vec<f64> {
    known.map_or_else(
        || motion_without_symmetry(run),
        |known| known.motion.clone(),
    )
}

/// A reproducible motion without symmetry `[displacement]`, zero in held components.
fn motion_without_symmetry(run: &Run<'_>) -> Vec<f64> {
    let mut noise = reproducible_noise(run.state.displacement.len());
    mask(&run.model.prepared.held, &mut noise);
    noise
}

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        exact::own_constants(),
        follow::own_constants(),
        own_constants(),
    ]
    .concat()
}
