//! The displacement problem with multiplier blocks:
//!
//! ```text
//! [ A   D1^T  D2^T ] [u ]   [f ]
//! [ B1  -C1        ] [x1] = [g1]      x_i in its admissible set
//! [ B2        -C2  ] [x2]   [g2]
//! ```
//!
//! B_i are the rows of a block, D_i its columns: how its multipliers act. They are
//! the same matrix where the problem has an energy. Internal pressure and contact
//! pressure are blocks of the same kind; what a scene does not need is a shorter
//! list. On a face of the admissible sets every block is an equality, and the
//! system above is linear: [`SaddleOperator`]. Vectors are the concatenation of
//! displacement and blocks. The preconditioner is the upper block triangle:
//! multipliers first, by their metrics, then one application of the
//! displacement preconditioner.

mod block;
mod joint;
mod set;

use crate::linalg::vector::scale;
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

pub use block::{EqualityBlock, Metric, MultiplierBlock};
pub use joint::{JointModes, SharedModes};
pub use set::{
    Admissible, AdmissibleSet, Components, Cones, Discs, FrictionBound, Kind, PairProblem,
    PointSet, ProductSet, SetPart, SetPoint, Status,
};

/// A block step that preconditions a flexible method.
pub trait BlockStep {
    /// The step on the given blocks.
    fn preconditioner<'a>(
        &'a self,
        stiffness: &'a dyn LinearOperator,
        displacement: &'a dyn Preconditioner,
        blocks: &'a [EqualityBlock<'a>],
    ) -> Box<dyn Preconditioner + 'a>;
}

/// The step of [`BlockTriangular`]: one displacement application.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpperTriangular {
    /// Share of D1^T dx1 that moves the displacement. One, but 1 + gamma over the
    /// whole pressure step for a displacement preconditioner of
    /// A + gamma D1^T M1^-1 B1, whose right-hand side is f + gamma D1^T M1^-1 g1: the
    /// system is the same one, and so is the step but for this share.
    pub share: f64,
}

impl BlockStep for UpperTriangular {
    fn preconditioner<'a>(
        &'a self,
        _stiffness: &'a dyn LinearOperator,
        displacement: &'a dyn Preconditioner,
        blocks: &'a [EqualityBlock<'a>],
    ) -> Box<dyn Preconditioner + 'a> {
        Box::new(BlockTriangular {
            displacement,
            blocks,
            share: self.share,
        })
    }
}

/// The block operator.
pub struct SaddleOperator<'a> {
    /// A `[displacement, displacement]`.
    pub stiffness: &'a dyn LinearOperator,
    /// What is taken off A: the curvature of a gap, or nothing.
    pub geometric: Option<&'a dyn LinearOperator>,
    /// The blocks, in the order of their unknowns after the displacement.
    pub blocks: &'a [EqualityBlock<'a>],
}

impl LinearOperator for SaddleOperator<'_> {
    fn rows(&self) -> usize {
        let multipliers: usize = self.blocks.iter().map(|b| b.size()).sum();
        self.stiffness.rows() + multipliers
    }

    fn columns(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let joint = self.blocks.first().and_then(|block| block.joint);
        match joint {
            Some(joint) => joint.apply(&x[..joint.columns()], &mut y[..joint.rows()], work),
            None => {
                let size = self.stiffness.rows();
                self.stiffness.apply(&x[..size], &mut y[..size], work);
            }
        }
        let (u, mut multipliers) = x.split_at(self.stiffness.rows());
        let (force, mut constraints) = y.split_at_mut(self.stiffness.rows());
        if let Some(geometric) = self.geometric {
            geometric.subtract_product(u, force, work);
        }
        for (index, block) in self.blocks.iter().enumerate() {
            let (x_block, x_rest) = multipliers.split_at(block.size());
            let (y_block, y_rest) = constraints.split_at_mut(block.size());
            if index > 0 || joint.is_none() {
                block.rows.apply(u, y_block, work);
                block.columns.add_transposed(1.0, x_block, force, work);
            }
            if let Some(stabilisation) = block.stabilisation {
                stabilisation.subtract_product(x_block, y_block, work);
            }
            (multipliers, constraints) = (x_rest, y_rest);
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        let (u, mut constraints) = y.split_at(self.stiffness.rows());
        let (force, mut multipliers) = x.split_at_mut(self.stiffness.rows());
        self.stiffness.apply_transposed(u, force, work);
        if let Some(geometric) = self.geometric {
            geometric.add_transposed(-1.0, u, force, work);
        }
        for block in self.blocks {
            let (y_block, y_rest) = constraints.split_at(block.size());
            let (x_block, x_rest) = multipliers.split_at_mut(block.size());
            block.rows.add_transposed(1.0, y_block, force, work);
            block.columns.apply(u, x_block, work);
            if let Some(stabilisation) = block.stabilisation {
                stabilisation.add_transposed(-1.0, y_block, x_block, work);
            }
            (constraints, multipliers) = (y_rest, x_rest);
        }
    }
}

