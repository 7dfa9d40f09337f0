//! An upload as the data folder keeps it: the arrays as they were sent, which alone have its
//! digest; a surface in memory is made of them again, with the same bits.

use bytes::Bytes;
use prost::Message as _;
use signorini_proto::array;
use signorini_proto::v1::{self as wire, SurfaceArray, upload_surface_request::Part};

use super::super::uploaded::Surface;
use super::{Upload, Whole, WholeArrays, wide};
use crate::convert::mesh::Sink;
use crate::fault::Fault;

/// Writes an upload: its messages, each after its length.
///
/// # Errors
/// Those of `sink`.
pub(crate) fn write(whole: &Whole, sink: &mut Sink<'_>) -> std::io::Result<()> {
    let mut put = |part| {
        let message = wire::UploadSurfaceRequest { part: Some(part) };
        sink(&message.encode_length_delimited_to_vec())
    };
    put(Part::Header(header(whole)))?;
    let mut put_array = |array: SurfaceArray, data: Bytes, size: usize| {
        array::chunks(data, size).try_for_each(|chunk| {
            put(Part::Chunk(wire::SurfaceChunk {
                array: array.into(),
                offset_elements: chunk.offset_elements,
                data: chunk.data,
            }))
        })
    };
    match &whole.arrays {
        WholeArrays::Triangulated { vertices, corners } => {
            let points = array::encode(vertices.as_flattened());
            put_array(SurfaceArray::Coordinates, points, size_of::<f64>())?;
            let signed: Vec<i32> = corners.iter().map(|corner| corner.cast_signed()).collect();
            put_array(
                SurfaceArray::Facets,
                array::encode(&signed),
                size_of::<i32>(),
            )
        }
        WholeArrays::Grid(grid) => {
            let values = array::encode(&grid.values);
            put_array(SurfaceArray::Values, values, size_of::<f64>())
        }
    }
}

fn header(whole: &Whole) -> wire::SurfaceHeader {
    let digest = whole.digest.clone();
    match &whole.arrays {
        WholeArrays::Triangulated { vertices, corners } => wire::SurfaceHeader {
            digest,
            vertex_count: wide(vertices.len() as u64),
            facet_count: wide(corners.len() as u64 / 3),
            grid: None,
        },
        WholeArrays::Grid(grid) => wire::SurfaceHeader {
            digest,
            grid: Some(grid.described()),
            ..Default::default()
        },
    }
}

/// Bytes that the surface of a file takes while it is read.
///
/// # Errors
/// As [`read`].
pub(crate) fn predicted_bytes(mut bytes: &[u8]) -> Result<u64, Fault> {
    let message = wire::UploadSurfaceRequest::decode_length_delimited(&mut bytes);
    match message.map_err(|_| no_surface())?.part {
        Some(Part::Header(header)) => Ok(Upload::new(header)?.predicted_bytes()),
        Some(Part::Chunk(_)) | None => Err(no_surface()),
    }
}

fn no_surface() -> Fault {
    Fault::SurfaceInvalid("the file holds no surface".to_owned())
}

/// The surface of a file, with its digest, which has been computed again.
///
/// # Errors
/// `SurfaceInvalid` for other bytes, and what an upload of them is refused for.
pub(crate) fn read(mut bytes: &[u8]) -> Result<(String, Surface), Fault> {
    let mut upload: Option<Upload> = None;
    while !bytes.is_empty() {
        let message = wire::UploadSurfaceRequest::decode_length_delimited(&mut bytes);
        match (message.map_err(|_| no_surface())?.part, &mut upload) {
            (Some(Part::Header(header)), None) => upload = Some(Upload::new(header)?),
            (Some(Part::Chunk(chunk)), Some(upload)) => upload.push(&chunk)?,
            (Some(Part::Header(_) | Part::Chunk(_)) | None, _) => return Err(no_surface()),
        }
    }
    let whole = upload.ok_or_else(no_surface)?.finish()?;
    let digest = whole.digest.clone();
    Ok((digest, whole.surface()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron, heights and distances, as their headers and arrays.
    fn uploads() -> [Whole; 3] {
        let grid = |counts: Vec<i64>| {
            let axes = counts.len();
            let header = wire::SurfaceHeader {
                grid: Some(wire::Grid {
                    counts,
                    origin: vec![0.25; axes],
                    spacing: vec![1.0; axes],
                }),
                ..Default::default()
            };
            let nodes = 4_usize.pow(u32::try_from(axes).unwrap());
            let values: Vec<f64> = (0..nodes).map(|node| (node % 4) as f64 - 1.5).collect();
            whole(header, &[(SurfaceArray::Values, array::encode(&values))])
        };
        let points = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let facets = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
        let header = wire::SurfaceHeader {
            vertex_count: 4,
            facet_count: 4,
            ..Default::default()
        };
        let arrays = [
            (SurfaceArray::Coordinates, array::encode(&points)),
            (SurfaceArray::Facets, array::encode::<i32>(&facets)),
        ];
        [whole(header, &arrays), grid(vec![4; 2]), grid(vec![4; 3])]
    }

    fn whole(header: wire::SurfaceHeader, arrays: &[(SurfaceArray, Bytes)]) -> Whole {
        let mut upload = Upload::new(header).unwrap();
        for (array, data) in arrays {
            let chunk = wire::SurfaceChunk {
                array: (*array).into(),
                offset_elements: 0,
                data: data.clone(),
            };
            upload.push(&chunk).unwrap();
        }
        upload.finish().unwrap()
    }

    #[test]
    fn a_file_is_read_as_what_was_written_and_a_changed_one_is_refused() {
        let mut rng = fastrand::Rng::with_seed(5);
        for whole in uploads() {
            let mut bytes = Vec::new();
            let mut sink = |part: &[u8]| {
                bytes.extend_from_slice(part);
                Ok(())
            };
            write(&whole, &mut sink).unwrap();
            let (digest, surface) = read(&bytes).unwrap();
            assert_eq!(digest, whole.digest);
            assert_eq!(surface.bytes(), whole.surface().unwrap().bytes());
            for place in 0..bytes.len() {
                assert!(read(&bytes[..place]).is_err(), "cut at {place}");
            }
            for _ in 0..1000 {
                let mut changed = bytes.clone();
                let place = rng.usize(..changed.len());
                changed[place] ^= 1 << rng.u8(..8);
                // The name of an array that has one field more is no other array.
                if let Ok((same, _)) = read(&changed) {
                    assert_eq!(same, digest, "byte {place}");
                }
            }
        }
    }
}
