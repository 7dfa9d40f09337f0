//! Approximate inverses: the p-multigrid cycle of the displacement block, the P1
//! solvers inside it, and the metrics that stand for Schur complements.
//!
//! Index ranges, edge lists and node blocks come in as plain data; nothing
//! here knows a mesh.

mod chebyshev;
pub mod coarse_schur;
pub mod compliance;
mod counted;
pub mod fractional;
pub mod lines;
pub mod node_blocks;
pub mod node_pairs;
pub mod p1;
pub mod p_multigrid;
pub mod schur;
pub mod spectrum;
pub mod transfer;
pub mod volume_modes;

pub use counted::Counted;
pub use lines::AlongLines;
pub use node_blocks::NodeBlocks;
pub use p_multigrid::PMultigrid;
pub use transfer::Transfer;

#[cfg(test)]
mod tests;
