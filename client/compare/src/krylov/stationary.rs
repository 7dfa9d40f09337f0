//! The stationary iteration `x += M^-1 (b - A x)`: the preconditioner on its own.
//!
//! Converges where the spectrum of M^-1 A lies in (0, 2). Per iteration: one
//! product, one preconditioner application.

use signorini::krylov::{Monitor, Outcome, Verdict};
use signorini::linalg::vector::{add_scaled, norm};
use signorini::linalg::{LinearOperator, Preconditioner, Workspace};

/// Growth of the residual that counts as divergence.
const GROWTH: f64 = 1e3;

/// The iteration for one system.
pub(crate) struct Stationary<'a> {
    /// A.
    pub(crate) operator: &'a dyn LinearOperator,
    /// M^-1.
    pub(crate) preconditioner: &'a dyn Preconditioner,
    /// Most iterations.
    pub(crate) iterations: usize,
}

impl Stationary<'_> {
    /// Improves `x` until the monitor stops; `r = b - A x` on entry and exit. Ends
    /// as stagnation where the residual grows instead.
    pub(crate) fn solve(
        &self,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let mut z = work.zeros(r.len());
        let mut product = work.zeros(r.len());
        let bound = GROWTH * norm(r);
        let mut outcome = Outcome::IterationLimit;
        for _ in 0..self.iterations {
            self.preconditioner.apply(r, &mut z, work);
            self.operator.apply(&z, &mut product, work);
            add_scaled(x, 1.0, &z);
            add_scaled(r, -1.0, &product);
            if monitor.judge(r) == Verdict::Stop {
                outcome = Outcome::Stopped;
                break;
            }
            let size = norm(r);
            if !size.is_finite() {
                outcome = Outcome::NotFinite;
                break;
            }
            if size > bound {
                outcome = Outcome::Stagnation;
                break;
            }
        }
        work.give(z);
        work.give(product);
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{Below, Scaled, rows};

    fn run(eigenvalue: f64) -> (Outcome, f64, usize) {
        let matrix = rows(&[[eigenvalue]]);
        let (mut x, mut r, mut stop) = ([0.0], [1.0], Below::new(1e-6));
        let (plain, work) = (Scaled(1.0), &mut Workspace::new());
        let method = Stationary {
            operator: &matrix,
            preconditioner: &plain,
            iterations: 100,
        };
        let outcome = method.solve((&mut x, &mut r), &mut stop, work);
        (outcome, x[0], stop.iterations)
    }

    #[test]
    fn the_error_shrinks_by_one_minus_the_eigenvalue() {
        // 0.5^20 is the first power below 1e-6.
        let (outcome, x, iterations) = run(0.5);
        assert_eq!((outcome, iterations), (Outcome::Stopped, 20));
        assert!((x - 2.0).abs() < 1e-5);
    }

    #[test]
    fn an_eigenvalue_above_two_ends_as_stagnation() {
        assert_eq!(run(3.0).0, Outcome::Stagnation);
        assert_eq!(run(f64::NAN).0, Outcome::NotFinite);
    }
}
