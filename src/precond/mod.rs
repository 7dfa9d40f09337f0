//! Approximate inverses: the p-multigrid cycle of the displacement block and the
//! hierarchical methods to compare it with, the P1 solvers inside them, and the
//! metrics that stand for Schur complements.
//!
//! Index ranges, edge lists and node blocks come in as plain data; nothing
//! here knows a mesh.

pub mod compliance;
mod counted;
pub mod enriched;
pub mod fractional;
pub mod hierarchical;
pub mod lines;
pub mod node_blocks;
pub mod p1;
pub mod p_multigrid;
pub mod schur;
pub mod spectrum;
pub mod symmetric_blocks;
pub mod transfer;
pub mod triangular_sweep;

pub use counted::Counted;
pub use lines::AlongLines;
pub use node_blocks::NodeBlocks;
pub use p_multigrid::PMultigrid;
pub use transfer::Transfer;

#[cfg(test)]
mod tests;
