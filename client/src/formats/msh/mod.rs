//! Reads Gmsh MSH 4.1 and 2.2, text and binary, into vertices, cells, facets
//! and named groups, and writes the latter in text.
//!
//! Assumptions: cells of first or second order; hexahedra, wedges, pyramids and quadrangles are
//! split ([`super::mesh`]). Of second order the
//! edges of the surface keep how far their middle is off the line between their ends;
//! the highest dimension present gives the cells, the next lower one the facets. Vertices are ordered
//! by node number, elements as in the file. Unnamed physical groups are named
//! by their number. Sections of other names are left out; comments may stand before the first one.
//!
//! Cost: one pass over the bytes and one hash look-up an element. No allocation
//! is larger than a constant times the size of the file, whatever it declares.

mod cursor;
mod error;
mod kind;
mod v22;
mod v41;
mod write;

#[cfg(test)]
mod tests;

pub use super::mesh::{CurvedEdge, MeshFile, MeshGroup};
pub use error::{Fault, MshError, Position};
pub use write::{WriteError, write};

use super::mesh;
use super::mesh::raw::{Block, RawMesh};
use cursor::{Cursor, Encoding};

/// Everything read from a file.
#[derive(Default)]
struct Sections {
    raw: RawMesh,
    nodes: Option<Vec<(u64, [f64; 3])>>,
    blocks: Option<Vec<Block>>,
}

impl Sections {
    fn mesh(self) -> Result<MeshFile, MshError> {
        let missing = |section| MshError::whole(Fault::MissingSection(section));
        let nodes = self.nodes.ok_or_else(|| missing("Nodes"))?;
        let blocks = self.blocks.ok_or_else(|| missing("Elements"))?;
        let raw = RawMesh {
            nodes,
            blocks,
            ..self.raw
        };
        mesh::build(&raw).map_err(|fault| MshError::whole(fault.into()))
    }
}

/// Reads a mesh file.
///
/// # Errors
/// The first fault found, with its section and its line or byte offset.
pub fn read(bytes: &[u8]) -> Result<MeshFile, MshError> {
    let mut cursor = Cursor::new(bytes);
    let version = format(&mut cursor)?;
    let mut sections = Sections::default();
    while let Some(section) = cursor.open_section()? {
        read_section(&mut cursor, version, &section, &mut sections)?;
    }
    sections.mesh()
}

/// The two versions differ in their sections of nodes and elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    V22,
    V41,
}

fn format(cursor: &mut Cursor<'_>) -> Result<Version, MshError> {
    loop {
        match cursor.open_section() {
            Ok(Some(section)) if section == "MeshFormat" => break,
            Ok(Some(section)) if section == "Comments" => cursor.skip_section()?,
            _ => return Err(MshError::whole(Fault::NotMsh)),
        }
    }
    let word = cursor.word("the version")?;
    let version = match word.as_str() {
        "2.2" => Version::V22,
        "4.1" => Version::V41,
        _ => return Err(cursor.error(Fault::Version(word))),
    };
    let file_type = cursor.text_integer("the file type (0 text, 1 binary)")?;
    let data_size = cursor.text_integer("the data size")?;
    if data_size != 8 {
        return Err(cursor.error(Fault::DataSize(data_size)));
    }
    match file_type {
        0 => {}
        1 => binary_mark(cursor)?,
        other => {
            let (expected, found) = ("the file type (0 text, 1 binary)", other.to_string());
            return Err(cursor.error(Fault::Unexpected { expected, found }));
        }
    }
    cursor.close_section()?;
    Ok(version)
}

/// The integer one tells the byte order of binary data.
fn binary_mark(cursor: &mut Cursor<'_>) -> Result<(), MshError> {
    cursor.end_line();
    cursor.set_encoding(Encoding::Binary);
    let mark = cursor.integer("the byte order mark")?;
    match mark {
        1 => Ok(()),
        0x0100_0000 => Err(cursor.error(Fault::ForeignByteOrder)),
        other => {
            let (expected, found) = ("the byte order mark", other.to_string());
            Err(cursor.error(Fault::Unexpected { expected, found }))
        }
    }
}

fn read_section(
    cursor: &mut Cursor<'_>,
    version: Version,
    section: &str,
    file: &mut Sections,
) -> Result<(), MshError> {
    match (section, version) {
        ("PhysicalNames", _) => physical_names(cursor, &mut file.raw)?,
        ("Entities", Version::V41) => file.raw.entities = v41::entities(cursor)?,
        ("PartitionedEntities", _) => return Err(cursor.error(Fault::Partitioned)),
        ("Nodes", _) => {
            let nodes = match version {
                Version::V22 => v22::nodes(cursor)?,
                Version::V41 => v41::nodes(cursor)?,
            };
            once(cursor, &mut file.nodes, nodes, "Nodes")?;
        }
        ("Elements", _) => {
            let blocks = match version {
                Version::V22 => v22::elements(cursor)?,
                Version::V41 => v41::elements(cursor)?,
            };
            once(cursor, &mut file.blocks, blocks, "Elements")?;
        }
        _ => return cursor.skip_section(),
    }
    cursor.close_section()
}

fn once<T>(
    cursor: &Cursor<'_>,
    slot: &mut Option<T>,
    value: T,
    section: &'static str,
) -> Result<(), MshError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(cursor.error(Fault::RepeatedSection(section))),
    }
}

/// Names are text in both encodings.
fn physical_names(cursor: &mut Cursor<'_>, raw: &mut RawMesh) -> Result<(), MshError> {
    let what = "the number of physical names";
    let declared = cursor.text_integer(what)?;
    for _ in 0..declared {
        let dimension = dimension(cursor)?;
        let tag = cursor.text_integer("a physical number")?;
        let name = cursor.quoted("a name in double quotes")?;
        raw.names.insert((dimension, tag), name);
    }
    Ok(())
}

fn dimension(cursor: &mut Cursor<'_>) -> Result<usize, MshError> {
    let expected = "a dimension";
    let number = cursor.text_integer(expected)?;
    usize::try_from(number).map_err(|_| {
        let found = number.to_string();
        cursor.error(Fault::Unexpected { expected, found })
    })
}
