//! Surfaces of tools of the service, triangulated or grids: named by the digest of their arrays,
//! uploaded once.

use bytes::Bytes;
use signorini_proto::array;
use signorini_proto::digest::{grid_digest, hex, surface_digest};
use signorini_proto::v1::upload_surface_request::Part;
use signorini_proto::v1::{self, SurfaceArray};

use crate::breaks::again;
use crate::connect::{Client, answer};
use crate::error::ClientError;
use crate::formats::grid::GridFile;
use crate::formats::stl::SurfaceFile;

/// A surface as it travels.
#[derive(Clone, Debug)]
pub struct WireSurface {
    header: v1::SurfaceHeader,
    arrays: Vec<WireArray>,
}

#[derive(Clone, Debug)]
struct WireArray {
    name: SurfaceArray,
    element_bytes: usize,
    data: Bytes,
}

impl WireSurface {
    /// Encodes a triangulated surface and computes its digest.
    ///
    /// # Errors
    /// [`ClientError::MeshTooLarge`] for indices beyond 31 bits.
    pub fn new(surface: &SurfaceFile) -> Result<Self, ClientError> {
        let corners = surface.facets.as_flattened();
        let signed = corners.iter().map(|corner| i32::try_from(*corner));
        let facets: Vec<i32> = signed
            .collect::<Result<_, _>>()
            .map_err(|_| ClientError::MeshTooLarge(corners.len()))?;
        let coordinates = surface.vertices.as_flattened();
        Ok(Self {
            header: v1::SurfaceHeader {
                digest: hex(&surface_digest(coordinates, &facets)),
                vertex_count: surface.vertices.len() as i64,
                facet_count: surface.facets.len() as i64,
                grid: None,
            },
            arrays: vec![
                wire_array(SurfaceArray::Coordinates, coordinates),
                wire_array(SurfaceArray::Facets, &facets),
            ],
        })
    }

    /// Encodes a grid and computes its digest.
    pub fn of_grid(grid: &GridFile) -> Self {
        let (origin, spacing) = (&grid.origin, &grid.spacing);
        Self {
            header: v1::SurfaceHeader {
                digest: hex(&grid_digest(&grid.counts, (origin, spacing), &grid.values)),
                grid: Some(v1::Grid {
                    counts: grid.counts.iter().map(|count| *count as i64).collect(),
                    origin: origin.clone(),
                    spacing: spacing.clone(),
                }),
                ..v1::SurfaceHeader::default()
            },
            arrays: vec![wire_array(SurfaceArray::Values, &grid.values)],
        }
    }

    /// Name of the resource, `surfaces/{digest}`.
    pub fn name(&self) -> String {
        format!("surfaces/{}", self.header.digest)
    }

    /// The messages of an upload, the header first.
    pub fn requests(self) -> impl Iterator<Item = v1::UploadSurfaceRequest> {
        let header = std::iter::once(Part::Header(self.header));
        let parts = header.chain(self.arrays.into_iter().flat_map(chunks));
        parts.map(|part| v1::UploadSurfaceRequest { part: Some(part) })
    }
}

fn wire_array<E: array::Element>(name: SurfaceArray, values: &[E]) -> WireArray {
    WireArray {
        name,
        element_bytes: E::SIZE,
        data: array::encode(values),
    }
}

fn chunks(array: WireArray) -> impl Iterator<Item = Part> {
    let name = array.name.into();
    array::chunks(array.data, array.element_bytes).map(move |chunk| {
        Part::Chunk(v1::SurfaceChunk {
            array: name,
            offset_elements: chunk.offset_elements,
            data: chunk.data,
        })
    })
}

impl Client {
    /// Makes sure that the server has a surface.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SURFACE_INVALID` with the facet or node, `MEMORY_BUDGET` and others.
    pub async fn upload_surface(&self, surface: WireSurface) -> Result<(), ClientError> {
        let name = surface.name();
        let request = v1::GetSurfaceRequest { name };
        let get = async || answer(self.surfaces().get_surface(request.clone())).await;
        match again(get).await {
            Ok(_) => return Ok(()),
            Err(error) if error.is_reason("SURFACE_NOT_FOUND") => (),
            Err(error) => return Err(error),
        }
        let upload = async || {
            let requests = tokio_stream::iter(surface.clone().requests());
            Ok(self.surfaces().upload_surface(requests).await?)
        };
        again(upload).await.map(drop)
    }
}
