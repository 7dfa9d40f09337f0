//! Triangulated surfaces of the service: named by the digest of their arrays, uploaded once.

use bytes::Bytes;
use signorini_proto::array;
use signorini_proto::digest::{hex, surface_digest};
use signorini_proto::v1::upload_surface_request::Part;
use signorini_proto::v1::{self, SurfaceArray};

use crate::connect::{Client, answer};
use crate::error::ClientError;
use crate::formats::stl::SurfaceFile;

/// A surface as it travels.
#[derive(Clone, Debug)]
pub struct WireSurface {
    header: v1::SurfaceHeader,
    coordinates: Bytes,
    facets: Bytes,
}

impl WireSurface {
    /// Encodes a surface and computes its digest.
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
            },
            coordinates: array::encode(coordinates),
            facets: array::encode(&facets),
        })
    }

    /// Name of the resource, `surfaces/{digest}`.
    pub fn name(&self) -> String {
        format!("surfaces/{}", self.header.digest)
    }

    /// The messages of an upload, the header first.
    pub fn requests(self) -> impl Iterator<Item = v1::UploadSurfaceRequest> {
        let header = Part::Header(self.header);
        let coordinates = chunks::<f64>(SurfaceArray::Coordinates, self.coordinates);
        let facets = chunks::<i32>(SurfaceArray::Facets, self.facets);
        let parts = std::iter::once(header).chain(coordinates).chain(facets);
        parts.map(|part| v1::UploadSurfaceRequest { part: Some(part) })
    }
}

fn chunks<E: array::Element>(array: SurfaceArray, data: Bytes) -> impl Iterator<Item = Part> {
    array::chunks(data, E::SIZE).map(move |chunk| {
        Part::Chunk(v1::SurfaceChunk {
            array: array.into(),
            offset_elements: chunk.offset_elements,
            data: chunk.data,
        })
    })
}

impl Client {
    /// Makes sure that the server has a surface.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SURFACE_INVALID` with the facet, `MEMORY_BUDGET` and others.
    pub async fn upload_surface(&self, surface: WireSurface) -> Result<(), ClientError> {
        let name = surface.name();
        match answer(self.surfaces().get_surface(v1::GetSurfaceRequest { name })).await {
            Ok(_) => return Ok(()),
            Err(error) if error.is_reason("SURFACE_NOT_FOUND") => (),
            Err(error) => return Err(error),
        }
        let requests = tokio_stream::iter(surface.requests());
        self.surfaces().upload_surface(requests).await?;
        Ok(())
    }
}
