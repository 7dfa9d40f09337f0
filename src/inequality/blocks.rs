//! The blocks of a problem by what the methods do with them.
//!
//! At most one block has a dense metric; it comes last, after the equalities. A method
//! that cannot take the blocks of a problem says so here, before it starts.

use super::{BlockIterate, QpIterate, QpProblem, QpStatus};
use crate::linalg::{LinearOperator, SymmetricMatrix};
use crate::saddle::{EqualityBlock, Metric, ProductSet, SharedModes};

/// Equalities and contact.
pub(crate) struct Blocks<'a> {
    /// In the order of the unknowns, before those of contact.
    pub(crate) equalities: Vec<EqualityBlock<'a>>,
    /// The block of contact and of whatever else shares its dense metric.
    pub(crate) contact: ContactBlock<'a>,
}

/// The block with a dense metric: an exact constraint on a product of sets. There is
/// one, because a second one would leave out how the two are coupled.
#[derive(Clone, Copy)]
pub struct ContactBlock<'a> {
    /// C `[multipliers, displacement]`: the constraints.
    pub rows: &'a dyn LinearOperator,
    /// D `[multipliers, displacement]`: the forces, transposed; the same as `rows`
    /// where the problem is symmetric.
    pub columns: &'a dyn LinearOperator,
    /// Dense metric `[multipliers, multipliers]`, an approximation of the Schur
    /// complement of the block.
    pub matrix: &'a dyn SymmetricMatrix,
    /// Weights of the multipliers: the integrals of their functions, or empty for
    /// methods that read none.
    pub weights: &'a [f64],
    /// How many times stiffer than elsewhere the body is where each multiplier acts; empty
    /// where it is the same all over.
    pub moduli: &'a [f64],
    /// Modes that contact shares with the first block.
    pub shared: Option<&'a SharedModes>,
    /// The product of sets in which the multipliers lie.
    pub set: ProductSet<'a>,
}

impl<'a> Blocks<'a> {
    /// Of that problem, whose iterate must have the same list.
    ///
    /// # Errors
    /// [`QpStatus::Unsupported`] for another list than equalities and one dense block.
    pub(crate) fn of(problem: &QpProblem<'a>, iterate: &QpIterate) -> Result<Self, QpStatus> {
        if problem.blocks.len() != iterate.blocks.len() {
            return Err(QpStatus::Unsupported);
        }
        let (last, others) = problem.blocks.split_last().ok_or(QpStatus::Unsupported)?;
        let equalities: Option<Vec<_>> = others.iter().map(|block| block.equality()).collect();
        let exact = last.stabilisation.is_none() && last.joint.is_none();
        match (equalities, last.metric) {
            (
                Some(equalities),
                Metric::Dense {
                    matrix,
                    weights,
                    moduli,
                    shared,
                },
            ) if exact => Ok(Self {
                equalities,
                contact: ContactBlock {
                    rows: last.rows,
                    columns: last.columns,
                    matrix,
                    weights,
                    moduli,
                    shared,
                    set: last.set,
                },
            }),
            _ => Err(QpStatus::Unsupported),
        }
    }

    /// Place of contact in the list.
    pub(crate) fn place(&self) -> usize {
        self.equalities.len()
    }

    /// The iterate of contact.
    pub(crate) fn contact_of<'i>(&self, iterate: &'i QpIterate) -> &'i BlockIterate {
        &iterate.blocks[self.place()]
    }

    /// Number of unknowns of all equalities.
    pub(crate) fn equality_unknowns(&self) -> usize {
        self.equalities.iter().map(EqualityBlock::size).sum()
    }
}
