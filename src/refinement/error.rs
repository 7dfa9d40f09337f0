//! Why a mesh is not refined.

use thiserror::Error;

use crate::mesh::MeshError;

/// Why there is no refined mesh; the old one stays.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RefinementError {
    /// A marked cell that is not there.
    #[error("cell {cell} is marked, but the mesh has {count} cells, counted from 0")]
    NoSuchCell {
        /// The first such cell, 0-based.
        cell: u32,
        /// Number of cells.
        count: usize,
    },
    /// The closure would pass the limit.
    #[error("the refined mesh would have more than {limit} cells: mark fewer cells, or allow more")]
    TooManyCells {
        /// Most cells.
        limit: usize,
    },
    /// The memory would not do.
    #[error(
        "the refined mesh would take more than {limit} bytes: mark fewer cells, or allow more memory"
    )]
    TooMuchMemory {
        /// Most bytes.
        limit: u64,
    },
    /// The refined arrays are no mesh: offsets of edges fold a half of a cell.
    #[error("the refined cells are no mesh: {0}; straighten the curved edges there")]
    NoMesh(#[from] MeshError),
}
