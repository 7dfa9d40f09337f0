//! Preconditioned MINRES for symmetric indefinite systems.
//!
//! C. Paige and M. Saunders, SIAM J. Numer. Anal. 12, 1975, in the form of
//! H. Elman, D. Silvester and A. Wathen, Finite Elements and Fast Iterative
//! Solvers, algorithm 4.1. The preconditioner must be symmetric positive definite
//! and fixed; the residual is least in the norm of the preconditioner. Per
//! iteration: one product, one preconditioner application, two reductions. The
//! products of the directions are carried along, so that the residual is there to
//! judge: nine vectors in all.

use signorini::krylov::{Monitor, Outcome, Verdict};
use signorini::linalg::vector::{add_scaled, dot, scale, scale_and_add};
use signorini::linalg::{LinearOperator, Preconditioner, Workspace};

/// The Lanczos process of the preconditioned operator.
struct Lanczos {
    /// The last two basis vectors `[2][unknowns]`, oldest first, orthonormal in the
    /// preconditioned product.
    basis: [Vec<f64>; 2],
    /// The last one, preconditioned and of unit length.
    z: Vec<f64>,
    /// Norms of the last two vectors in the preconditioned product, oldest first.
    lengths: [f64; 2],
}

/// A direction of the solution and its product with the operator.
struct Direction {
    /// Change of the solution along the direction `[unknowns]`.
    step: Vec<f64>,
    /// Product of the operator with that change `[unknowns]`, carried along so that the
    /// residual is known without a further product.
    product: Vec<f64>,
}

/// The least-squares problem by Givens rotations; pairs are oldest first.
struct Rotations {
    /// Cosines of the last two rotations.
    cosines: [f64; 2],
    /// Sines of the last two rotations.
    sines: [f64; 2],
    /// The last two directions, which the next one is made from.
    directions: [Direction; 2],
    /// Preconditioned norm of what is left of the residual, with the sign that the
    /// rotations gave it.
    rest: f64,
}

/// The method for one system.
pub(crate) struct Minres<'a> {
    /// A, symmetric.
    pub(crate) operator: &'a dyn LinearOperator,
    /// Its approximate inverse, symmetric, positive definite and fixed.
    pub(crate) preconditioner: &'a dyn Preconditioner,
    /// Most iterations.
    pub(crate) iterations: usize,
}

impl Minres<'_> {
    /// Improves `x` until the monitor stops; `r = b - A x` on entry and exit.
    pub(crate) fn solve(
        &self,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let mut lanczos = Lanczos {
            basis: [work.zeros(r.len()), work.copy(r)],
            z: work.zeros(r.len()),
            lengths: [1.0; 2],
        };
        let start = lanczos.precondition(self.preconditioner, work);
        let mut rotations = Rotations {
            cosines: [1.0; 2],
            sines: [0.0; 2],
            directions: std::array::from_fn(|_| Direction {
                step: work.zeros(r.len()),
                product: work.zeros(r.len()),
            }),
            rest: lanczos.lengths[1],
        };
        let mut outcome = start.err().unwrap_or(Outcome::IterationLimit);
        for _ in 0..self.iterations {
            if outcome != Outcome::IterationLimit {
                break;
            }
            match self.iterate(&mut lanczos, &mut rotations, work) {
                Err(failed) => outcome = failed,
                Ok(step) => {
                    let newest = &rotations.directions[1];
                    add_scaled(x, step, &newest.step);
                    add_scaled(r, -step, &newest.product);
                    if monitor.judge(r) == Verdict::Stop {
                        outcome = Outcome::Stopped;
                    }
                }
            }
        }
        let Lanczos { basis, z, .. } = lanczos;
        let directions = rotations.directions.map(|d| [d.step, d.product]);
        let used = basis.into_iter().chain([z]);
        used.chain(directions.into_iter().flatten())
            .for_each(|vector| work.give(vector));
        outcome
    }

    /// One iteration; returns the length of the step along the newest direction.
    fn iterate(
        &self,
        lanczos: &mut Lanczos,
        rotations: &mut Rotations,
        work: &mut Workspace,
    ) -> Result<f64, Outcome> {
        let length = lanczos.lengths[1];
        if length == 0.0 {
            return Err(Outcome::Stagnation);
        }
        scale(&mut lanczos.z, 1.0 / length);
        let mut product = work.scratch(lanczos.z.len());
        self.operator.apply(&lanczos.z, &mut product, work);
        let diagonal = dot(&product, &lanczos.z);
        let step = work.copy(&lanczos.z);
        lanczos.extend(&product, diagonal);
        lanczos.precondition(self.preconditioner, work)?;
        let newest = Direction { step, product };
        let column = [length, diagonal, lanczos.lengths[1]];
        Ok(rotations.turn(newest, column, work))
    }
}

