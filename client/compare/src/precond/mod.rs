//! Preconditioners that the p-multigrid and its P1 solvers are compared with: the
//! seed's hierarchical methods and its P1 solver.

mod displacement;
mod hierarchical;
mod incomplete;
pub(crate) mod symmetric_blocks;
pub(crate) mod triangular_sweep;

pub(crate) use displacement::displacement;

use signorini::comparisons::WithBytes;
use signorini::precond::p1::VertexBlocks;
use signorini::scene::P1Solver;

/// The solver of the P1 block and its bytes; none for the solver's own.
pub(crate) fn p1(solver: P1Solver, blocks: &VertexBlocks<'_>) -> Option<WithBytes> {
    match solver {
        P1Solver::IcCg => Some(incomplete::incomplete_cholesky_cg(blocks)),
        P1Solver::Direct | P1Solver::Amg => None,
    }
}
