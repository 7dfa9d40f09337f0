//! A monitor for the tests of Krylov methods.

use super::{Monitor, Verdict};
use crate::linalg::vector::norm;

/// Stops where the norm of the residual is below a bound; counts.
pub(crate) struct Below {
    bound: f64,
    pub(crate) iterations: usize,
}

impl Below {
    pub(crate) fn new(bound: f64) -> Self {
        let iterations = 0;
        Self { bound, iterations }
    }
}

impl Monitor for Below {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        if norm(residual) < self.bound {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}
