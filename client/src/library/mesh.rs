//! Meshes of the service: upload, get, list, read, delete.
//!
//! A mesh is named by the digest of its arrays, so a client asks for it first
//! and uploads only what the server does not have, in chunks of at most 1 MiB.

mod read;

use bytes::Bytes;
use signorini_proto::digest::{GroupArrays, MeshArrays, hex, mesh_digest};
use signorini_proto::v1;
use signorini_proto::v1::upload_mesh_request::Part;
use signorini_proto::{array, v1::MeshArray};

use crate::formats::mesh::MeshFile;
use crate::library::breaks::again;
use crate::library::connect::{Client, answer};
use crate::library::error::ClientError;
pub(crate) use read::{assembler, indices};

/// A mesh as it travels: header and encoded arrays.
#[derive(Clone, Debug)]
pub struct WireMesh {
    header: v1::MeshHeader,
    arrays: Vec<WireArray>,
}

#[derive(Clone, Debug)]
struct WireArray {
    array: MeshArray,
    group_index: i32,
    element_bytes: usize,
    data: Bytes,
}

/// What became of an upload.
#[derive(Clone, Debug, PartialEq)]
pub struct Uploaded {
    /// The stored mesh.
    pub mesh: v1::StoredMesh,
    /// Whether the server had it before, so that nothing was sent.
    pub already_present: bool,
}

impl WireMesh {
    /// Encodes a mesh and computes its digest.
    ///
    /// # Errors
    /// [`ClientError::MeshTooLarge`] for indices beyond 31 bits.
    pub fn new(mesh: &MeshFile) -> Result<Self, ClientError> {
        let coordinates = mesh.coordinates.as_flattened();
        let cells = signed(&mesh.cells)?;
        let facets = signed(&mesh.facets)?;
        let groups: Vec<Vec<i32>> = mesh
            .groups
            .iter()
            .map(|group| signed(&group.members))
            .collect::<Result<_, _>>()?;
        let ends: Vec<u32> = mesh.curved.iter().flat_map(|edge| edge.ends).collect();
        let curved = (
            signed(&ends)?,
            mesh.curved.iter().flat_map(|edge| edge.offset).collect(),
        );
        let digest = digest(mesh, [&cells, &facets], &groups, &curved)?;
        let mut arrays = vec![
            WireArray::of(MeshArray::Coordinates, coordinates),
            WireArray::of(MeshArray::Cells, &cells),
            WireArray::of(MeshArray::Facets, &facets),
            WireArray::of(MeshArray::CurvedEdges, &curved.0),
            WireArray::of(MeshArray::EdgeOffsets, &curved.1),
        ];
        for (index, members) in (0..).zip(&groups) {
            arrays.push(WireArray {
                group_index: index,
                ..WireArray::of(MeshArray::GroupMembers, members)
            });
        }
        // Empty arrays are known from the header alone.
        arrays.retain(|array| !array.data.is_empty());
        let header = header(mesh, digest)?;
        Ok(Self { header, arrays })
    }

    /// Lower-case hexadecimal digits of the digest.
    pub fn digest(&self) -> &str {
        &self.header.digest
    }

    /// Name of the resource, `meshes/{digest}`.
    pub fn name(&self) -> String {
        format!("meshes/{}", self.header.digest)
    }

    /// The messages of an upload, the header first.
    pub fn requests(self) -> impl Iterator<Item = v1::UploadMeshRequest> {
        let header = Part::Header(self.header);
        let chunks = self.arrays.into_iter().flat_map(WireArray::chunks);
        let parts = std::iter::once(header).chain(chunks.map(Part::Chunk));
        parts.map(|part| v1::UploadMeshRequest { part: Some(part) })
    }
}

impl WireArray {
    /// One that belongs to no group.
    fn of<E: array::Element>(array: MeshArray, values: &[E]) -> Self {
        Self {
            array,
            group_index: 0,
            element_bytes: E::SIZE,
            data: array::encode(values),
        }
    }

