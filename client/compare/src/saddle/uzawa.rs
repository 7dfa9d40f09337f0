//! Uzawa's method with conjugate directions: nested conjugate gradients on the
//! Schur complement of one multiplier block,
//!
//! ```text
//! (B A^-1 B^T + C) x = B A^-1 f - g
//! ```
//!
//! where A^-1 is conjugate gradients on the displacement, to a fixed bound on the
//! residual: what an outer step may add to the force residual, whatever its
//! size, so that the inner iterations grow fewer as the outer ones converge
//! (V. Simoncini and D. Szyld, SIAM J. Sci. Comput. 25, 2003). The residual of the
//! whole system is carried along with all inner errors; where their sum comes
//! into sight, the displacement is corrected and the directions start anew. Each
//! inner iteration takes one product and one preconditioner application.

use signorini::krylov::cg::Cg;
use signorini::krylov::{Monitor, Outcome, Verdict};
use signorini::linalg::vector::{add_scaled, dot, norm, scale_and_add};
use signorini::linalg::{LinearOperator, Preconditioner, Workspace};
use signorini::saddle::EqualityBlock;

/// Inner iterations of one displacement solve.
const MOST_INNER: usize = 500;
/// Force residual, in multiples of the inner bound, that asks for a correction.
const DRIFT: f64 = 5.0;

/// The system and how well its inner problems are solved.
pub(crate) struct Uzawa<'a> {
    /// A `[displacement, displacement]`.
    pub(crate) stiffness: &'a dyn LinearOperator,
    /// Approximate inverse of A, symmetric positive definite.
    pub(crate) displacement: &'a dyn Preconditioner,
    /// B = D, C and the metric of the Schur complement: the method needs symmetry.
    pub(crate) block: EqualityBlock<'a>,
    /// Bound on the norm of an inner residual, non-dimensional force.
    pub(crate) inner_bound: f64,
}

/// How a run of outer iterations ended.
enum Run {
    /// The force residual has drifted: correct the displacement.
    Drifted,
    /// The outer iterations are over: converged, stopped or broken down.
    Ended(Outcome),
}

