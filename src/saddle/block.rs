//! The blocks of multipliers: what they constrain, how they act, where they may be.
//!
//! ```text
//! [ A   D^T ] [u]   [f]
//! [ B   -C  ] [x] = [b]    x in its set
//! ```
//!
//! B `[block, displacement]` constrains, D `[block, displacement]` acts; they may differ, and
//! nothing here assumes that they do not.

use super::{AdmissibleSet, JointModes, ProductSet, SetPart, SharedModes};
use crate::linalg::{LinearOperator, Preconditioner, SymmetricMatrix};

/// One block of a problem whose multipliers lie in an admissible set.
#[derive(Clone, Copy)]
pub struct MultiplierBlock<'a> {
    /// B `[block, displacement]`: the constraints, one a row.
    pub rows: &'a dyn LinearOperator,
    /// D `[block, displacement]`: multipliers x act on the body with D^T x. Another
    /// matrix than B where the constraint is no gradient, as in friction.
    pub columns: &'a dyn LinearOperator,
    /// C `[block, block]`, positive semi-definite; none for an exact constraint.
    pub stabilisation: Option<&'a dyn LinearOperator>,
    /// Approximation of the Schur complement B A^-1 D^T + C.
    pub metric: Metric<'a>,
    /// The product of sets in which the multipliers lie.
    pub set: ProductSet<'a>,
    /// [A D^T; B 0] in one product, where there is one that costs less than its
    /// parts; used for the first block.
    pub joint: Option<&'a dyn LinearOperator>,
}

/// How a block knows its Schur complement.
#[derive(Clone, Copy)]
pub enum Metric<'a> {
    /// An approximate inverse, positive; for multipliers that are free.
    Inverse(&'a dyn Preconditioner),
    /// A matrix, of which the part on a face of the set is factorised.
    Dense {
        /// `[block, block]`, symmetric positive definite; without rows where the
        /// weights are all of it.
        matrix: &'a dyn SymmetricMatrix,
        /// Lumped mass, scaled like the matrix `[block]`; empty for methods that do
        /// not read it.
        weights: &'a [f64],
        /// How many times stiffer than elsewhere the body is where each multiplier acts
        /// `[block]`; empty where it is the same all over.
        moduli: &'a [f64],
        /// Modes that the block shares with the first one; none where it shares none.
        shared: Option<&'a SharedModes>,
    },
}

/// One block of a linear system: an equality, its multipliers all unknown.
#[derive(Clone, Copy)]
pub struct EqualityBlock<'a> {
    /// B `[block, displacement]`: the constraints, one a row.
    pub rows: &'a dyn LinearOperator,
    /// D `[block, displacement]`: multipliers x act on the body with D^T x.
    pub columns: &'a dyn LinearOperator,
    /// C `[block, block]`, positive semi-definite; none for an exact constraint.
    pub stabilisation: Option<&'a dyn LinearOperator>,
    /// Approximate inverse of B A^-1 D^T + C, positive.
    pub metric: &'a dyn Preconditioner,
    /// Modes that the block shares with the first one; none for that.
    pub shared: Option<&'a JointModes>,
    /// [A D^T; B 0] in one product, where there is one that costs less than its
    /// parts; used for the first block.
    pub joint: Option<&'a dyn LinearOperator>,
}

impl EqualityBlock<'_> {
    /// Number of multipliers.
    pub fn size(&self) -> usize {
        self.rows.rows()
    }
}

impl<'a> MultiplierBlock<'a> {
    /// Number of multipliers.
    pub fn size(&self) -> usize {
        self.rows.rows()
    }

    /// The block as an equality; none where its set or metric asks for more.
    pub fn equality(&self) -> Option<EqualityBlock<'a>> {
        match self.metric {
            Metric::Inverse(metric) if self.set.is_free() => Some(EqualityBlock {
                rows: self.rows,
                columns: self.columns,
                stabilisation: self.stabilisation,
                metric,
                shared: None,
                joint: self.joint,
            }),
            Metric::Inverse(_) | Metric::Dense { .. } => None,
        }
    }
}

impl<'a> From<EqualityBlock<'a>> for MultiplierBlock<'a> {
    fn from(block: EqualityBlock<'a>) -> Self {
        Self {
            rows: block.rows,
            columns: block.columns,
            stabilisation: block.stabilisation,
            metric: Metric::Inverse(block.metric),
            set: ProductSet::Uniform(SetPart {
                size: block.size(),
                set: AdmissibleSet::Free,
            }),
            joint: block.joint,
        }
    }
}
