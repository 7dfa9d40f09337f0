//! How far the pressures of fluids may rise in one part of the path: to where the seal would leak if
//! it lost its excess as fast as it did before,
//!
//! ```text
//! e(q) = margin - threshold (q),   e(blow-off) = 0:   next q = q - e / e'
//! ```
//!
//! e' from the last two equilibria of the path. The margin is nearly affine in q (A. G. Shvarts and
//! V. A. Yastrebov, arXiv 1712.06312). The first part, which knows no e', raises the fluid by half of
//! what contact presses in the mean over all that the fluid can reach: levers, as lips are, leak
//! far below their margin. A step that names a pressure below the margin takes it at once. Far beyond
//! blow-off solutions are dear, and none of them is an equilibrium that is kept. Pressures are in the caller's units.
//! Cost: a pass over the surface of each fluid.

use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::fluids::{Met, mean_contact};
use crate::model::state::State;

constants! {
    /// First rise over the mean pressure of contact, without unit: in the example `o-ring-blow-off` .130 MPa,
    /// where it leaks at .148; chosen, other values were not measured.
    const FIRST_RISE: f64 = 0.5;
    /// Growth of the rise, without unit: four times the pressure where it began from nothing; chosen.
    const GROWTH: f64 = 3.0;
    /// Rise over the tolerance of the blow-off pressure, where the estimate of that is nearer: what leaks
    /// after such a rise is bracketed. Without unit; below one, so that rounding leaves it narrow.
    const LEAST_RISE: f64 = 0.9;
}

/// What is known of one fluid at the last equilibrium.
#[derive(Clone, Copy, Debug)]
struct Known {
    pressure: f64,
    excess: f64,
}

impl Known {
    /// By how much the pressure may rise after `before`, an equilibrium under a lower pressure.
    fn rise(&self, before: Self) -> f64 {
        let rise = self.pressure - before.pressure;
        let loss = before.excess - self.excess;
        let longest = GROWTH * rise;
        if loss > 0.0 {
            longest.min(self.excess * rise / loss)
        } else {
            longest
        }
    }
}

/// What the equilibria of a path have told of its fluids.
#[derive(Clone, Debug, Default)]
pub(super) struct SealTrend {
    /// Of each fluid, where it was looked at.
    last: Vec<Option<Known>>,
}

impl SealTrend {
    /// The longest part of the path from `state` to `goal` that may be taken from there, in (0, 1].
    pub(super) fn longest_part(&mut self, model: &Model<'_>, state: &State, goal: &Drive) -> f64 {
        self.last.resize(goal.fluids.len(), None);
        let fluids = state.drive.fluids.iter().zip(&goal.fluids).enumerate();
        let shares = fluids.map(|(index, (now, end))| {
            let rise = end.pressure - now.pressure;
            if rise <= 0.0 {
                return 1.0;
            }
            let Some(excess) = excess(model, state, index) else {
                return 1.0;
            };
            let most = self.most(model, state, (index, excess));
            let is_doubtful = end.to_blow_off || rise > excess;
            if is_doubtful && excess > 0.0 {
                most / rise
            } else {
                1.0
            }
        });
        shares.fold(1.0, f64::min)
    }

    /// By how much fluid `index` may rise from `state`, where its seal has that excess, which is noted.
    fn most(&mut self, model: &Model<'_>, state: &State, (index, excess): (usize, f64)) -> f64 {
        let pressure = state.drive.fluids[index].pressure;
        let known = Known { pressure, excess };
        let before = self.last[index].replace(known);
        let before = before.filter(|before| before.pressure < pressure);
        let problem = &model.plan.problem;
        let first = || FIRST_RISE * mean_contact(model, state, index) * problem.units.stress;
        let most = before.map_or_else(first, |before| known.rise(before));
        most.max(LEAST_RISE * problem.resolved.fluids[index].blow_off_tolerance * pressure)
    }
}

/// Whether nothing presses on a path of fluid `index` to what must stay dry: it leaks under any pressure.
pub(super) fn is_open(model: &Model<'_>, state: &State, index: usize) -> bool {
    let met = Met::at(model, state, index);
    let front = met.front(model.plan, index, &state.drive);
    let margin = front.margin(&state.wet[index]);
    margin.is_some_and(|(margin, _)| margin <= 0.0)
}

/// What the margin of a seal is above the threshold of fluid `index`, the caller's stress; none where no
/// path leads to what must stay dry.
fn excess(model: &Model<'_>, state: &State, index: usize) -> Option<f64> {
    let met = Met::at(model, state, index);
    let front = met.front(model.plan, index, &state.drive);
    let (margin, _) = front.margin(&state.wet[index])?;
    Some((margin - front.threshold) * model.plan.problem.units.stress)
}

#[cfg(test)]
mod tests {
    use super::{GROWTH, Known};

    fn is_close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-14
    }

    fn known(pressure: f64, excess: f64) -> Known {
        Known { pressure, excess }
    }

    #[test]
    fn pressure_rises_to_where_the_excess_would_end() {
        let rise = known(1.0, 0.75).rise(known(0.5, 1.0));
        assert!(is_close(rise, 1.5), "{rise}");
        let rise = known(1.0, 0.25).rise(known(0.5, 1.0));
        assert!(is_close(rise, 1.0 / 6.0), "{rise}");
    }

    #[test]
    fn a_seal_that_gains_by_the_fluid_has_no_end_in_sight_but_is_not_trusted_far() {
        let rise = known(1.0, 1.2).rise(known(0.5, 1.0));
        assert!(is_close(rise, GROWTH * 0.5), "{rise}");
    }
}
