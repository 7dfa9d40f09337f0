//! Mesh uploads into the library's arrays, and meshes onto the wire.
//!
//! Sizes are those of the header, checked before anything is allocated.

mod file;
mod reading;
mod upload;

use std::time::SystemTime;

use signorini::mesh::{CellKind, Group, GroupKind, Mesh, MeshId};
use signorini_proto::v1 as wire;

use super::{MAXIMUM_NAME_BYTES, wide};
use crate::fault::Fault;

pub(crate) use file::{Sink, read as from_file, write as to_file};
pub(crate) use reading::{messages, wanted};
pub(crate) use upload::Upload;
pub(super) use upload::{Indices, Numbers, Points};

const MAXIMUM_VERTICES: i64 = 200_000_000;
const MAXIMUM_CELLS: i64 = 400_000_000;
const MAXIMUM_GROUPS: usize = 4096;
const PREFIX: &str = "meshes/";

/// The ends of an edge.
const EDGE_BYTES: u64 = 8;
/// The ends of a curved edge and its offset.
const CURVED_EDGE_BYTES: u64 = 8 + 24;
/// The cell behind an uploaded facet and the facet of the boundary.
const FACET_BYTES: u64 = 8 + 20;
/// What building holds beside the mesh, as a fraction of it.
const MARGIN: u64 = 16;

/// The identity in `meshes/{digest}`.
///
/// # Errors
/// For another form; `path` names the field.
pub(crate) fn id_from_name(name: &str, path: &str) -> Result<MeshId, Fault> {
    name.strip_prefix(PREFIX)
        .and_then(MeshId::from_hex)
        .ok_or_else(|| Fault::request(path, "must be `meshes/` and 64 hexadecimal digits"))
}

/// `meshes/{digest}`.
pub(crate) fn name(id: MeshId) -> String {
    format!("{PREFIX}{id}")
}

/// A checked header: identity, sizes, groups.
#[derive(Debug)]
pub(crate) struct Header {
    /// None where the upload leaves it to the server.
    pub(crate) id: Option<MeshId>,
    cell_kind: CellKind,
    vertices: usize,
    cells: usize,
    facets: usize,
    curved_edges: usize,
    groups: Vec<GroupHeader>,
}

#[derive(Debug)]
struct GroupHeader {
    name: String,
    kind: GroupKind,
    members: usize,
}

impl Header {
    /// Checks a header.
    ///
    /// # Errors
    /// `RequestInvalid` with the field, `MessageLimit` for a size beyond its maximum.
    pub(crate) fn new(message: wire::MeshHeader) -> Result<Self, Fault> {
        let id = match message.digest.as_str() {
            "" => None,
            digest => Some(MeshId::from_hex(digest).ok_or_else(|| {
                Fault::request("header.digest", "must be empty or 64 hexadecimal digits")
            })?),
        };
        if message.groups.len() > MAXIMUM_GROUPS {
            return Err(limit("header.groups", MAXIMUM_GROUPS as i64));
        }
        Ok(Self {
            id,
            cell_kind: cell_kind(message.cell_kind)?,
            vertices: size(
                message.vertex_count,
                MAXIMUM_VERTICES,
                "header.vertex_count",
            )?,
            cells: size(message.cell_count, MAXIMUM_CELLS, "header.cell_count")?,
            facets: size(message.facet_count, MAXIMUM_CELLS, "header.facet_count")?,
            curved_edges: size(
                message.curved_edge_count,
                MAXIMUM_CELLS,
                "header.curved_edge_count",
            )?,
            groups: message
                .groups
                .into_iter()
                .map(group)
                .collect::<Result<_, _>>()?,
        })
    }

    /// Bytes of the arrays on the wire.
    pub(crate) fn array_bytes(&self) -> u64 {
        let members: u64 = self.groups.iter().map(|group| group.members as u64).sum();
        let kind = self.cell_kind;
        let indices = self.cells * kind.vertices() + self.facets * kind.facet_vertices();
        let curved = CURVED_EDGE_BYTES * self.curved_edges as u64;
        24 * self.vertices as u64 + 4 * (indices as u64 + members) + curved
    }

