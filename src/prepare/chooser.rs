//! From the methods that a plan names to the code that prepares for them.

use std::sync::Arc;

use super::bodies::DisplacementBody;
use crate::compare;
use crate::linalg::Preconditioner;
use crate::precond::p1::VertexBlocks;
use crate::scene::{DisplacementMethod, P1Solver};

/// The preconditioner of the displacement block and its bytes without the P1 solver;
/// none for p-multigrid.
pub(crate) fn displacement(
    method: DisplacementMethod,
    body: &DisplacementBody<'_>,
) -> Option<(Arc<dyn Preconditioner>, u64)> {
    compare::displacement(method, body)
}

/// The solver of the P1 block and its bytes; none for factor and multigrid.
pub(crate) fn p1(
    solver: P1Solver,
    blocks: &VertexBlocks<'_>,
) -> Option<(Arc<dyn Preconditioner>, u64)> {
    compare::p1(solver, blocks)
}
