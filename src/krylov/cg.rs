//! Preconditioned conjugate gradients.
//!
//! Hestenes and Stiefel 1952. The preconditioner must be symmetric positive
//! definite and fixed. Per iteration: one product, one preconditioner
//! application, two reductions.

use super::{Monitor, Outcome, Verdict};
use crate::linalg::vector::{add_scaled, dot, scale_and_add};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// Improves `x` until the monitor stops; `r = b - A x` on entry and exit.
pub fn solve(
    operator: &dyn LinearOperator,
    preconditioner: &dyn Preconditioner,
    x: &mut [f64],
    r: &mut [f64],
    iterations: usize,
    monitor: &mut dyn Monitor,
    work: &mut Workspace,
) -> Outcome {
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
