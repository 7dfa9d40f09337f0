//! Surfaces of tools of the service, triangulated or grids: named by the digest of their arrays,
//! uploaded once.

use bytes::Bytes;
use signorini_proto::array::{self, Assembler};
use signorini_proto::digest::{grid_digest, hex, surface_digest};
use signorini_proto::v1::read_surface_response::Part as Read;
use signorini_proto::v1::upload_surface_request::Part;
use signorini_proto::v1::{self, SurfaceArray};

use crate::formats::grid::GridFile;
use crate::formats::stl::SurfaceFile;
use crate::library::breaks::again;
use crate::library::connect::{Client, answer};
use crate::library::error::ClientError;
use crate::library::mesh::{assembler, indices, missing};

/// What names of surfaces begin with.
const PREFIX: &str = "surfaces/";

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
        format!("{PREFIX}{}", self.header.digest)
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
        let get = || async { answer(self.surfaces().get_surface(request.clone())).await };
        match again(get).await {
            Ok(_) => return Ok(()),
            Err(error) if error.is_reason("SURFACE_NOT_FOUND") => (),
            Err(error) => return Err(error),
        }
        let upload = || async {
            let messages = surface.clone().requests();
            self.upload_surface_messages(messages).await
        };
        again(upload).await
    }

    /// Uploads a surface from the messages that [`WireSurface::requests`] gives.
    ///
    /// # Errors
    /// As [`Client::upload_surface`].
    pub async fn upload_surface_messages(
        &self,
        messages: impl Iterator<Item = v1::UploadSurfaceRequest> + Send + 'static,
    ) -> Result<(), ClientError> {
        let requests = tokio_stream::iter(messages);
        self.surfaces().upload_surface(requests).await?;
        Ok(())
    }

    /// A triangulated surface of the server, by its name or digest.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SURFACE_NOT_FOUND`, `UNSUPPORTED` for a grid;
    /// [`ClientError::Protocol`] for arrays that do not fit their header.
    pub async fn read_surface(&self, name: &str) -> Result<SurfaceFile, ClientError> {
        let name = if name.starts_with(PREFIX) {
            name.to_owned()
        } else {
            format!("{PREFIX}{name}")
        };
        let request = v1::ReadSurfaceRequest { name };
        let mut stream = answer(self.surfaces().read_surface(request))
            .await?
            .into_inner();
        let first = stream.message().await?.and_then(|first| first.part);
        let Some(Read::Header(header)) = first else {
            return Err(missing("the header of a surface"));
        };
        let mut arrays = Arrays::new(&header)?;
        while let Some(response) = stream.message().await? {
            let Some(Read::Chunk(chunk)) = response.part else {
                return Err(missing("a chunk of a surface"));
            };
            arrays.add(&chunk)?;
        }
        arrays.finish()
    }
}

/// The arrays of a surface on their way.
struct Arrays {
    coordinates: Assembler<f64>,
    corners: Assembler<i32>,
}

impl Arrays {
    fn new(header: &v1::SurfaceHeader) -> Result<Self, ClientError> {
        Ok(Self {
            coordinates: assembler(header.vertex_count, 3)?,
            corners: assembler(header.facet_count, 3)?,
        })
    }

    fn add(&mut self, chunk: &v1::SurfaceChunk) -> Result<(), ClientError> {
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match chunk.array() {
            SurfaceArray::Coordinates => self.coordinates.push(offset, data)?,
            SurfaceArray::Facets => self.corners.push(offset, data)?,
            SurfaceArray::Values | SurfaceArray::Unspecified => {
                return Err(missing("an array of a triangulation"));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<SurfaceFile, ClientError> {
        let coordinates = self.coordinates.finish()?;
        let corners = indices(self.corners)?;
        let vertices = coordinates.as_chunks::<3>().0.to_vec();
        let facets = corners.as_chunks::<3>().0.to_vec();
        let is_there = |corner: &u32| (*corner as usize) < vertices.len();
        if corners.iter().all(is_there) {
            Ok(SurfaceFile { vertices, facets })
        } else {
            Err(missing("a vertex of a facet"))
        }
    }
}
