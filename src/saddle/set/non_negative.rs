//! x >= 0: pressure pushes and never pulls.

use super::{Admissible, Kind, SetPoint, Status};

/// Of the last change: what is left of a multiplier that leaves the set.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The set of all x >= 0.
pub(super) struct NonNegative;

impl Admissible for NonNegative {
    fn project(&self, x: &mut [f64]) {
        for value in x {
            if *value <= 0.0 {
                *value = 0.0;
            }
        }
    }

    fn status(&self, x: &[f64], status: &mut [Status]) {
        for (status, &value) in status.iter_mut().zip(x) {
            *status = Status::of_contact(value > 0.0);
        }
    }

    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]) {
        let gaps = at.residual.iter().zip(at.status);
        for (misfit, (&gap, status)) in misfit.iter_mut().zip(gaps) {
            let is_right = gap > 0.0 && !status.is_closed();
            *misfit = if is_right { 0.0 } else { gap };
        }
    }

    fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        let pairs = x.iter().zip(direction).filter(|&(_, &d)| d < 0.0);
        pairs.map(|(x, d)| -x / d).fold(f64::INFINITY, f64::min)
    }

    fn kind(&self) -> Kind<'_> {
        Kind::HalfLine
    }

    fn drop_rounding(&self, x: &mut [f64], change: &[f64]) {
        for (value, &change) in x.iter_mut().zip(change) {
            if change < 0.0 && value.abs() <= ROUNDING * change.abs() {
                *value = 0.0;
            }
        }
    }
}