    fn chunks(self) -> impl Iterator<Item = v1::MeshChunk> {
        let (array, group_index) = (self.array.into(), self.group_index);
        array::chunks(self.data, self.element_bytes).map(move |chunk| v1::MeshChunk {
            array,
            group_index,
            offset_elements: chunk.offset_elements,
            data: chunk.data,
        })
    }
}

fn signed(indices: &[u32]) -> Result<Vec<i32>, ClientError> {
    let signed = indices.iter().map(|index| i32::try_from(*index));
    signed
        .collect::<Result<_, _>>()
        .map_err(|_| ClientError::MeshTooLarge(indices.len()))
}

fn digest(
    mesh: &MeshFile,
    [cells, facets]: [&[i32]; 2],
    members: &[Vec<i32>],
    curved: &(Vec<i32>, Vec<f64>),
) -> Result<String, ClientError> {
    let byte = |value: usize| u8::try_from(value).map_err(|_| ClientError::MeshTooLarge(value));
    let groups = mesh.groups.iter().zip(members).map(|(group, members)| {
        let (name, dimension) = (group.name.as_str(), byte(group.dimension)?);
        Ok(GroupArrays {
            name,
            dimension,
            members,
        })
    });
    let groups = groups.collect::<Result<Vec<_>, ClientError>>()?;
    let vertices_per_cell = byte(mesh.vertices_per_cell)?;
    Ok(hex(&mesh_digest(&MeshArrays {
        vertices_per_cell,
        coordinates: mesh.coordinates.as_flattened(),
        cells,
        facets,
        groups: &groups,
        curved_edges: &curved.0,
        edge_offsets: &curved.1,
    })))
}

fn count(items: usize) -> Result<i64, ClientError> {
    i64::try_from(items).map_err(|_| ClientError::MeshTooLarge(items))
}

fn header(mesh: &MeshFile, digest: String) -> Result<v1::MeshHeader, ClientError> {
    let cell_kind = match mesh.vertices_per_cell {
        3 => v1::CellKind::Triangle,
        _ => v1::CellKind::Tetrahedron,
    };
    let groups = mesh.groups.iter().map(|group| {
        let kind = if group.dimension + 1 == mesh.vertices_per_cell {
            v1::GroupKind::Cells
        } else {
            v1::GroupKind::Facets
        };
        let (name, member_count) = (group.name.clone(), count(group.members.len())?);
        Ok(v1::MeshGroup {
            name,
            kind: kind.into(),
            member_count,
        })
    });
    Ok(v1::MeshHeader {
        digest,
        cell_kind: cell_kind.into(),
        vertex_count: count(mesh.coordinates.len())?,
        cell_count: count(mesh.cell_count())?,
        facet_count: count(mesh.facet_count())?,
        curved_edge_count: count(mesh.curved.len())?,
        groups: groups.collect::<Result<_, ClientError>>()?,
        edge_count: 0,
    })
}

fn resource(digest: &str) -> String {
    if digest.starts_with("meshes/") {
        digest.to_owned()
    } else {
        format!("meshes/{digest}")
    }
}

impl Client {
    /// Makes sure that the server has a mesh.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `MESH_INVALID`, `MEMORY_BUDGET` and others.
    pub async fn upload_mesh(&self, mesh: WireMesh) -> Result<Uploaded, ClientError> {
        if let Some(mesh) = self.find_mesh(mesh.digest()).await? {
            return Ok(Uploaded {
                mesh,
                already_present: true,
            });
        }
        let upload = || async {
            let requests = tokio_stream::iter(mesh.clone().requests());
            Ok(self.meshes().upload_mesh(requests).await?)
        };
        let response = again(upload).await?.into_inner();
        let already_present = response.already_present;
        let mesh = response.mesh.ok_or_else(|| missing("the uploaded mesh"))?;
        Ok(Uploaded {
            mesh,
            already_present,
        })
    }

    /// Uploads a mesh from the messages that [`WireMesh::requests`] gives.
    ///
    /// # Errors
    /// As [`Client::upload_mesh`].
    pub async fn upload_mesh_messages(
        &self,
        messages: impl Iterator<Item = v1::UploadMeshRequest> + Send + 'static,
    ) -> Result<(), ClientError> {
        let requests = tokio_stream::iter(messages);
        self.meshes().upload_mesh(requests).await?;
        Ok(())
    }

