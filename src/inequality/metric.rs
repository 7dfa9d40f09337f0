//! Metrics H of the multiplier: projections in them, and the scale that makes
//! H >= B A^-1 D^T about.

use super::dense_cone::{self, DenseSolution};
use super::{BlockIterate, QpStatus};
use crate::linalg::vector::{dot, norm, scale};
use crate::linalg::{LinearOperator, Preconditioner, SparseRows, SymmetricMatrix, Workspace};
use crate::saddle::ProductSet;

/// Steps of the power iteration; the first vector is nearly right.
pub const POWER_STEPS: usize = 5;

/// argmin { 1/2 |x - l|_H^2 + gap.x : x in the set } and what each x does.
pub fn nearest(
    metric: &dyn SymmetricMatrix,
    set: ProductSet<'_>,
    contact: &BlockIterate,
) -> Result<DenseSolution, QpStatus> {
    let mut linear = vec![0.0; contact.residual.len()];
    metric.product(&contact.multiplier, &mut linear);
    for (q, gap) in linear.iter_mut().zip(&contact.residual) {
        *q = gap - *q;
    }
    let near = (&contact.status[..], &contact.multiplier[..]);
    let solution = dense_cone::solve(metric, &linear, set, near);
    solution.map_err(|_| QpStatus::IndefiniteMetric)
}

/// The largest eigenvalue of H^-1 C A^ C^T by power iteration from a constant
/// pressure; `inverse` applies H^-1 in place. Costs [`POWER_STEPS`] applications
/// of A^.
pub fn largest_ratio(
    displacement: &dyn Preconditioner,
    coupling: &SparseRows,
    inverse: &dyn Fn(&mut [f64]),
    work: &mut Workspace,
) -> f64 {
    let mut x = vec![1.0; coupling.rows()];
    let mut y = vec![0.0; coupling.rows()];
    let mut load = work.zeros(coupling.columns());
    let mut move_by_load = work.zeros(coupling.columns());
    let mut ratio = 1.0;
    for _ in 0..POWER_STEPS {
        coupling.apply_transposed(&x, &mut load, work);
        displacement.apply(&load, &mut move_by_load, work);
        coupling.apply(&move_by_load, &mut y, work);
        let energy = dot(&x, &y);
        let mut next = y.clone();
        inverse(&mut next);
        ratio = dot(&y, &next) / energy;
        let length = norm(&next);
        scale(&mut next, 1.0 / length);
        x = next;
    }
    work.give(load);
    work.give(move_by_load);
    ratio
}
