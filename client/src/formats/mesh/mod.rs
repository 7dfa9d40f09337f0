//! Meshes as files give them, and how readers build them.
//!
//! Hexahedra, wedges, pyramids and quadrangles are split into tetrahedra and triangles: the
//! diagonal of each face through its smallest node number, told in a warning.

mod build;
mod curved;
mod fault;
mod joined;
mod outer;
mod plane;
pub(crate) mod raw;
mod shape;
pub(crate) mod split;

pub(crate) use build::mesh as build;
pub use fault::MeshFault;
pub use joined::{Body, JoinFault, Placement, joined};
pub(crate) use outer::{BODY, BOUNDARY, outer_facets};

/// A named set of cells or facets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshGroup {
    /// Its name in the file, or its number where there is no name.
    pub name: String,
    /// Of its members: that of the cells, or one less for facets.
    pub dimension: usize,
    /// Indices into cells or facets, ascending.
    pub members: Vec<u32>,
}

/// An edge of the surface that is no line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvedEdge {
    /// Vertices, the lower one first.
    pub ends: [u32; 2],
    /// Its middle less the mean of its ends, length.
    pub offset: [f64; 3],
}

/// A mesh as a file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// 3 for triangles, 4 for tetrahedra.
    pub vertices_per_cell: usize,
    /// One row a vertex [vertices, 3], length; z = 0 for triangles.
    pub coordinates: Vec<[f64; 3]>,
    /// Vertices of the cells, flat [cells, `vertices_per_cell`].
    pub cells: Vec<u32>,
    /// Vertices of the facets, flat [facets, `vertices_per_cell` - 1].
    pub facets: Vec<u32>,
    /// Facet groups, then cell groups, each by number or order in the file.
    pub groups: Vec<MeshGroup>,
    /// Edges of the surface that are no lines, ascending by their ends.
    pub curved: Vec<CurvedEdge>,
    /// What the reader left out or changed.
    pub warnings: Vec<String>,
}

impl MeshFile {
    /// Cells.
    pub fn cell_count(&self) -> usize {
        self.cells.len() / self.vertices_per_cell
    }

    /// Facets.
    pub fn facet_count(&self) -> usize {
        self.facets.len() / (self.vertices_per_cell - 1)
    }
}