    /// The mesh of a digest (64 hexadecimal digits or `meshes/{digest}`), if the
    /// server has it.
    ///
    /// # Errors
    /// [`ClientError::Refused`] for any reason but `MESH_NOT_FOUND`.
    pub async fn find_mesh(&self, digest: &str) -> Result<Option<v1::StoredMesh>, ClientError> {
        let request = v1::GetMeshRequest {
            name: resource(digest),
        };
        let get = || async { answer(self.meshes().get_mesh(request.clone())).await };
        match again(get).await {
            Ok(response) => Ok(response.into_inner().mesh),
            Err(error) if error.is_reason("MESH_NOT_FOUND") => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// All meshes that the server has, in order of their digests.
    ///
    /// # Errors
    /// [`ClientError::Refused`].
    pub async fn list_meshes(&self) -> Result<Vec<v1::StoredMesh>, ClientError> {
        let mut meshes = Vec::new();
        let mut page_token = String::new();
        loop {
            let request = v1::ListMeshesRequest {
                page_size: 0,
                page_token,
            };
            let list = || async { answer(self.meshes().list_meshes(request.clone())).await };
            let page = again(list).await?.into_inner();
            meshes.extend(page.meshes);
            page_token = page.next_page_token;
            if page_token.is_empty() {
                return Ok(meshes);
            }
        }
    }

    /// Drops a mesh that no session uses.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `MESH_NOT_FOUND`, `MESH_IN_USE`.
    pub async fn delete_mesh(&self, digest: &str) -> Result<(), ClientError> {
        let request = v1::DeleteMeshRequest {
            name: resource(digest),
        };
        answer(self.meshes().delete_mesh(request)).await?;
        Ok(())
    }
}

pub(crate) fn missing(what: &str) -> ClientError {
    ClientError::Protocol(format!("{what} is missing"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::mesh::MeshGroup;

    fn mesh(cells: usize) -> MeshFile {
        MeshFile {
            vertices_per_cell: 4,
            coordinates: vec![[0.5; 3]; 4],
            cells: [0, 1, 2, 3].repeat(cells),
            facets: Vec::new(),
            groups: vec![MeshGroup {
                name: "body".into(),
                dimension: 3,
                members: vec![0],
            }],
            curved: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn an_upload_is_a_header_and_chunks_without_gaps() {
        let wire = WireMesh::new(&mesh(100_000)).unwrap();
        let mut parts = wire.requests().map(|request| request.part.unwrap());
        let Some(Part::Header(header)) = parts.next() else {
            unreachable!()
        };
        assert_eq!(
            (header.vertex_count, header.cell_count, header.groups.len()),
            (4, 100_000, 1)
        );
        let mut received = 0;
        for part in parts {
            let Part::Chunk(chunk) = part else {
                unreachable!()
            };
            if chunk.array() == MeshArray::Cells {
                assert_eq!(chunk.offset_elements, received);
                assert!(chunk.data.len() <= signorini_proto::CHUNK_BYTES);
                received += chunk.data.len() as i64 / 4;
            }
        }
        assert_eq!(received, 400_000);
    }

    #[test]
    fn the_digest_of_an_example_is_that_of_the_python_client() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/meshes/indent_l3.msh");
        let mesh = crate::formats::msh::read(&std::fs::read(path).unwrap()).unwrap();
        let digest = "cbc7b4f0d3207b874645602a5793f44dd57da1b89b11b853de3c4184018f6eba";
        assert_eq!(WireMesh::new(&mesh).unwrap().digest(), digest);
    }

    #[test]
    fn the_digest_depends_on_the_name_of_a_group() {
        let first = WireMesh::new(&mesh(1)).unwrap();
        let mut other = mesh(1);
        other.groups[0].name = "core".into();
        assert_ne!(first.digest(), WireMesh::new(&other).unwrap().digest());
        assert_eq!(first.name(), format!("meshes/{}", first.digest()));
    }
}
