//! A stored mesh, read back from its header and chunks.

use signorini_proto::array::{Assembler, Element};
use signorini_proto::v1;
use signorini_proto::v1::MeshArray;
use signorini_proto::v1::read_mesh_response::Part;

use super::{missing, resource};
use crate::formats::mesh::{CurvedEdge, MeshFile, MeshGroup};
use crate::library::connect::{Client, answer};
use crate::library::error::ClientError;

/// The arrays of a mesh on their way.
struct Arrays {
    vertices_per_cell: usize,
    coordinates: Assembler<f64>,
    cells: Assembler<i32>,
    facets: Assembler<i32>,
    curved_edges: Assembler<i32>,
    edge_offsets: Assembler<f64>,
    groups: Vec<(v1::MeshGroup, Assembler<i32>)>,
}

impl Arrays {
    fn new(header: v1::MeshHeader) -> Result<Self, ClientError> {
        let vertices_per_cell = match header.cell_kind() {
            v1::CellKind::Triangle => 3,
            v1::CellKind::Tetrahedron => 4,
            v1::CellKind::Unspecified => return Err(missing("the kind of the cells")),
        };
        let groups = header.groups.into_iter().map(|group| {
            let members = assembler(group.member_count, 1)?;
            Ok((group, members))
        });
        Ok(Self {
            vertices_per_cell,
            coordinates: assembler(header.vertex_count, 3)?,
            cells: assembler(header.cell_count, vertices_per_cell)?,
            facets: assembler(header.facet_count, vertices_per_cell - 1)?,
            curved_edges: assembler(header.curved_edge_count, 2)?,
            edge_offsets: assembler(header.curved_edge_count, 3)?,
            groups: groups.collect::<Result<_, ClientError>>()?,
        })
    }

