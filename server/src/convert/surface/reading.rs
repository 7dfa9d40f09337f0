//! A stored triangulation back onto the wire, message by message: each chunk is encoded when it
//! is asked for, so that a reader costs one chunk of memory.

use std::ops::Range;
use std::sync::Arc;

use bytes::Bytes;
use signorini::obstacle::surface::TriangulatedSurface;
use signorini_proto::v1::{self as wire, read_surface_response::Part};
use signorini_proto::{CHUNK_BYTES, array};

use super::wide;

/// Components of a row of either array.
const WIDTH: usize = 3;

/// Header and chunks of a surface, which is kept as long as they are asked for.
pub(crate) fn messages(
    surface: Arc<TriangulatedSurface>,
    digest: String,
) -> impl Iterator<Item = wire::ReadSurfaceResponse> + Send {
    let (vertices, facets) = (surface.vertices().len(), surface.facets().len());
    let header = Part::Header(wire::SurfaceHeader {
        digest,
        vertex_count: wide(vertices as u64),
        facet_count: wide(facets as u64),
        grid: None,
    });
    let coordinates = slices(vertices, size_of::<f64>());
    let corners = slices(facets, size_of::<i32>());
    let coordinates = coordinates.map(|rows| (wire::SurfaceArray::Coordinates, rows));
    let corners = corners.map(|rows| (wire::SurfaceArray::Facets, rows));
    let chunks = coordinates.chain(corners);
    let chunks = chunks.map(move |(array, rows)| Part::Chunk(chunk(&surface, array, rows)));
    std::iter::once(header)
        .chain(chunks)
        .map(|part| wire::ReadSurfaceResponse { part: Some(part) })
}

/// Rows of an array, as many at once as fit a message.
fn slices(rows: usize, element_bytes: usize) -> impl Iterator<Item = Range<usize>> {
    let most = CHUNK_BYTES / (WIDTH * element_bytes);
    let starts = (0..rows).step_by(most);
    starts.map(move |start| start..rows.min(start + most))
}

fn chunk(
    surface: &TriangulatedSurface,
    array: wire::SurfaceArray,
    rows: Range<usize>,
) -> wire::SurfaceChunk {
    let offset = wide((WIDTH * rows.start) as u64);
    wire::SurfaceChunk {
        array: array.into(),
        offset_elements: offset,
        data: match array {
            wire::SurfaceArray::Facets => corners(surface.facets().get(rows).unwrap_or_default()),
            wire::SurfaceArray::Coordinates
            | wire::SurfaceArray::Values
            | wire::SurfaceArray::Unspecified => {
                let own = surface.vertices().get(rows).unwrap_or_default();
                array::encode(own.as_flattened())
            }
        },
    }
}

fn corners(facets: &[[u32; WIDTH]]) -> Bytes {
    let corners = facets.as_flattened().iter();
    let signed: Vec<i32> = corners.map(|corner| corner.cast_signed()).collect();
    array::encode(&signed)
}

#[cfg(test)]
mod tests {
    use super::super::Upload;
    use super::*;
    use crate::convert::uploaded::Surface;

    /// A pyramid over a polygon of so many sides.
    fn pyramid(sides: u32) -> TriangulatedSurface {
        let at = |side: u32| {
            let (y, x) = (f64::from(side) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
            [x, y, 0.0]
        };
        let mut vertices: Vec<[f64; 3]> = (0..sides).map(at).collect();
        vertices.extend([[0.0; 3], [0.0, 0.0, 1.0]]);
        let next = |side: u32| (side + 1) % sides;
        let below = (0..sides).map(|side| [sides, next(side), side]);
        let above = (0..sides).map(|side| [sides + 1, side, next(side)]);
        TriangulatedSurface::new(vertices, below.chain(above).collect()).unwrap()
    }

    #[test]
    fn what_is_read_uploads_as_the_same_surface() {
        for sides in [3, 50_000] {
            let surface = Arc::new(pyramid(sides));
            let mut messages = messages(Arc::clone(&surface), String::new());
            let Some(Part::Header(header)) = messages.next().unwrap().part else {
                unreachable!("a header first");
            };
            let mut upload = Upload::new(header).unwrap();
            let mut chunks = 0;
            for message in messages {
                let Some(Part::Chunk(chunk)) = message.part else {
                    unreachable!("chunks after it");
                };
                assert!(chunk.data.len() <= CHUNK_BYTES);
                upload.push(&chunk).unwrap();
                chunks += 1;
            }
            assert_eq!(chunks, if sides == 3 { 2 } else { 4 });
            match upload.finish().unwrap().surface().unwrap() {
                Surface::Triangulated(found) => assert_eq!(found, surface),
                Surface::Heights(_) | Surface::Distances(_) => unreachable!("no grid was sent"),
            }
        }
    }
}