    /// Bytes that the upload and the mesh made of it take at most, for a mesh
    /// whose whole boundary is among its facets; Euler's formula predicts the edges.
    pub(crate) fn predicted_bytes(&self) -> u64 {
        let [vertices, cells, facets] = [self.vertices, self.cells, self.facets].map(|n| n as u64);
        let cell_edges = cells * self.cell_kind.edges().len() as u64;
        let edges = vertices + cells + facets;
        let found = 4 * (vertices + cell_edges) + EDGE_BYTES * edges + FACET_BYTES * facets;
        let mesh = self.array_bytes() + found;
        mesh + mesh / MARGIN
    }
}

/// When a mesh came and was used.
pub(crate) struct MeshUse {
    pub(crate) sessions: usize,
    pub(crate) created: SystemTime,
    pub(crate) used: SystemTime,
}

/// A stored mesh.
pub(crate) fn mesh(mesh: &Mesh, uses: &MeshUse) -> wire::StoredMesh {
    let quality = mesh.quality();
    wire::StoredMesh {
        name: name(mesh.id()),
        digest: mesh.id().to_string(),
        cell_kind: wire_cell_kind(mesh.cell_kind()).into(),
        vertex_count: wide(mesh.vertex_count() as u64),
        cell_count: wide(mesh.cell_count() as u64),
        facet_count: wide(mesh.facet_count() as u64),
        groups: mesh.groups().iter().map(wire_group).collect(),
        quality: Some(wire::MeshQuality {
            min_mean_ratio: quality.minimum,
            mean_mean_ratio: quality.mean,
            worst_cell: quality.worst_cell.into(),
        }),
        warnings: mesh.warnings().iter().take(100).cloned().collect(),
        memory_bytes: wide(mesh.bytes()),
        session_count: wide(uses.sessions as u64),
        create_time: Some(uses.created.into()),
        last_use_time: Some(uses.used.into()),
        curved_edge_count: wide(mesh.edge_offsets().len() as u64),
    }
}

fn wire_cell_kind(kind: CellKind) -> wire::CellKind {
    match kind {
        CellKind::Triangle => wire::CellKind::Triangle,
        CellKind::Tetrahedron => wire::CellKind::Tetrahedron,
    }
}

fn wire_group(group: &Group) -> wire::MeshGroup {
    let kind = match group.kind {
        GroupKind::Cells => wire::GroupKind::Cells,
        GroupKind::Facets => wire::GroupKind::Facets,
    };
    wire::MeshGroup {
        name: group.name.clone(),
        kind: kind.into(),
        member_count: wide(group.members.len() as u64),
    }
}

fn cell_kind(number: i32) -> Result<CellKind, Fault> {
    match wire::CellKind::try_from(number) {
        Ok(wire::CellKind::Triangle) => Ok(CellKind::Triangle),
        Ok(wire::CellKind::Tetrahedron) => Ok(CellKind::Tetrahedron),
        Ok(wire::CellKind::Unspecified) => Err(Fault::request("header.cell_kind", "is required")),
        Err(_) => Err(Fault::unsupported(
            "header.cell_kind",
            format!("number {number}"),
        )),
    }
}

fn group(message: wire::MeshGroup) -> Result<GroupHeader, Fault> {
    if message.name.chars().any(char::is_control) {
        let text = "has a control character";
        return Err(Fault::request("header.groups.name", text));
    }
    if message.name.len() > MAXIMUM_NAME_BYTES {
        return Err(limit("header.groups.name", MAXIMUM_NAME_BYTES as i64));
    }
    let kind = match wire::GroupKind::try_from(message.kind) {
        Ok(wire::GroupKind::Cells) => GroupKind::Cells,
        Ok(wire::GroupKind::Facets) => GroupKind::Facets,
        Ok(wire::GroupKind::Unspecified) | Err(_) => {
            return Err(Fault::request(
                "header.groups.kind",
                "must be cells or facets",
            ));
        }
    };
    Ok(GroupHeader {
        members: size(
            message.member_count,
            MAXIMUM_CELLS,
            "header.groups.member_count",
        )?,
        name: message.name,
        kind,
    })
}

pub(super) fn size(count: i64, maximum: i64, path: &str) -> Result<usize, Fault> {
    if count > maximum {
        return Err(limit(path, maximum));
    }
    usize::try_from(count).map_err(|_| Fault::request(path, "must not be negative"))
}

pub(super) fn limit(what: &str, limit: i64) -> Fault {
    Fault::MessageLimit {
        what: what.to_owned(),
        limit: limit.unsigned_abs(),
    }
}