impl Lanczos {
    /// The next basis vector from the `product` with the last one.
    fn extend(&mut self, product: &[f64], diagonal: f64) {
        let [before, last] = self.lengths;
        let [oldest, newest] = &mut self.basis;
        scale_and_add(oldest, -last / before, product);
        add_scaled(oldest, -diagonal / last, newest);
        std::mem::swap(oldest, newest);
    }

    /// Preconditions the last basis vector and takes its length.
    fn precondition(
        &mut self,
        preconditioner: &dyn Preconditioner,
        work: &mut Workspace,
    ) -> Result<(), Outcome> {
        preconditioner.apply(&self.basis[1], &mut self.z, work);
        let square = dot(&self.z, &self.basis[1]);
        if !square.is_finite() {
            return Err(Outcome::NotFinite);
        }
        if square < 0.0 {
            return Err(Outcome::Indefinite);
        }
        self.lengths = [self.lengths[1], square.sqrt()];
        Ok(())
    }
}

impl Rotations {
    /// Takes the next column of the tridiagonal matrix in; gives the length of the
    /// step along its direction.
    fn turn(
        &mut self,
        mut newest: Direction,
        [above, diagonal, below]: [f64; 3],
        work: &mut Workspace,
    ) -> f64 {
        let ([c0, c1], [s0, s1]) = (self.cosines, self.sines);
        let turned = c1 * diagonal - c0 * s1 * above;
        let pivot = turned.hypot(below);
        let weights = [s0 * above, s1 * diagonal + c0 * c1 * above];
        for (weight, old) in weights.into_iter().zip(&self.directions) {
            add_scaled(&mut newest.step, -weight, &old.step);
            add_scaled(&mut newest.product, -weight, &old.product);
        }
        scale(&mut newest.step, 1.0 / pivot);
        scale(&mut newest.product, 1.0 / pivot);
        self.directions.swap(0, 1);
        let oldest = std::mem::replace(&mut self.directions[1], newest);
        work.give(oldest.step);
        work.give(oldest.product);
        (self.cosines, self.sines) = ([c1, turned / pivot], [s1, below / pivot]);
        let step = self.cosines[1] * self.rest;
        self.rest *= -self.sines[1];
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{Below, Scaled, rows};
    use signorini::linalg::SparseRows;
    use signorini::linalg::vector::norm;

    /// Indefinite.
    fn saddle() -> SparseRows {
        rows(&[[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    }

    fn run(factor: f64, iterations: usize) -> (Outcome, Vec<f64>, Vec<f64>, usize) {
        let (mut x, mut r) = (vec![0.0; 3], vec![1.0, 2.0, 3.0]);
        let (mut stop, work) = (Below::new(1e-12), &mut Workspace::new());
        let (matrix, scaled) = (saddle(), Scaled(factor));
        let outcome = Minres {
            operator: &matrix,
            preconditioner: &scaled,
            iterations,
        }
        .solve((&mut x, &mut r), &mut stop, work);
        (outcome, x, r, stop.iterations)
    }

    #[test]
    fn an_indefinite_system_of_three_takes_three_iterations() {
        let (outcome, x, r, iterations) = run(0.3, 10);
        assert_eq!((outcome, iterations), (Outcome::Stopped, 3));
        let mut product = vec![0.0; 3];
        saddle().apply(&x, &mut product, &mut Workspace::new());
        for ((value, exact), rest) in product.iter().zip([1.0, 2.0, 3.0]).zip(&r) {
            assert!((value - exact).abs() < 1e-12 && rest.abs() < 1e-12);
        }
    }

    #[test]
    fn the_carried_residual_is_that_of_the_iterate() {
        let (outcome, x, r, _) = run(0.3, 2);
        assert_eq!(outcome, Outcome::IterationLimit);
        let mut product = vec![0.0; 3];
        saddle().apply(&x, &mut product, &mut Workspace::new());
        for ((value, exact), rest) in product.iter().zip([1.0, 2.0, 3.0]).zip(&r) {
            assert!((exact - value - rest).abs() < 1e-13);
        }
        assert!(norm(&r) > 1e-3);
    }

    #[test]
    fn an_indefinite_preconditioner_has_its_type() {
        assert_eq!(run(-1.0, 10).0, Outcome::Indefinite);
        assert_eq!(run(f64::NAN, 10).0, Outcome::NotFinite);
    }
}