impl Uzawa<'_> {
    /// Improves `x` = (u, x) until the monitor stops; `r` = (f, g) on entry and
    /// exit. An iteration is one outer step, or a correction of the displacement.
    pub(crate) fn solve(
        &self,
        (x, r): (&mut [f64], &mut [f64]),
        iterations: usize,
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let mut left = iterations;
        while left > 0 {
            left -= 1;
            if let Some(ended) = self.correct(x, r, monitor, work) {
                return ended;
            }
            match self.run(x, r, &mut left, monitor, work) {
                Run::Drifted => (),
                Run::Ended(outcome) => return outcome,
            }
        }
        Outcome::IterationLimit
    }

    /// Solves for the displacement under the present force residual.
    fn correct(
        &self,
        x: &mut [f64],
        r: &mut [f64],
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Option<Outcome> {
        let (force, constraint) = r.split_at_mut(self.stiffness.rows());
        let mut u = work.zeros(force.len());
        let mut closing = work.zeros(constraint.len());
        let failed = self.invert(force, &mut u, monitor, work);
        self.block.rows.apply(&u, &mut closing, work);
        add_scaled(&mut x[..u.len()], 1.0, &u);
        add_scaled(constraint, -1.0, &closing);
        work.give(u);
        work.give(closing);
        failed.or_else(|| (monitor.judge(r) == Verdict::Stop).then_some(Outcome::Stopped))
    }

    /// Outer iterations until something ends them.
    fn run(
        &self,
        x: &mut [f64],
        r: &mut [f64],
        left: &mut usize,
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Run {
        let unknowns = self.stiffness.rows();
        let mut z = work.zeros(r.len() - unknowns);
        let mut direction = work.zeros(z.len());
        let mut before = 1.0;
        let mut run = Run::Ended(Outcome::IterationLimit);
        while *left > 0 {
            *left -= 1;
            // The residual of the Schur complement is -g.
            self.block.metric.apply(&r[unknowns..], &mut z, work);
            z.iter_mut().for_each(|value| *value = -*value);
            let product = -dot(&z, &r[unknowns..]);
            scale_and_add(&mut direction, product / before, &z);
            before = product;
            let failed = self.step(&direction, product, x, r, monitor, work);
            if let Some(outcome) = failed {
                run = Run::Ended(outcome);
                break;
            }
            if monitor.judge(r) == Verdict::Stop {
                run = Run::Ended(Outcome::Stopped);
                break;
            }
            if norm(&r[..unknowns]) > DRIFT * self.inner_bound {
                run = Run::Drifted;
                break;
            }
        }
        work.give(z);
        work.give(direction);
        run
    }

    /// One step along `direction`, whose product with the residual is `product`.
    fn step(
        &self,
        direction: &[f64],
        product: f64,
        x: &mut [f64],
        r: &mut [f64],
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Option<Outcome> {
        let unknowns = self.stiffness.rows();
        let mut load = work.zeros(unknowns);
        let mut u = work.zeros(unknowns);
        let mut image = work.zeros(direction.len());
        self.block
            .columns
            .apply_transposed(direction, &mut load, work);
        let mut failed = self.invert(&mut load, &mut u, monitor, work);
        self.block.rows.apply(&u, &mut image, work);
        if let Some(stabilisation) = self.block.stabilisation {
            let mut part = work.zeros(direction.len());
            stabilisation.apply(direction, &mut part, work);
            add_scaled(&mut image, 1.0, &part);
            work.give(part);
        }
        let curvature = dot(direction, &image);
        if failed.is_none() && !(curvature > 0.0 && product.is_finite()) {
            failed = Some(not_positive(curvature, product));
        }
        if failed.is_none() {
            let length = product / curvature;
            add_scaled(&mut x[..unknowns], -length, &u);
            add_scaled(&mut x[unknowns..], length, direction);
            add_scaled(&mut r[..unknowns], -length, &load);
            add_scaled(&mut r[unknowns..], length, &image);
        }
        for vector in [load, u, image] {
            work.give(vector);
        }
        failed
    }

    /// Conjugate gradients on A u = load; `load` becomes the residual.
    fn invert(
        &self,
        load: &mut [f64],
        u: &mut [f64],
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Option<Outcome> {
        if norm(load) <= self.inner_bound * f64::EPSILON {
            return None;
        }
        let mut inner = Inner {
            bound: self.inner_bound,
            outer: monitor,
            is_cancelled: false,
        };
        let method = Cg {
            operator: self.stiffness,
            preconditioner: self.displacement,
            iterations: MOST_INNER,
        };
        let outcome = method.solve((u, load), &mut inner, work);
        match outcome {
            Outcome::Stopped if !inner.is_cancelled => None,
            Outcome::Stopped
            | Outcome::IterationLimit
            | Outcome::Stagnation
            | Outcome::NotFinite
            | Outcome::Indefinite => Some(outcome),
        }
    }
}

/// The outcome where a curvature or product that must be positive is not: a number that
/// is not finite is told apart from an indefinite operator.
fn not_positive(curvature: f64, product: f64) -> Outcome {
    if curvature.is_finite() && product.is_finite() {
        Outcome::Indefinite
    } else {
        Outcome::NotFinite
    }
}

/// Stops an inner solve at its bound, or where the outer caller asks for it.
struct Inner<'a> {
    /// Bound on the residual norm at which the inner solve ends.
    bound: f64,
    /// Monitor of the outer iterations, asked after each inner one whether to stop.
    outer: &'a mut dyn Monitor,
    /// Whether the outer caller has asked to stop, so that the outer iteration can end
    /// with it.
    is_cancelled: bool,
}

impl Monitor for Inner<'_> {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.is_cancelled = self.outer.poll() == Verdict::Stop;
        if self.is_cancelled || norm(residual) <= self.bound {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{Scaled, rows};

    /// Stops below a bound, or at an inner iteration.
    struct Below {
        bound: f64,
        outer: usize,
        inner: usize,
        most_inner: usize,
    }
    impl Monitor for Below {
        fn judge(&mut self, residual: &[f64]) -> Verdict {
            self.outer += 1;
            if norm(residual) <= self.bound {
                Verdict::Stop
            } else {
                Verdict::Continue
            }
        }
        fn poll(&mut self) -> Verdict {
            self.inner += 1;
            if self.inner < self.most_inner {
                Verdict::Continue
            } else {
                Verdict::Stop
            }
        }
    }

    fn run(most_inner: usize) -> (Outcome, Vec<f64>, Below) {
        let stiffness = rows(&[[2.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 4.0]]);
        let coupling = rows(&[[1.0, 1.0, 0.0], [0.0, 1.0, -1.0]]);
        let uzawa = Uzawa {
            stiffness: &stiffness,
            displacement: &Scaled(1.0),
            block: EqualityBlock {
                shared: None,
                rows: &coupling,
                columns: &coupling,
                stabilisation: None,
                metric: &Scaled(1.0),
                joint: None,
            },
            inner_bound: 1e-12,
        };
        let (mut x, mut r) = (vec![0.0; 5], vec![1.0, -2.0, 3.0, 0.5, 1.5]);
        let mut monitor = Below {
            bound: 1e-11,
            outer: 0,
            inner: 0,
            most_inner,
        };
        let outcome = uzawa.solve((&mut x, &mut r), 20, &mut monitor, &mut Workspace::new());
        (outcome, x, monitor)
    }

    #[test]
    fn two_constraints_take_two_steps_after_the_first_displacement() {
        let (outcome, x, monitor) = run(usize::MAX);
        assert_eq!((outcome, monitor.outer), (Outcome::Stopped, 3));
        let [a, b, c, p, q] = x[..] else {
            unreachable!("five unknowns")
        };
        let residuals = [
            2.0 * a + b + p - 1.0,
            a + 3.0 * b + 0.5 * c + p + q + 2.0,
            0.5 * b + 4.0 * c - q - 3.0,
            a + b - 0.5,
            b - c - 1.5,
        ];
        assert!(residuals.iter().all(|r| r.abs() < 1e-11), "{residuals:?}");
    }

    #[test]
    fn a_stop_is_heard_inside_an_inner_solve() {
        let (outcome, _, monitor) = run(5);
        assert_eq!((outcome, monitor.inner), (Outcome::Stopped, 5));
    }
}
