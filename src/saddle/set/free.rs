//! All values: the multiplier of an equality.

use super::{Admissible, Kind, SetPoint, Status};

/// The set of all x.
pub(super) struct Free;

impl Admissible for Free {
    fn project(&self, _x: &mut [f64]) {}

    fn status(&self, _x: &[f64], status: &mut [Status]) {
        status.fill(Status::Stick);
    }

    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]) {
        misfit.copy_from_slice(at.residual);
    }

    fn longest_step(&self, _x: &[f64], _direction: &[f64]) -> f64 {
        f64::INFINITY
    }

    fn kind(&self) -> Kind<'_> {
        Kind::Line
    }
}
