//! The seed's preconditioners of the displacement block, by the hierarchical
//! splitting into P1 (vertices, 1) and edge corrections (2):
//!
//! ```text
//! A = [ A11 A12 ; A21 A22 ]
//! ```
//!
//! A11 is solved by a P1 solver, A22 swept by one symmetric block Gauss-Seidel
//! pass; its condition does not depend on the mesh size. The quality of every
//! variant is bounded by the constant of the strengthened Cauchy-Schwarz
//! inequality between the two parts. M. Fortin and A. El Maliki 2007; O. Axelsson
//! and I. Gustafsson, Math. Comp. 40, 1983. Products with A12 and A21 come from
//! the matrix-free operator, which gives A11 and A22 on the way.

mod additive;
mod multiplicative;
mod symmetric;

use std::sync::Arc;

pub(crate) use additive::Additive;
pub(crate) use multiplicative::Multiplicative;
pub(crate) use symmetric::Symmetric;

use crate::precond::symmetric_blocks::SymmetricBlocks;
use crate::precond::triangular_sweep::TriangularSweep;
use signorini::linalg::{LinearOperator, Preconditioner};
use signorini::precond::node_pairs::NodePairs;

/// The two parts of the space and their solvers.
#[derive(Clone)]
pub(crate) struct Splitting {
    /// A in the hierarchical basis `[unknowns, unknowns]`: vertices first, then edges.
    pub(crate) operator: Arc<dyn LinearOperator>,
    /// Approximate inverse of A11, the P1 block.
    pub(crate) vertices: Arc<dyn Preconditioner>,
    /// Approximate inverse of A22, the block of the edge corrections.
    pub(crate) edges: Arc<dyn Preconditioner>,
    /// Number of vertex unknowns: part 1, which comes first.
    pub(crate) vertex_unknowns: usize,
}

/// One symmetric block Gauss-Seidel sweep on A22, and its bytes; `held` are
/// unknowns of the edges.
pub(crate) fn edge_sweep(
    components: usize,
    blocks: &NodePairs<'_>,
    held: impl Iterator<Item = u32>,
) -> (Arc<dyn Preconditioner>, u64) {
    match components {
        2 => shared(TriangularSweep::gauss_seidel(SymmetricBlocks::<2>::new(
            blocks, held,
        ))),
        _ => shared(TriangularSweep::gauss_seidel(SymmetricBlocks::<3>::new(
            blocks, held,
        ))),
    }
}

/// The sweep behind the trait, with the bytes that it holds.
fn shared<const C: usize>(sweep: TriangularSweep<C>) -> (Arc<dyn Preconditioner>, u64) {
    let bytes = sweep.bytes();
    (Arc::new(sweep), bytes)
}