    fn add(&mut self, chunk: &v1::MeshChunk) -> Result<(), ClientError> {
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match chunk.array() {
            MeshArray::Coordinates => self.coordinates.push(offset, data)?,
            MeshArray::Cells => self.cells.push(offset, data)?,
            MeshArray::Facets => self.facets.push(offset, data)?,
            MeshArray::CurvedEdges => self.curved_edges.push(offset, data)?,
            MeshArray::EdgeOffsets => self.edge_offsets.push(offset, data)?,
            MeshArray::GroupMembers => {
                let index = usize::try_from(chunk.group_index).unwrap_or(usize::MAX);
                let group = self.groups.get_mut(index);
                let (_, members) = group.ok_or_else(|| missing("the group of a chunk"))?;
                members.push(offset, data)?;
            }
            MeshArray::Unspecified | MeshArray::Edges | MeshArray::CellEdges => {
                return Err(missing("an array of an uploaded mesh"));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<MeshFile, ClientError> {
        let coordinates = self.coordinates.finish()?;
        let (points, _) = coordinates.as_chunks::<3>();
        let dimension = self.vertices_per_cell - 1;
        let groups = self.groups.into_iter().map(|(group, members)| {
            let facets = group.kind() == v1::GroupKind::Facets;
            Ok(MeshGroup {
                dimension: dimension - usize::from(facets),
                members: indices(members)?,
                name: group.name,
            })
        });
        Ok(MeshFile {
            vertices_per_cell: self.vertices_per_cell,
            coordinates: points.to_vec(),
            cells: indices(self.cells)?,
            facets: indices(self.facets)?,
            groups: groups.collect::<Result<_, ClientError>>()?,
            curved: curved(self.curved_edges, self.edge_offsets)?,
            warnings: Vec::new(),
        })
    }
}

/// The curved edges from their two arrays.
fn curved(ends: Assembler<i32>, offsets: Assembler<f64>) -> Result<Vec<CurvedEdge>, ClientError> {
    let (ends, offsets) = (indices(ends)?, offsets.finish()?);
    let rows = ends.as_chunks::<2>().0.iter();
    let edges = rows.zip(offsets.as_chunks::<3>().0);
    let edge = |(&ends, &offset): (&[u32; 2], &[f64; 3])| CurvedEdge { ends, offset };
    Ok(edges.map(edge).collect())
}

/// Grows with what arrives, never with the announced count.
pub(crate) fn assembler<E: Element>(
    rows: i64,
    columns: usize,
) -> Result<Assembler<E>, ClientError> {
    let count = usize::try_from(rows).ok();
    let count = count.and_then(|rows| rows.checked_mul(columns));
    let count = count.ok_or_else(|| missing("a count of rows"))?;
    Ok(Assembler::new(count))
}

pub(crate) fn indices(array: Assembler<i32>) -> Result<Vec<u32>, ClientError> {
    let indices = array.finish()?.into_iter().map(u32::try_from);
    indices
        .collect::<Result<_, _>>()
        .map_err(|_| ClientError::Protocol("an index is negative".to_owned()))
}

impl Client {
    /// The arrays of a stored mesh (64 hexadecimal digits or `meshes/{digest}`):
    /// vertices and cells as they were uploaded, facets oriented outwards.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `MESH_NOT_FOUND`; [`ClientError::Array`] and
    /// [`ClientError::Protocol`] for arrays that do not fit the header.
    pub async fn read_mesh(&self, name: &str) -> Result<MeshFile, ClientError> {
        let request = v1::ReadMeshRequest {
            name: resource(name),
            arrays: Vec::new(),
        };
        let mut stream = answer(self.meshes().read_mesh(request)).await?.into_inner();
        let first = stream.message().await?.and_then(|first| first.part);
        let Some(Part::Header(header)) = first else {
            return Err(missing("the header of a mesh"));
        };
        let mut arrays = Arrays::new(header)?;
        while let Some(response) = stream.message().await? {
            let Some(Part::Chunk(chunk)) = response.part else {
                return Err(missing("a chunk of a mesh"));
            };
            arrays.add(&chunk)?;
        }
        arrays.finish()
    }
}

#[cfg(test)]
mod tests {
    use signorini_proto::array::encode;

    use super::*;

    fn header() -> v1::MeshHeader {
        let group = v1::MeshGroup {
            name: "base".to_owned(),
            kind: v1::GroupKind::Facets.into(),
            member_count: 1,
        };
        v1::MeshHeader {
            digest: String::new(),
            cell_kind: v1::CellKind::Triangle.into(),
            vertex_count: 3,
            cell_count: 1,
            facet_count: 1,
            groups: vec![group],
            curved_edge_count: 1,
            edge_count: 0,
        }
    }

    fn chunk<E: Element>(array: MeshArray, values: &[E]) -> v1::MeshChunk {
        v1::MeshChunk {
            array: array.into(),
            data: encode(values),
            ..Default::default()
        }
    }

    #[test]
    fn a_mesh_is_put_together_from_its_arrays() {
        let mut arrays = Arrays::new(header()).unwrap();
        let points = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        arrays.add(&chunk(MeshArray::Coordinates, &points)).unwrap();
        arrays.add(&chunk(MeshArray::Cells, &[0, 1, 2])).unwrap();
        arrays.add(&chunk(MeshArray::Facets, &[0, 1])).unwrap();
        arrays.add(&chunk(MeshArray::CurvedEdges, &[0, 2])).unwrap();
        let offset = chunk(MeshArray::EdgeOffsets, &[-0.25, 0.0, 0.0]);
        arrays.add(&offset).unwrap();
        arrays.add(&chunk(MeshArray::GroupMembers, &[0])).unwrap();
        let mesh = arrays.finish().unwrap();
        assert_eq!(
            mesh.coordinates[1].map(f64::to_bits),
            [1.0, 0.0, 0.0].map(f64::to_bits)
        );
        assert_eq!((mesh.cell_count(), mesh.facet_count()), (1, 1));
        assert_eq!(mesh.curved[0].ends, [0, 2]);
        assert_eq!(
            (mesh.groups[0].name.as_str(), mesh.groups[0].dimension),
            ("base", 1)
        );
    }

    #[test]
    fn arrays_that_do_not_fit_the_header_are_errors() {
        let mut arrays = Arrays::new(header()).unwrap();
        let other_group = v1::MeshChunk {
            group_index: 7,
            ..chunk(MeshArray::GroupMembers, &[0])
        };
        assert!(arrays.add(&other_group).is_err());
        assert!(arrays.add(&chunk(MeshArray::Cells, &[0, 1, 2, 3])).is_err());
        let short = Arrays::new(header()).unwrap();
        assert!(short.finish().is_err());
        let mut negative = Arrays::new(header()).unwrap();
        negative
            .add(&chunk(MeshArray::Coordinates, &[0.0; 9]))
            .unwrap();
        negative.add(&chunk(MeshArray::Cells, &[0, 1, -1])).unwrap();
        assert!(matches!(
            negative.finish(),
            Err(ClientError::Protocol(_) | ClientError::Array(_))
        ));
        let uncountable = v1::MeshHeader {
            vertex_count: -1,
            ..header()
        };
        assert!(Arrays::new(uncountable).is_err());
    }
}
