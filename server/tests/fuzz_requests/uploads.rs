//! Uploads as one sequence of bytes, which a campaign changes and takes apart again.

use bytes::{Buf as _, Bytes};
use prost::Message;
use signorini_proto::v1::{self as wire, upload_surface_request as surface};

/// A repeated field of bytes: the messages of one upload.
const FRAME: u8 = 0x0a;

pub(crate) fn framed(messages: &[impl Message]) -> Vec<u8> {
    let framed = |message| {
        [
            vec![FRAME],
            Message::encode_length_delimited_to_vec(message),
        ]
        .concat()
    };
    messages.iter().flat_map(framed).collect()
}

/// Uploads of a tetrahedron and of a grid of heights, as the messages that they are.
pub(crate) fn surfaces() -> [Vec<wire::UploadSurfaceRequest>; 2] {
    let numbers = |values: &[f64]| values.iter().flat_map(|one| one.to_le_bytes()).collect();
    let facets = [0_i32, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.];
    let header = wire::SurfaceHeader {
        vertex_count: 4,
        facet_count: 4,
        ..Default::default()
    };
    let grid = wire::Grid {
        counts: vec![4, 4],
        origin: vec![0.0; 2],
        spacing: vec![1.0; 2],
    };
    let heights = wire::SurfaceHeader {
        grid: Some(grid),
        ..Default::default()
    };
    let chunk = |array: wire::SurfaceArray, data: Vec<u8>| {
        surface::Part::Chunk(wire::SurfaceChunk {
            array: array.into(),
            offset_elements: 0,
            data: data.into(),
        })
    };
    let triangles = facets.iter().flat_map(|one| one.to_le_bytes()).collect();
    let all = [
        vec![
            surface::Part::Header(header),
            chunk(wire::SurfaceArray::Coordinates, numbers(&corners)),
            chunk(wire::SurfaceArray::Facets, triangles),
        ],
        vec![
            surface::Part::Header(heights),
            chunk(wire::SurfaceArray::Values, numbers(&[0.5; 16])),
        ],
    ];
    let request = |part| wire::UploadSurfaceRequest { part: Some(part) };
    all.map(|parts| parts.into_iter().map(request).collect())
}

/// The upload of an exported state, in two slices.
pub(crate) fn import(state: &[u8]) -> Vec<wire::ImportStateRequest> {
    use sha2::Digest as _;
    let digest = signorini_proto::digest::hex(&sha2::Sha256::digest(state).into());
    let middle = state.len() / 2;
    let slice = |offset: usize, data: &[u8]| wire::ImportStateRequest {
        digest: digest.clone(),
        offset: offset as i64,
        data: Bytes::copy_from_slice(data),
    };
    vec![slice(0, &state[..middle]), slice(middle, &state[middle..])]
}

/// The messages of an upload; what cannot be taken apart is one more.
pub(crate) fn unframed(mut input: &[u8]) -> Vec<Bytes> {
    let mut messages = Vec::new();
    while input.has_remaining() {
        let mut rest = &input[1..];
        let length = prost::decode_length_delimiter(&mut rest).unwrap_or(rest.len());
        let (message, after) = rest.split_at(length.min(rest.len()));
        messages.push(Bytes::copy_from_slice(message));
        input = after;
    }
    messages
}
