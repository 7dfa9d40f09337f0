//! All unstable motions, counted by a factor of the saddle point
//! ([`crate::inequality::inertia`]): never wrong but for rounding. Cost: the entries of the
//! tangent by products, and one factor.

use super::{first_motion, motion_without_symmetry};
use crate::linalg::vector::scale;
use crate::report::Stability;
use crate::sqp::lowest_mode::{LowestMode, length_at_rest};
use crate::sqp::program::QuadraticProgram;
use crate::sqp::run::Run;

constants! {
    /// Share of noise in the motion that the search starts from, so that a mode of another
    /// symmetry than the last softest one is found too.
    const NOISE: f64 = 0.1;
}

/// The softest motion of the present equilibrium, and whether there are unstable ones;
/// none where it was stopped, or the factor is too large.
pub(super) fn certified(run: &mut Run<'_>) -> Option<LowestMode> {
    let now = run.evaluate();
    let program = QuadraticProgram::new(run, &now, None, &mut 0.0);
    let known = run.learned.lowest_mode.take();
    let mut start = first_motion(run, known.as_ref());
    let mut noise = motion_without_symmetry(run);
    let lengths = [&start, &noise].map(|x| length_at_rest(&run.model, x, run.work));
    scale(&mut noise, NOISE * lengths[0] / lengths[1]);
    start.iter_mut().zip(&noise).for_each(|(x, n)| *x += n);
    let mut found = program.inertia(run, &start)?;
    let length = length_at_rest(&run.model, &found.motion, run.work);
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    scale(&mut found.motion, 1.0 / length);
    Some(LowestMode {
        eigenvalue: program.curvature_along(&found.motion, run.work),
        motion: found.motion,
        stability: match (found.unstable, found.led_back) {
            (0, _) => Stability::Minimum,
            // Not of an energy, for loads that have none.
            (unstable, led_back) if led_back.is_none_or(|back| back >= unstable) => {
                Stability::NotDetermined
            }
            _ => Stability::Saddle,
        },
    })
}
