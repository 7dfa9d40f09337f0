//! Meshes of files as the solver's library has them, and back.

use std::collections::BTreeSet;

use signorini::mesh::{CellKind, EdgeOffset, Group, GroupKind, Mesh, MeshParts};
use signorini_client::formats::msh::{CurvedEdge, MeshFile, MeshGroup};

use crate::terminal::exit::{Exit, Failure};

/// The mesh of a file, as the library takes it.
pub(super) fn mesh(file: &MeshFile) -> Result<Mesh, Failure> {
    let cells = file.vertices_per_cell;
    let group = |group: &MeshGroup| Group {
        name: group.name.clone(),
        kind: if group.dimension + 1 == cells {
            GroupKind::Cells
        } else {
            GroupKind::Facets
        },
        members: group.members.clone(),
    };
    let parts = MeshParts {
        cell_kind: match cells {
            3 => CellKind::Triangle,
            _ => CellKind::Tetrahedron,
        },
        coordinates: file.coordinates.clone(),
        cells: file.cells.clone(),
        facets: file.facets.clone(),
        groups: file.groups.iter().map(group).collect(),
    };
    let offset = |edge: &CurvedEdge| EdgeOffset {
        ends: edge.ends,
        offset: edge.offset,
    };
    let offsets = file.curved.iter().map(offset).collect();
    let mesh = Mesh::second_order(parts, offsets);
    mesh.map_err(|error| Failure::new(Exit::Invalid, error.to_string()))
}

/// A mesh of the library as that of a file: edges inside the body are lines.
pub(super) fn mesh_file(mesh: &Mesh) -> MeshFile {
    let dimension = mesh.cell_kind().dimension();
    let group = |group: &Group| MeshGroup {
        name: group.name.clone(),
        dimension: match group.kind {
            GroupKind::Cells => dimension,
            GroupKind::Facets => dimension - 1,
        },
        members: group.members.clone(),
    };
    let surface: BTreeSet<[u32; 2]> = mesh
        .boundary_facets()
        .iter()
        .flat_map(|facet| {
            let [a, b, c] = facet.vertices;
            [(a, b), (b, c), (a, c)].map(|(a, b)| [a.min(b), a.max(b)])
        })
        .collect();
    let curved = mesh.edge_offsets().iter();
    let curved = curved.filter(|one| surface.contains(&one.ends));
    MeshFile {
        vertices_per_cell: mesh.cell_kind().vertices(),
        coordinates: mesh.coordinates().to_vec(),
        cells: mesh.cells().to_vec(),
        facets: mesh.facets().to_vec(),
        groups: mesh.groups().iter().map(group).collect(),
        curved: curved
            .map(|one| CurvedEdge {
                ends: one.ends,
                offset: one.offset,
            })
            .collect(),
        warnings: Vec::new(),
    }
}
