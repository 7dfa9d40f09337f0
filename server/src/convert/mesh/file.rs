//! An upload as the data folder keeps it: what a mesh is made of turns cells and facets,
//! so only the arrays as they were sent have its digest.

use bytes::Bytes;
use prost::Message as _;
use signorini::mesh::{EdgeOffset, Mesh, MeshParts};
use signorini_proto::array;
use signorini_proto::v1::{self as wire, read_mesh_response::Part};

use super::{Header, Upload, wide, wire_cell_kind, wire_group};
use crate::fault::Fault;

/// Takes the bytes of a file.
pub(crate) type Sink<'a> = dyn FnMut(&[u8]) -> std::io::Result<()> + 'a;

/// Writes an upload: messages of `ReadMeshResponse`, each after its length.
///
/// # Errors
/// Those of `sink`.
pub(crate) fn write(
    parts: &MeshParts,
    offsets: &[EdgeOffset],
    sink: &mut Sink<'_>,
) -> std::io::Result<()> {
    use wire::MeshArray;
    let mut put = |part| {
        let message = wire::ReadMeshResponse { part: Some(part) };
        sink(&message.encode_length_delimited_to_vec())
    };
    put(Part::Header(header(parts, offsets)))?;
    let mut put_array = |array: MeshArray, group: usize, data: Bytes, size: usize| {
        array::chunks(data, size).try_for_each(|chunk| {
            put(Part::Chunk(wire::MeshChunk {
                array: array.into(),
                group_index: i32::try_from(group).unwrap_or(i32::MAX),
                offset_elements: chunk.offset_elements,
                data: chunk.data,
            }))
        })
    };
    let points = array::encode(parts.coordinates.as_flattened());
    put_array(MeshArray::Coordinates, 0, points, size_of::<f64>())?;
    let index = size_of::<i32>();
    put_array(MeshArray::Cells, 0, indices(&parts.cells), index)?;
    put_array(MeshArray::Facets, 0, indices(&parts.facets), index)?;
    let ends: Vec<u32> = offsets.iter().flat_map(|one| one.ends).collect();
    put_array(MeshArray::CurvedEdges, 0, indices(&ends), index)?;
    let moved: Vec<f64> = offsets.iter().flat_map(|one| one.offset).collect();
    put_array(
        MeshArray::EdgeOffsets,
        0,
        array::encode(&moved),
        size_of::<f64>(),
    )?;
    for (number, group) in parts.groups.iter().enumerate() {
        put_array(
            MeshArray::GroupMembers,
            number,
            indices(&group.members),
            index,
        )?;
    }
    Ok(())
}

fn header(parts: &MeshParts, offsets: &[EdgeOffset]) -> wire::MeshHeader {
    let kind = parts.cell_kind;
    let count = |length: usize, width: usize| wide((length / width) as u64);
    wire::MeshHeader {
        digest: String::new(),
        cell_kind: wire_cell_kind(kind).into(),
        vertex_count: count(parts.coordinates.len(), 1),
        cell_count: count(parts.cells.len(), kind.vertices()),
        facet_count: count(parts.facets.len(), kind.facet_vertices()),
        groups: parts.groups.iter().map(wire_group).collect(),
        curved_edge_count: count(offsets.len(), 1),
        edge_count: 0,
    }
}

fn indices(values: &[u32]) -> Bytes {
    let signed: Vec<i32> = values.iter().map(|value| value.cast_signed()).collect();
    array::encode(&signed)
}

/// The mesh of a file.
///
/// # Errors
/// `MeshInvalid` for other bytes, and what an upload of them is refused for.
pub(crate) fn read(mut bytes: &[u8]) -> Result<Mesh, Fault> {
    let wrong = || Fault::MeshInvalid("the file holds no mesh".to_owned());
    let mut upload: Option<Upload> = None;
    while !bytes.is_empty() {
        let message = wire::ReadMeshResponse::decode_length_delimited(&mut bytes);
        match (message.map_err(|_| wrong())?.part, &mut upload) {
            (Some(Part::Header(header)), None) => {
                upload = Some(Upload::new(Header::new(header)?));
            }
            (Some(Part::Chunk(chunk)), Some(upload)) => upload.push(&chunk)?,
            (Some(Part::Header(_) | Part::Chunk(_)) | None, _) => return Err(wrong()),
        }
    }
    let (parts, offsets) = upload.ok_or_else(wrong)?.finish()?;
    let invalid = |error: signorini::MeshError| Fault::MeshInvalid(error.to_string());
    Mesh::second_order(parts, offsets).map_err(invalid)
}
