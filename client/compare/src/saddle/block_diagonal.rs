//! The block-diagonal preconditioner diag(A^, M^-1): symmetric positive definite,
//! as MINRES needs it. One application of the displacement preconditioner.

use signorini::linalg::{Preconditioner, Workspace};
use signorini::saddle::EqualityBlock;

/// Displacement preconditioner and metrics side by side.
pub(crate) struct BlockDiagonal<'a> {
    /// Approximate inverse of A, symmetric and positive definite as MINRES needs it.
    pub(crate) displacement: &'a dyn Preconditioner,
    /// The blocks in the order of the operator's unknowns; their metrics are applied
    /// with a positive sign.
    pub(crate) blocks: &'a [EqualityBlock<'a>],
}

impl Preconditioner for BlockDiagonal<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let multipliers: usize = self.blocks.iter().map(|b| b.size()).sum();
        let (r_u, mut r_rest) = r.split_at(r.len() - multipliers);
        let (z_u, mut z_rest) = z.split_at_mut(r_u.len());
        self.displacement.apply(r_u, z_u, work);
        for block in self.blocks {
            let (r_block, r_next) = r_rest.split_at(block.size());
            let (z_block, z_next) = z_rest.split_at_mut(block.size());
            block.metric.apply(r_block, z_block, work);
            (r_rest, z_rest) = (r_next, z_next);
        }
    }
}
