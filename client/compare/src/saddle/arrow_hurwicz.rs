//! The seed's symmetric three-stage step: displacement, multipliers,
//! displacement again.
//!
//! ```text
//! du = A^ r_u;   dx = -a M^-1 (r_x - B du);   du += A^ (r_u - A du - B^T dx)
//! ```
//!
//! Two applications of the displacement preconditioner and one product. M is the
//! metric of the Schur complement; the ratio a of the first block comes from a
//! Rayleigh quotient on the first residual, those of the others are one: the
//! contact metric has its scale already.

use signorini::linalg::vector::{add_scaled, dot, norm, subtract_from};
use signorini::linalg::{LinearOperator, Preconditioner, Workspace};
use signorini::saddle::{BlockStep, EqualityBlock};

/// The step with its ratio of the first block.
pub(crate) struct Symmetric {
    /// a of the first block, which makes the step exact along the first residual.
    ratio: f64,
}

impl Symmetric {
    /// Takes the ratio from the `first` residuals (force, constraint).
    pub(crate) fn new(
        displacement: &dyn Preconditioner,
        block: &EqualityBlock<'_>,
        first: (&[f64], &[f64]),
        work: &mut Workspace,
    ) -> Self {
        let ratio = ratio(displacement, block, first, work);
        Self { ratio }
    }
}

impl BlockStep for Symmetric {
    fn preconditioner<'a>(
        &'a self,
        stiffness: &'a dyn LinearOperator,
        displacement: &'a dyn Preconditioner,
        blocks: &'a [EqualityBlock<'a>],
    ) -> Box<dyn Preconditioner + 'a> {
        Box::new(ArrowHurwicz {
            stiffness,
            displacement,
            blocks,
            ratio: self.ratio,
        })
    }
}

/// The three-stage step as preconditioner.
pub(crate) struct ArrowHurwicz<'a> {
    /// A `[displacement, displacement]`.
    pub(crate) stiffness: &'a dyn LinearOperator,
    /// Approximate inverse of A, for the stages that move the displacement.
    pub(crate) displacement: &'a dyn Preconditioner,
    /// The blocks in the order of the operator's unknowns.
    pub(crate) blocks: &'a [EqualityBlock<'a>],
    /// a of the first block; the stages of all others take one.
    pub(crate) ratio: f64,
}

/// The ratio that makes the step exact along q = M^-1 (r_x - B A^ r_u):
/// `q.M q / q.(B A^ B^T + C) q`; one where the residual says nothing. At most two
/// applications of `displacement`.
fn ratio(
    displacement: &dyn Preconditioner,
    block: &EqualityBlock<'_>,
    (force, constraint): (&[f64], &[f64]),
    work: &mut Workspace,
) -> f64 {
    let mut u = work.zeros(force.len());
    let mut residual = work.zeros(constraint.len());
    if norm(force) > 0.0 {
        displacement.apply(force, &mut u, work);
        block.rows.apply(&u, &mut residual, work);
    }
    subtract_from(&mut residual, constraint);
    let mut q = work.zeros(constraint.len());
    block.metric.apply(&residual, &mut q, work);
    let metric = dot(&q, &residual);
    let ratio = if metric > 0.0 {
        metric / schur_product(displacement, block, &q, &mut u, work)
    } else {
        1.0
    };
    for vector in [u, residual, q] {
        work.give(vector);
    }
    if ratio.is_finite() && ratio > 0.0 {
        ratio
    } else {
        1.0
    }
}

/// `q.(B A^ B^T + C) q`; `u` is scratch.
fn schur_product(
    displacement: &dyn Preconditioner,
    block: &EqualityBlock<'_>,
    q: &[f64],
    u: &mut [f64],
    work: &mut Workspace,
) -> f64 {
    let mut load = work.zeros(u.len());
    block.columns.apply_transposed(q, &mut load, work);
    displacement.apply(&load, u, work);
    let mut product = dot(u, &load);
    if let Some(stabilisation) = block.stabilisation {
        let mut part = work.zeros(q.len());
        stabilisation.apply(q, &mut part, work);
        product += dot(q, &part);
        work.give(part);
    }
    work.give(load);
    product
}

impl Preconditioner for ArrowHurwicz<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let (r_u, mut r_rest) = r.split_at(self.stiffness.rows());
        let (z_u, mut z_rest) = z.split_at_mut(r_u.len());
        let mut force = work.scratch(r_u.len());
        let mut transposed = work.scratch(r_u.len());
        self.displacement.apply(r_u, z_u, work);
        self.stiffness.apply(z_u, &mut force, work);
        subtract_from(&mut force, r_u);
        for (index, block) in self.blocks.iter().enumerate() {
            let (r_block, r_next) = r_rest.split_at(block.size());
            let (z_block, z_next) = z_rest.split_at_mut(block.size());
            let ratio = if index == 0 { self.ratio } else { 1.0 };
            let mut residual = work.scratch(r_block.len());
            block.rows.apply(z_u, &mut residual, work);
            subtract_from(&mut residual, r_block);
            block.metric.apply(&residual, z_block, work);
            z_block.iter_mut().for_each(|value| *value *= -ratio);
            block
                .columns
                .apply_transposed(z_block, &mut transposed, work);
            add_scaled(&mut force, -1.0, &transposed);
            work.give(residual);
            (r_rest, z_rest) = (r_next, z_next);
        }
        self.displacement.apply(&force, &mut transposed, work);
        add_scaled(z_u, 1.0, &transposed);
        work.give(force);
        work.give(transposed);
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;
    use crate::samples::{Scaled, rows};

    /// A = 4 I with its exact inverse, B = (1, 3): the Schur complement is 10 / 4.
    #[test]
    fn exact_blocks_and_the_computed_ratio_solve_the_system_in_one_step() {
        let (stiffness, coupling) = (rows(&[[4.0, 0.0], [0.0, 4.0]]), rows(&[[1.0, 3.0]]));
        let blocks = [EqualityBlock {
            shared: None,
            rows: &coupling,
            columns: &coupling,
            stabilisation: None,
            metric: &Scaled(5.0),
            joint: None,
        }];
        let (displacement, work) = (Scaled(0.25), &mut Workspace::new());
        let ratio = ratio(&displacement, &blocks[0], (&[1.0, 2.0], &[4.0]), work);
        assert!((ratio * 5.0 - 0.4).abs() < 1e-15);
        let step = ArrowHurwicz {
            stiffness: &stiffness,
            displacement: &displacement,
            blocks: &blocks,
            ratio,
        };
        let mut z = [0.0; 3];
        step.apply(&[1.0, 2.0, 4.0], &mut z, work);
        let residuals = [
            4.0 * z[0] + z[2] - 1.0,
            4.0 * z[1] + 3.0 * z[2] - 2.0,
            z[0] + 3.0 * z[1] - 4.0,
        ];
        assert!(residuals.iter().all(|r| r.abs() < 1e-14), "{residuals:?}");
    }

    #[test]
    fn a_residual_of_zero_takes_the_metric_as_it_is() {
        let coupling = rows(&[[1.0, 3.0]]);
        let block = EqualityBlock {
            shared: None,
            rows: &coupling,
            columns: &coupling,
            stabilisation: None,
            metric: &Scaled(5.0),
            joint: None,
        };
        let work = &mut Workspace::new();
        assert_eq!(ratio(&Scaled(0.25), &block, (&[0.0; 2], &[0.0]), work), 1.0);
    }
}
