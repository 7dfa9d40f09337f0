//! Preconditioners that the p-multigrid and its P1 solvers are compared with: the
//! seed's hierarchical methods, its P1 solver, and that of the comparison elements.

mod displacement;
pub(crate) mod enriched;
pub(crate) mod hierarchical;
pub(crate) mod incomplete;
pub(crate) mod symmetric_blocks;
pub(crate) mod triangular_sweep;

pub(crate) use displacement::displacement;

use std::sync::Arc;

use crate::linalg::Preconditioner;
use crate::precond::p1::VertexBlocks;
use crate::scene::P1Solver;

/// The solver of the P1 block and its bytes; none for the solver's own.
pub(crate) fn p1(
    solver: P1Solver,
    blocks: &VertexBlocks<'_>,
) -> Option<(Arc<dyn Preconditioner>, u64)> {
    match solver {
        P1Solver::IcCg => Some(incomplete::incomplete_cholesky_cg(blocks)),
        P1Solver::Direct | P1Solver::Amg => None,
    }
}
