//! An approximate inverse of the displacement block about one state: at rest, made
//! with the prepared data and shared; about a deformed state, made by the session
//! that needs it.
//!
//! ```text
//! A^ ~ (A + 2/3 mu int (cof F : grad u)(cof F : grad v))^-1
//! ```
//!
//! The isochoric tangent has no volume stiffness of its own, and node blocks do not
//! smooth what nothing resists. With the second term A at rest is int 2 mu eps : eps,
//! that of linear elasticity; the pressure makes up for the difference. About a deformed state
//! all parts take the tangent at the centroid of each cell (in the plane the smoother that at the
//! points).

use std::sync::Arc;

use super::traces::TraceDirections;
use crate::linalg::{DenseMatrix, Preconditioner};
use crate::precond::NodeBlocks;

/// The parts that belong together.
pub(crate) struct ApproximateInverse {
    pub(crate) displacement: Arc<dyn Preconditioner>,
    /// A11^-1 `[vertex unknowns]`.
    pub(crate) p1: Arc<dyn Preconditioner>,
    /// How each node moves under a load on it, in flat cells with its line.
    pub(crate) node_blocks: NodeBlocks,
    /// A11^-1 on `traces`; empty without contact.
    pub(crate) compliance: Arc<DenseMatrix>,
    pub(crate) traces: TraceDirections,
    /// Of the P1 solver and the displacement preconditioner.
    pub(crate) solver_bytes: u64,
    /// Name of the P1 solver's data.
    pub(crate) p1_part: &'static str,
}

impl std::fmt::Debug for ApproximateInverse {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("ApproximateInverse")
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl ApproximateInverse {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.solver_bytes + self.node_blocks.bytes() + self.compliance.bytes() + self.traces.bytes()
    }
}
