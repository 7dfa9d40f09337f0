//! Meshes of files as the solver's library has them, and back.

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
    let group = |group: Group| MeshGroup {
        name: group.name,
        dimension: match group.kind {
            GroupKind::Cells => dimension,
            GroupKind::Facets => dimension - 1,
        },
        members: group.members,
    };
    let curved = |one: EdgeOffset| CurvedEdge {
        ends: one.ends,
        offset: one.offset,
    };
    let (parts, offsets) = mesh.arrays();
    MeshFile {
        vertices_per_cell: parts.cell_kind.vertices(),
        coordinates: parts.coordinates,
        cells: parts.cells,
        facets: parts.facets,
        groups: parts.groups.into_iter().map(group).collect(),
        curved: offsets.into_iter().map(curved).collect(),
        warnings: Vec::new(),
    }
}
