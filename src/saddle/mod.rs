//! The displacement problem with multiplier blocks:
//!
//! ```text
//! [ A   B1^T  B2^T ] [u ]   [f ]
//! [ B1  -C1        ] [x1] = [g1]
//! [ B2        -C2  ] [x2]   [g2]
//! ```
//!
//! Internal pressure and contact pressure are blocks of the same kind; what a
//! scene does not need is a shorter list. Vectors are the concatenation of
//! displacement and blocks. The preconditioner is the upper block triangle:
//! multipliers first, by their metrics, then one application of the
//! displacement preconditioner. The other files hold what it is compared with.

mod arrow_hurwicz;
mod block_diagonal;
mod uzawa;

use crate::linalg::{LinearOperator, Preconditioner, Workspace};

pub use arrow_hurwicz::{ArrowHurwicz, ratio as arrow_hurwicz_ratio};
pub use block_diagonal::BlockDiagonal;
pub use uzawa::Uzawa;

/// The block step that preconditions a flexible method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockStep {
    /// [`BlockTriangular`]: one displacement application.
    UpperTriangular,
    /// The same for a displacement preconditioner of A + gamma B1^T M1^-1 B1, whose
    /// right-hand side is f + gamma B1^T M1^-1 g1: the system is the same one, and
    /// so is the step but for the share of B1^T dx1 that moves the displacement.
    Augmented {
        /// 1 + gamma over the whole pressure step.
        share: f64,
    },
    /// [`ArrowHurwicz`]: two of them.
    ArrowHurwicz {
        /// Of the first block.
        ratio: f64,
    },
}

/// One multiplier block.
#[derive(Clone, Copy)]
pub struct MultiplierBlock<'a> {
    /// B `[block, displacement]`.
    pub coupling: &'a dyn LinearOperator,
    /// C `[block, block]`, positive semi-definite; none for an exact constraint.
    pub stabilisation: Option<&'a dyn LinearOperator>,
    /// Approximate inverse of B A^-1 B^T + C, positive.
    pub metric: &'a dyn Preconditioner,
    /// [A B^T; B 0] in one product, where there is one that costs less than its
    /// parts; used for the first block.
    pub joint: Option<&'a dyn LinearOperator>,
}

/// The block operator.
pub struct SaddleOperator<'a> {
    /// A `[displacement, displacement]`.
    pub stiffness: &'a dyn LinearOperator,
    /// What is taken off A: the curvature of a gap, or nothing.
    pub released: Option<&'a dyn LinearOperator>,
    /// In the order of the unknowns.
    pub blocks: &'a [MultiplierBlock<'a>],
}

impl LinearOperator for SaddleOperator<'_> {
    fn rows(&self) -> usize {
        let multipliers: usize = self.blocks.iter().map(|b| b.coupling.rows()).sum();
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
        if let Some(released) = self.released {
            released.subtract_product(u, force, work);
        }
        for (index, block) in self.blocks.iter().enumerate() {
            let (x_block, x_rest) = multipliers.split_at(block.coupling.rows());
            let (y_block, y_rest) = constraints.split_at_mut(block.coupling.rows());
            if index > 0 || joint.is_none() {
                block.coupling.apply(u, y_block, work);
                block.coupling.add_transposed(1.0, x_block, force, work);
            }
            if let Some(stabilisation) = block.stabilisation {
                stabilisation.subtract_product(x_block, y_block, work);
            }
            (multipliers, constraints) = (x_rest, y_rest);
        }
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

/// Upper block-triangular preconditioner:
/// `dx_i = -M_i^-1 r_i`, `du = A^ (r_u - sum B_i^T dx_i)`.
pub struct BlockTriangular<'a> {
    /// Approximate inverse of A.
    pub displacement: &'a dyn Preconditioner,
    /// As in the operator.
    pub blocks: &'a [MultiplierBlock<'a>],
    /// Of B1^T dx1 that moves the displacement; one without augmentation.
    pub share: f64,
}

impl Preconditioner for BlockTriangular<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let multipliers: usize = self.blocks.iter().map(|b| b.coupling.rows()).sum();
        let (r_u, mut r_rest) = r.split_at(r.len() - multipliers);
        let (z_u, mut z_rest) = z.split_at_mut(r_u.len());
        let mut force = work.copy(r_u);
        for (index, block) in self.blocks.iter().enumerate() {
            let share = if index == 0 { self.share } else { 1.0 };
            let (r_block, r_next) = r_rest.split_at(block.coupling.rows());
            let (z_block, z_next) = z_rest.split_at_mut(block.coupling.rows());
            block.metric.apply(r_block, z_block, work);
            z_block.iter_mut().for_each(|value| *value = -*value);
            block
                .coupling
                .add_transposed(-share, z_block, &mut force, work);
            (r_rest, z_rest) = (r_next, z_next);
        }
        self.displacement.apply(&force, z_u, work);
        work.give(force);
    }
}

impl BlockStep {
    /// The step on the given blocks.
    pub fn preconditioner<'a>(
        self,
        stiffness: &'a dyn LinearOperator,
        displacement: &'a dyn Preconditioner,
        blocks: &'a [MultiplierBlock<'a>],
    ) -> Box<dyn Preconditioner + 'a> {
        match self {
            Self::UpperTriangular => Box::new(BlockTriangular {
                displacement,
                blocks,
                share: 1.0,
            }),
            Self::Augmented { share } => Box::new(BlockTriangular {
                displacement,
                blocks,
                share,
            }),
            Self::ArrowHurwicz { ratio } => Box::new(ArrowHurwicz {
                stiffness,
                displacement,
                blocks,
                ratio,
            }),
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // These values are exact.
mod tests {
    use super::*;
    use crate::linalg::samples::{Scaled, rows};
    use crate::linalg::vector::dot;

    #[test]
    fn the_operator_is_symmetric_and_matches_its_blocks() {
        let stiffness = rows(&[[2.0, -1.0], [-1.0, 2.0]]);
        let coupling = rows(&[[1.0, 3.0]]);
        let stabilisation = rows(&[[0.5]]);
        let blocks = [MultiplierBlock {
            coupling: &coupling,
            stabilisation: Some(&stabilisation),
            metric: &Scaled(1.0),
            joint: None,
        }];
        let saddle = SaddleOperator {
            stiffness: &stiffness,
            released: None,
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
    fn the_preconditioner_solves_its_own_triangle() {
        let coupling = rows(&[[1.0, 3.0]]);
        let blocks = [MultiplierBlock {
            coupling: &coupling,
            stabilisation: None,
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
}
