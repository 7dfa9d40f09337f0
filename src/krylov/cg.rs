//! Preconditioned conjugate gradients.
//!
//! Hestenes and Stiefel 1952. The preconditioner must be symmetric positive
//! definite and fixed. Per iteration: one product, one preconditioner
//! application, two reductions.

use super::{Monitor, Outcome, Verdict};
use crate::linalg::vector::{add_scaled, dot, scale_and_add};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// Conjugate gradients for one system.
pub struct Cg<'a> {
    /// A, symmetric and positive definite.
    pub operator: &'a dyn LinearOperator,
    /// Its approximate inverse, symmetric, positive definite and fixed.
    pub preconditioner: &'a dyn Preconditioner,
    /// Most iterations.
    pub iterations: usize,
}

impl Cg<'_> {
    /// Improves `x` until the monitor stops; `r = b - A x` on entry and exit.
    pub fn solve(
        &self,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let Self {
            operator,
            preconditioner,
            iterations,
        } = *self;
        let mut z = work.zeros(r.len());
        preconditioner.apply(r, &mut z, work);
        let mut p = work.copy(&z);
        let mut product = work.zeros(r.len());
        let mut rz = dot(r, &z);
        let mut outcome = Outcome::IterationLimit;
        for _ in 0..iterations {
            operator.apply(&p, &mut product, work);
            let curvature = dot(&p, &product);
            if !curvature.is_finite() || !rz.is_finite() {
                outcome = Outcome::NotFinite;
                break;
            }
            if curvature <= 0.0 {
                outcome = Outcome::Indefinite;
                break;
            }
            let alpha = rz / curvature;
            add_scaled(x, alpha, &p);
            add_scaled(r, -alpha, &product);
            if monitor.judge(r) == Verdict::Stop {
                outcome = Outcome::Stopped;
                break;
            }
            preconditioner.apply(r, &mut z, work);
            let next = dot(r, &z);
            scale_and_add(&mut p, next / rz, &z);
            rz = next;
        }
        work.give(z);
        work.give(p);
        work.give(product);
        outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::krylov::samples::Below;
    use crate::linalg::samples::Scaled;
    use crate::linalg::{SparseRows, SparseRowsBuilder};

    fn diagonal(entries: &[f64]) -> SparseRows {
        let mut builder = SparseRowsBuilder::new(entries.len());
        for (row, &value) in entries.iter().enumerate() {
            builder.push_row(&mut [(row as u32, value)]);
        }
        builder.finish()
    }

    fn run(entries: &[f64], iterations: usize) -> (Outcome, Vec<f64>, usize) {
        let matrix = diagonal(entries);
        let (mut x, mut r) = (vec![0.0; entries.len()], vec![1.0; entries.len()]);
        let mut stop = Below::new(1e-12);
        let work = &mut Workspace::new();
        let method = Cg {
            operator: &matrix,
            preconditioner: &Scaled(1.0),
            iterations,
        };
        let outcome = method.solve((&mut x, &mut r), &mut stop, work);
        (outcome, x, stop.iterations)
    }

    #[test]
    fn three_eigenvalues_take_three_iterations() {
        let entries = [1.0, 2.0, 5.0, 2.0, 1.0, 5.0];
        let (outcome, x, iterations) = run(&entries, 10);
        assert_eq!((outcome, iterations), (Outcome::Stopped, 3));
        for (value, entry) in x.iter().zip(entries) {
            assert!((value - 1.0 / entry).abs() < 1e-12);
        }
    }

    #[test]
    fn failures_have_their_types() {
        assert_eq!(run(&[1.0, 2.0, 3.0], 1).0, Outcome::IterationLimit);
        assert_eq!(run(&[1.0, -2.0], 10).0, Outcome::Indefinite);
        assert_eq!(run(&[1.0, f64::NAN], 10).0, Outcome::NotFinite);
    }
}
