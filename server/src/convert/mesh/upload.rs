//! The arrays of an upload, straight into the form that the library keeps.
//!
//! They grow with the chunks that arrive, never with what the header announces.

use signorini::mesh::{EdgeOffset, Group, MeshParts};
use signorini_proto::CHUNK_BYTES;
use signorini_proto::array::{ArrayError, Element, Progress};
use signorini_proto::v1 as wire;

use super::{Header, limit};
use crate::fault::Fault;

/// The arrays, still growing.
pub(crate) struct Upload {
    header: Header,
    coordinates: Points,
    cells: Indices,
    facets: Indices,
    curved_edges: Indices,
    edge_offsets: Points,
    members: Vec<Indices>,
}

impl Upload {
    pub(crate) fn new(header: Header) -> Self {
        Self {
            coordinates: Points::new(header.vertices),
            cells: Indices::new(header.cell_kind.vertices() * header.cells),
            facets: Indices::new(header.cell_kind.facet_vertices() * header.facets),
            curved_edges: Indices::new(2 * header.curved_edges),
            edge_offsets: Points::new(header.curved_edges),
            members: header
                .groups
                .iter()
                .map(|group| Indices::new(group.members))
                .collect(),
            header,
        }
    }

    /// Takes one chunk.
    ///
    /// # Errors
    /// `RequestInvalid` that names the array, `MessageLimit` for a chunk of more
    /// than 1 MiB, `MeshInvalid` for a negative index.
    pub(crate) fn push(&mut self, chunk: &wire::MeshChunk) -> Result<(), Fault> {
        let (offset, data) = (chunk.offset_elements, &chunk.data);
        match wire::MeshArray::try_from(chunk.array) {
            Ok(wire::MeshArray::Coordinates) => self.coordinates.push("coordinates", offset, data),
            Ok(wire::MeshArray::Cells) => self.cells.push("cells", offset, data),
            Ok(wire::MeshArray::Facets) => self.facets.push("facets", offset, data),
            Ok(wire::MeshArray::CurvedEdges) => {
                self.curved_edges.push("curved edges", offset, data)
            }
            Ok(wire::MeshArray::EdgeOffsets) => {
                self.edge_offsets.push("edge offsets", offset, data)
            }
            Ok(wire::MeshArray::GroupMembers) => self.push_members(chunk),
            Ok(
                wire::MeshArray::Unspecified | wire::MeshArray::Edges | wire::MeshArray::CellEdges,
            )
            | Err(_) => Err(Fault::request(
                "chunk.array",
                "names no array of an uploaded mesh",
            )),
        }
    }

    fn push_members(&mut self, chunk: &wire::MeshChunk) -> Result<(), Fault> {
        let index = usize::try_from(chunk.group_index).unwrap_or(usize::MAX);
        let group = self.header.groups.get(index);
        let (Some(group), Some(members)) = (group, self.members.get_mut(index)) else {
            let text = "names no group of the header";
            return Err(Fault::request("chunk.group_index", text));
        };
        let array = group_array(&group.name);
        members.push(&array, chunk.offset_elements, &chunk.data)
    }

    /// The library's arrays, and the offsets of curved edges.
    ///
    /// # Errors
    /// `RequestInvalid` when an array is incomplete.
    pub(crate) fn finish(self) -> Result<(MeshParts, Vec<EdgeOffset>), Fault> {
        let coordinates = self.coordinates.finish("coordinates")?;
        let offsets = offsets(self.curved_edges, self.edge_offsets)?;
        let mut groups = Vec::with_capacity(self.members.len());
        for (header, members) in self.header.groups.into_iter().zip(self.members) {
            groups.push(Group {
                members: members.finish(&group_array(&header.name))?,
                name: header.name,
                kind: header.kind,
            });
        }
        let parts = MeshParts {
            cell_kind: self.header.cell_kind,
            coordinates,
            cells: self.cells.finish("cells")?,
            facets: self.facets.finish("facets")?,
            groups,
        };
        Ok((parts, offsets))
    }
}

