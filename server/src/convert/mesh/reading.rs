//! A stored mesh back onto the wire, message by message: each chunk is encoded
//! when it is asked for, so that a reader costs one chunk of memory.

use std::ops::Range;

use bytes::Bytes;
use signorini::mesh::Mesh;
use signorini_proto::v1::{self as wire, read_mesh_response::Part};
use signorini_proto::{CHUNK_BYTES, array};

use super::{wide, wire_cell_kind, wire_group};
use crate::fault::Fault;

const MOST_ARRAYS: usize = 100;

/// The arrays of an upload.
const UPLOADED: [wire::MeshArray; 6] = [
    wire::MeshArray::Coordinates,
    wire::MeshArray::Cells,
    wire::MeshArray::Facets,
    wire::MeshArray::CurvedEdges,
    wire::MeshArray::EdgeOffsets,
    wire::MeshArray::GroupMembers,
];

/// The arrays that a request asks for: those of an upload where it names none.
///
/// # Errors
/// `RequestInvalid` for a number that names no array, or too many.
pub(crate) fn wanted(numbers: &[i32]) -> Result<Vec<wire::MeshArray>, Fault> {
    if numbers.is_empty() {
        return Ok(UPLOADED.to_vec());
    }
    if numbers.len() > MOST_ARRAYS {
        return Err(Fault::request("arrays", "names more than 100 arrays"));
    }
    let array = |number: &i32| {
        let array = wire::MeshArray::try_from(*number).ok();
        let known = array.filter(|array| *array != wire::MeshArray::Unspecified);
        known.ok_or_else(|| Fault::request("arrays", "names no array of a mesh"))
    };
    let mut arrays = numbers.iter().map(array).collect::<Result<Vec<_>, _>>()?;
    arrays.sort_unstable();
    arrays.dedup();
    Ok(arrays)
}

/// Some rows of one array.
struct Slice {
    array: wire::MeshArray,
    group: usize,
    width: usize,
    rows: Range<usize>,
}

/// Header and chunks of a mesh, of the `wanted` arrays; what holds it is kept as long as
/// they are asked for.
pub(crate) fn messages<H: AsRef<Mesh> + Send>(
    holder: H,
    wanted: &[wire::MeshArray],
) -> impl Iterator<Item = wire::ReadMeshResponse> + Send + use<H> {
    let header = Part::Header(header(holder.as_ref(), wanted));
    let mut arrays = arrays(holder.as_ref());
    arrays.retain(|slice| wanted.contains(&slice.array));
    let slices = arrays.into_iter().flat_map(slices);
    let chunks = slices.map(move |slice| Part::Chunk(chunk(holder.as_ref(), &slice)));
    std::iter::once(header)
        .chain(chunks)
        .map(|part| wire::ReadMeshResponse { part: Some(part) })
}

fn header(mesh: &Mesh, wanted: &[wire::MeshArray]) -> wire::MeshHeader {
    let is_of_edges = |array: &wire::MeshArray| {
        matches!(array, wire::MeshArray::Edges | wire::MeshArray::CellEdges)
    };
    let edges = if wanted.iter().any(is_of_edges) {
        mesh.edges().len()
    } else {
        0
    };
    wire::MeshHeader {
        digest: mesh.id().to_string(),
        cell_kind: wire_cell_kind(mesh.cell_kind()).into(),
        vertex_count: wide(mesh.vertex_count() as u64),
        cell_count: wide(mesh.cell_count() as u64),
        facet_count: wide(mesh.facet_count() as u64),
        groups: mesh.groups().iter().map(wire_group).collect(),
        curved_edge_count: wide(mesh.edge_offsets().len() as u64),
        edge_count: wide(edges as u64),
    }
}

/// All arrays, each as one slice.
fn arrays(mesh: &Mesh) -> Vec<Slice> {
    use wire::MeshArray::{
        CellEdges, Cells, Coordinates, CurvedEdges, EdgeOffsets, Edges, Facets, GroupMembers,
    };
    let kind = mesh.cell_kind();
    let whole = |array, group, width, rows| Slice {
        array,
        group,
        width,
        rows: 0..rows,
    };
    let groups = mesh.groups().iter().enumerate();
    let members = groups.map(|(group, one)| whole(GroupMembers, group, 1, one.members.len()));
    let mut arrays = vec![
        whole(Coordinates, 0, 3, mesh.vertex_count()),
        whole(Cells, 0, kind.vertices(), mesh.cell_count()),
        whole(Facets, 0, kind.facet_vertices(), mesh.facet_count()),
        whole(CurvedEdges, 0, 2, mesh.edge_offsets().len()),
        whole(EdgeOffsets, 0, 3, mesh.edge_offsets().len()),
        whole(Edges, 0, 2, mesh.edges().len()),
        whole(CellEdges, 0, kind.edges().len(), mesh.cell_count()),
    ];
    arrays.extend(members);
    arrays
}

