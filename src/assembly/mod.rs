//! Integrates a material over a space: the matrix-free P2 operator and the
//! divergence, the same at finite strain, the assembled P1 block, node blocks, masses
//! and loads.

pub mod cells;
pub mod follower;
pub mod grid;
pub mod kernel;
pub mod lanes;
pub mod load;
pub mod mass;
pub mod node_couplings;
pub mod node_moduli;
pub mod operator;
pub mod p1_stiffness;
pub mod partition;
pub mod probe;
pub mod recovery;
pub mod simd;
pub mod strain;
pub mod transpose;

pub use cells::{CellGeometry, CellModuli};
pub use grid::Grid;
pub use operator::{Body, Constrained, Divergence, SingleStiffness, Stiffness};

#[cfg(test)]
mod tests;