/// The offsets of curved edges from their two arrays.
fn offsets(ends: Indices, offsets: Points) -> Result<Vec<EdgeOffset>, Fault> {
    let ends = ends.finish("curved edges")?;
    let offsets = offsets.finish("edge offsets")?;
    let edges = ends.as_chunks::<2>().0.iter().zip(offsets);
    let edge = |(&ends, offset): (&[u32; 2], [f64; 3])| EdgeOffset { ends, offset };
    Ok(edges.map(edge).collect())
}

/// Points; a chunk may end within one.
pub(in crate::convert) struct Points {
    progress: Progress,
    rows: Vec<[f64; 3]>,
}

impl Points {
    pub(in crate::convert) fn new(expected: usize) -> Self {
        Self {
            progress: Progress::new(3 * expected),
            rows: Vec::new(),
        }
    }

    pub(in crate::convert) fn push(
        &mut self,
        array: &str,
        offset: i64,
        data: &[u8],
    ) -> Result<(), Fault> {
        let before = self.progress.received();
        named(array, self.progress.accept::<f64>(offset, data))?;
        let received = self.progress.received();
        self.rows.resize(received.div_ceil(3), [0.0; 3]);
        let places = self.rows.as_flattened_mut().iter_mut().skip(before);
        for (place, value) in places.zip(f64::read(data)) {
            *place = value;
        }
        Ok(())
    }

    pub(in crate::convert) fn finish(self, array: &str) -> Result<Vec<[f64; 3]>, Fault> {
        named(array, self.progress.finish())?;
        Ok(self.rows)
    }
}

/// Numbers.
pub(in crate::convert) struct Numbers {
    progress: Progress,
    values: Vec<f64>,
}

impl Numbers {
    pub(in crate::convert) fn new(expected: usize) -> Self {
        Self {
            progress: Progress::new(expected),
            values: Vec::new(),
        }
    }

    pub(in crate::convert) fn push(
        &mut self,
        array: &str,
        offset: i64,
        data: &[u8],
    ) -> Result<(), Fault> {
        named(array, self.progress.accept::<f64>(offset, data))?;
        self.values.extend(f64::read(data));
        Ok(())
    }

    pub(in crate::convert) fn finish(self, array: &str) -> Result<Vec<f64>, Fault> {
        named(array, self.progress.finish())?;
        Ok(self.values)
    }
}

/// Indices of vertices, cells or facets; signed on the wire.
pub(in crate::convert) struct Indices {
    progress: Progress,
    values: Vec<u32>,
}

impl Indices {
    pub(in crate::convert) fn new(expected: usize) -> Self {
        Self {
            progress: Progress::new(expected),
            values: Vec::new(),
        }
    }

    pub(in crate::convert) fn push(
        &mut self,
        array: &str,
        offset: i64,
        data: &[u8],
    ) -> Result<(), Fault> {
        named(array, self.progress.accept::<i32>(offset, data))?;
        let signs = i32::read(data).fold(0, |signs, value| signs | value);
        if signs < 0 {
            return Err(self.negative(array, data));
        }
        self.values.extend(i32::read(data).map(i32::cast_unsigned));
        Ok(())
    }

    fn negative(&self, array: &str, data: &[u8]) -> Fault {
        let mut entries = (self.values.len()..).zip(i32::read(data));
        let found = entries.find(|(_, value)| *value < 0);
        let (position, value) = found.unwrap_or_default();
        Fault::MeshInvalid(format!("{array}: entry {position} is {value}"))
    }

    pub(in crate::convert) fn finish(mut self, array: &str) -> Result<Vec<u32>, Fault> {
        named(array, self.progress.finish())?;
        self.values.shrink_to_fit();
        Ok(self.values)
    }
}

fn group_array(name: &str) -> String {
    format!("group `{name}`")
}

fn named<T>(array: &str, outcome: Result<T, ArrayError>) -> Result<T, Fault> {
    outcome.map_err(|error| match error {
        ArrayError::ChunkTooLarge(_) => limit("bytes in `chunk.data`", CHUNK_BYTES as i64),
        ArrayError::PartialElement { .. }
        | ArrayError::BadShape(_)
        | ArrayError::WrongLength { .. }
        | ArrayError::WrongOffset { .. } => Fault::request(array, error.to_string()),
    })
}