/// Upper block-triangular preconditioner:
/// `dx_i = -M_i^-1 r_i`, `du = A^ (r_u - sum D_i^T dx_i)`; modes that a block shares with
/// the first one are solved for jointly.
pub struct BlockTriangular<'a> {
    /// Approximate inverse of A, applied once a step.
    pub displacement: &'a dyn Preconditioner,
    /// The blocks in the order of the operator's unknowns.
    pub blocks: &'a [EqualityBlock<'a>],
    /// Of D1^T dx1 that moves the displacement; one without augmentation.
    pub share: f64,
}

impl Preconditioner for BlockTriangular<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let multipliers: usize = self.blocks.iter().map(|b| b.size()).sum();
        let (r_u, r) = r.split_at(r.len() - multipliers);
        let (z_u, z) = z.split_at_mut(r_u.len());
        let mut force = work.copy(r_u);
        if let Some((first, others)) = self.blocks.split_first() {
            let (r_first, mut r_rest) = r.split_at(first.size());
            let (z_first, mut z_rest) = z.split_at_mut(first.size());
            step_of(first, r_first, z_first, work);
            let mut moving = work.copy(z_first);
            scale(&mut moving, self.share);
            for block in others {
                let (r_block, r_next) = r_rest.split_at(block.size());
                let (z_block, z_next) = z_rest.split_at_mut(block.size());
                joint_step(block, (r_first, r_block), z_block, work);
                if let Some(modes) = block.shared {
                    let amplitudes = modes.behind(z_block, work);
                    modes.add(&amplitudes, z_first, work);
                    modes.add(&amplitudes, &mut moving, work);
                    work.give(amplitudes);
                }
                let columns = block.columns;
                columns.add_transposed(-1.0, z_block, &mut force, work);
                (r_rest, z_rest) = (r_next, z_next);
            }
            let columns = first.columns;
            columns.add_transposed(-1.0, &moving, &mut force, work);
            work.give(moving);
        }
        self.displacement.apply(&force, z_u, work);
        work.give(force);
    }
}

/// The step of one block by its metric.
fn step_of(block: &EqualityBlock<'_>, r: &[f64], z: &mut [f64], work: &mut Workspace) {
    block.metric.apply(r, z, work);
    z.iter_mut().for_each(|value| *value = -*value);
}

