//! Approximate inverses: the p-multigrid cycle of the displacement block, the
//! P1 solvers inside it, and the metrics that stand for Schur complements.
//!
//! Index ranges, edge lists and node blocks come in as plain data; nothing
//! here knows a mesh.

pub mod compliance;
pub mod lines;
pub mod node_blocks;
pub mod p1;
pub mod p_multigrid;
pub mod schur;
pub mod spectrum;
pub mod transfer;

pub use lines::{AlongLines, NodePairs};
pub use node_blocks::NodeBlocks;
pub use p_multigrid::PMultigrid;
pub use transfer::Transfer;

#[cfg(test)]
mod tests;
