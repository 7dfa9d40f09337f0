//! The arrays that a mesh is made of, to be sent or written.

use std::collections::BTreeSet;

use super::{EdgeOffset, Mesh, MeshParts};

impl Mesh {
    /// Arrays from which [`Mesh::second_order`] makes this mesh anew, edges inside the body as lines. Cost:
    /// one pass over the surface.
    pub fn arrays(&self) -> (MeshParts, Vec<EdgeOffset>) {
        let parts = MeshParts {
            cell_kind: self.cell_kind(),
            coordinates: self.coordinates().to_vec(),
            cells: self.cells().to_vec(),
            facets: self.facets().to_vec(),
            groups: self.groups().to_vec(),
        };
        let surface = self.surface_edges();
        let offsets = self.edge_offsets().iter();
        let offsets = offsets.filter(|one| surface.contains(&one.ends));
        (parts, offsets.copied().collect())
    }

    /// Ends of the edges of the surface, the lower one first.
    fn surface_edges(&self) -> BTreeSet<[u32; 2]> {
        let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [a, c]];
        let facets = self.boundary_facets().iter();
        let edges = facets.flat_map(|facet| edges(facet.vertices));
        edges.map(|[a, b]| [a.min(b), a.max(b)]).collect()
    }
}