/// The step of one block after what the first one leaves of the modes that they share.
fn joint_step(
    block: &EqualityBlock<'_>,
    (r_first, r): (&[f64], &[f64]),
    z: &mut [f64],
    work: &mut Workspace,
) {
    let mut rest = work.copy(r);
    if let Some(modes) = block.shared {
        modes.reduce(r_first, &mut rest, work);
    }
    step_of(block, &rest, z, work);
    work.give(rest);
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;
    use crate::linalg::DenseMatrix;
    use crate::linalg::samples::{Scaled, rows};
    use crate::linalg::vector::dot;

    #[test]
    fn the_operator_matches_its_blocks_and_is_as_symmetric_as_they_are() {
        let stiffness = rows(&[[2.0, -1.0], [-1.0, 2.0]]);
        let coupling = rows(&[[1.0, 3.0]]);
        let stabilisation = rows(&[[0.5]]);
        let blocks = [EqualityBlock {
            rows: &coupling,
            columns: &coupling,
            stabilisation: Some(&stabilisation),
            shared: None,
            metric: &Scaled(1.0),
            joint: None,
        }];
        let saddle = SaddleOperator {
            stiffness: &stiffness,
            geometric: None,
            blocks: &blocks,
        };
        let mut work = Workspace::new();
        let (x, y) = ([1.0, 2.0, 3.0], [-0.5, 0.25, 4.0]);
        let (mut kx, mut ky) = ([0.0; 3], [0.0; 3]);
        saddle.apply(&x, &mut kx, &mut work);
        saddle.apply(&y, &mut ky, &mut work);
        assert_eq!(kx, [3.0, 12.0, 5.5]);
        assert!((dot(&kx, &y) - dot(&ky, &x)).abs() < 1e-14);
    }

    #[test]
    fn the_transposed_operator_is_the_adjoint_where_rows_and_columns_differ() {
        let stiffness = rows(&[[2.0, -1.0], [0.5, 3.0]]);
        let geometric = rows(&[[0.1, 0.2], [0.0, 0.3]]);
        let (constraints, columns) = (rows(&[[1.0, 3.0]]), rows(&[[-2.0, 0.5]]));
        let stabilisation = rows(&[[0.5]]);
        let blocks = [EqualityBlock {
            rows: &constraints,
            columns: &columns,
            stabilisation: Some(&stabilisation),
            shared: None,
            metric: &Scaled(1.0),
            joint: None,
        }];
        let saddle = SaddleOperator {
            stiffness: &stiffness,
            geometric: Some(&geometric),
            blocks: &blocks,
        };
        let mut work = Workspace::new();
        let (x, y) = ([1.0, 2.0, 3.0], [-0.5, 0.25, 4.0]);
        let (mut kx, mut ky) = ([0.0; 3], [0.0; 3]);
        saddle.apply(&x, &mut kx, &mut work);
        saddle.apply_transposed(&y, &mut ky, &mut work);
        assert!((dot(&kx, &y) - dot(&x, &ky)).abs() < 1e-14);
        // K is not symmetric, and the columns are what acts on the body.
        saddle.apply(&y, &mut ky, &mut work);
        assert!((dot(&kx, &y) - dot(&x, &ky)).abs() > 1.0);
        assert!((kx[0] - (2.0 - 2.0 - 0.1 - 0.4 - 6.0)).abs() < 1e-14);
    }

    #[test]
    fn the_preconditioner_solves_its_own_triangle() {
        let coupling = rows(&[[1.0, 3.0]]);
        let blocks = [EqualityBlock {
            rows: &coupling,
            columns: &coupling,
            stabilisation: None,
            shared: None,
            metric: &Scaled(0.5),
            joint: None,
        }];
        let triangular = BlockTriangular {
            displacement: &Scaled(0.25),
            blocks: &blocks,
            share: 1.0,
        };
        let mut z = [0.0; 3];
        triangular.apply(&[1.0, 2.0, 4.0], &mut z, &mut Workspace::new());
        assert_eq!(z, [0.25 * (1.0 + 2.0), 0.25 * (2.0 + 6.0), -2.0]);
    }

    #[test]
    fn two_blocks_that_act_alike_are_solved_together() {
        // Both press on the one displacement: S = [y + slack, y; y, y] for the flexibility y.
        let (flexibility, slack) = (2.0, 1e-6);
        let coupling = rows(&[[1.0]]);
        let work = flexibility + slack;
        let mut gram = DenseMatrix::zeros(1, 1);
        *gram.at_mut(0, 0) = work;
        let modes = SharedModes {
            first: rows(&[[1.0]]),
            alike: rows(&[[1.0]]),
            own: rows(&[[flexibility]]),
            work: gram,
            least_share: 0.0,
        };
        let modes = modes.on_face(&[0], &[1.0]);
        let own_part = flexibility - flexibility * flexibility / work;
        let (of_first, of_second) = (Scaled(1.0 / work), Scaled(1.0 / own_part));
        let block = |metric, shared| EqualityBlock {
            rows: &coupling,
            columns: &coupling,
            stabilisation: None,
            metric,
            shared,
            joint: None,
        };
        let blocks = [block(&of_first, None), block(&of_second, Some(&modes))];
        let triangular = BlockTriangular {
            displacement: &Scaled(flexibility),
            blocks: &blocks,
            share: 1.0,
        };
        let (r, mut z) = ([0.0, 0.3, 0.5], [0.0; 3]);
        triangular.apply(&r, &mut z, &mut Workspace::new());
        let left = [
            r[1] + work * z[1] + flexibility * z[2],
            r[2] + flexibility * z[1] + flexibility * z[2],
        ];
        assert!(left.iter().all(|left| left.abs() < 1e-8), "{left:?} {z:?}");
    }
}