/// Cuts an array into slices that fit a message.
fn slices(whole: Slice) -> impl Iterator<Item = Slice> {
    let size = match whole.array {
        wire::MeshArray::Coordinates | wire::MeshArray::EdgeOffsets => size_of::<f64>(),
        wire::MeshArray::Unspecified
        | wire::MeshArray::CurvedEdges
        | wire::MeshArray::Cells
        | wire::MeshArray::Facets
        | wire::MeshArray::Edges
        | wire::MeshArray::CellEdges
        | wire::MeshArray::GroupMembers => size_of::<i32>(),
    };
    let step = CHUNK_BYTES / (size * whole.width);
    let end = whole.rows.end;
    whole.rows.step_by(step).map(move |start| Slice {
        rows: start..end.min(start + step),
        ..whole
    })
}

fn chunk(mesh: &Mesh, slice: &Slice) -> wire::MeshChunk {
    let entries = slice.rows.start * slice.width..slice.rows.end * slice.width;
    let data = match slice.array {
        wire::MeshArray::Coordinates => coordinates(mesh, &slice.rows),
        wire::MeshArray::Cells => vertices(mesh, mesh.cells().get(entries)),
        wire::MeshArray::Facets => vertices(mesh, mesh.facets().get(entries)),
        wire::MeshArray::CurvedEdges => {
            let edges = mesh.edge_offsets().get(slice.rows.clone());
            let ends = edges.unwrap_or_default().iter().flat_map(|one| one.ends);
            vertices(mesh, Some(&ends.collect::<Vec<_>>()))
        }
        wire::MeshArray::EdgeOffsets => {
            let edges = mesh.edge_offsets().get(slice.rows.clone());
            let offsets = edges.unwrap_or_default().iter().flat_map(|one| one.offset);
            array::encode(&offsets.collect::<Vec<_>>())
        }
        wire::MeshArray::Edges => {
            let edges = mesh.edges().get(slice.rows.clone());
            vertices(mesh, edges.map(<[[u32; 2]]>::as_flattened))
        }
        wire::MeshArray::CellEdges => indices(mesh.cell_edges().get(entries), |edge| edge),
        wire::MeshArray::GroupMembers => {
            let group = mesh.groups().get(slice.group);
            indices(
                group.and_then(|group| group.members.get(entries)),
                |member| member,
            )
        }
        wire::MeshArray::Unspecified => Bytes::new(),
    };
    wire::MeshChunk {
        array: slice.array.into(),
        group_index: i32::try_from(slice.group).unwrap_or(i32::MAX),
        offset_elements: wide((slice.rows.start * slice.width) as u64),
        data,
    }
}

/// Rows in the uploaded numbering; vertices that no cell uses lie at the origin.
fn coordinates(mesh: &Mesh, rows: &Range<usize>) -> Bytes {
    let used = mesh.used_vertices();
    let first = used.partition_point(|&uploaded| (uploaded as usize) < rows.start);
    let mut points = vec![[0.0; 3]; rows.len()];
    for (&uploaded, point) in used.iter().zip(mesh.coordinates()).skip(first) {
        match points.get_mut(uploaded as usize - rows.start) {
            Some(place) => *place = *point,
            None => break,
        }
    }
    array::encode(points.as_flattened())
}

/// Vertices in the uploaded numbering.
fn vertices(mesh: &Mesh, entries: Option<&[u32]>) -> Bytes {
    let used = mesh.used_vertices();
    indices(entries, |vertex| {
        used.get(vertex as usize).copied().unwrap_or(vertex)
    })
}

fn indices(entries: Option<&[u32]>, number: impl Fn(u32) -> u32) -> Bytes {
    let entries = entries.unwrap_or_default().iter();
    let signed: Vec<i32> = entries.map(|&entry| number(entry).cast_signed()).collect();
    array::encode(&signed)
}
