//! What can be wrong with a mesh file, and where.

use std::fmt;

use crate::formats::mesh::MeshFault;

/// A place in the file: lines for text, bytes for binary data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// Line, from 1.
    Line(usize),
    /// Byte offset, from 0.
    Byte(usize),
}

impl fmt::Display for Position {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(out, "line {line}"),
            Self::Byte(offset) => write!(out, "byte {offset}"),
        }
    }
}

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The file does not begin with `$MeshFormat`.
    #[error(
        "not a Gmsh MSH file: it does not begin with $MeshFormat; convert it with `gmsh -save \
         -format msh41 -o OUT.msh IN` or `meshio convert IN OUT.msh`, its named groups with it"
    )]
    NotMsh,
    /// A version other than 2.2 and 4.1.
    #[error(
        "MSH version {0} is not supported: write version 4.1 or 2.2 (Gmsh option Mesh.MshFileVersion)"
    )]
    Version(String),
    /// Binary data of a machine with the other byte order.
    #[error(
        "binary data has the byte order of another machine (big-endian); write it as text or little-endian"
    )]
    ForeignByteOrder,
    /// Integers or reals of an unexpected size.
    #[error("data size {0} is not supported: 8 is expected")]
    DataSize(i64),
    /// The file ends too early.
    #[error("the file ends where {0} is expected")]
    Truncated(&'static str),
    /// Something else stands where a value belongs.
    #[error("{expected} is expected, found {found}")]
    Unexpected {
        /// What belongs here.
        expected: &'static str,
        /// The beginning of what is there.
        found: String,
    },
    /// A count that the rest of the file cannot hold.
    #[error("{what} is declared as {declared}, but only {remaining} bytes of the file remain")]
    Count {
        /// What is counted.
        what: &'static str,
        /// The declared value.
        declared: u64,
        /// Bytes left.
        remaining: usize,
    },
    /// Two counts that contradict each other.
    #[error("{what}: {declared} declared, {found} found")]
    Inconsistent {
        /// What is counted.
        what: &'static str,
        /// The declared value.
        declared: u64,
        /// The value found.
        found: u64,
    },
    /// A section that must exist does not.
    #[error("section ${0} is missing")]
    MissingSection(&'static str),
    /// A section that must be unique is not.
    #[error("section ${0} appears twice")]
    RepeatedSection(&'static str),
    /// A section without its end.
    #[error("section ${0} has no $End{0}")]
    Unterminated(String),
    /// An element shape that the solver does not have.
    #[error("not supported yet: {0}; cells of first and second order carry a solution")]
    UnsupportedElement(String),
    /// A partitioned mesh.
    #[error("not supported yet: partitioned meshes (section $PartitionedEntities)")]
    Partitioned,
    /// Nodes and elements that make no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
}

/// A fault with its section and place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MshError {
    /// Section without the dollar sign; none outside sections.
    pub section: Option<String>,
    /// Where; none when the fault concerns the mesh as a whole.
    pub position: Option<Position>,
    /// What.
    pub fault: Fault,
}

impl MshError {
    /// A fault of the mesh as a whole.
    pub(super) fn whole(fault: Fault) -> Self {
        Self {
            section: None,
            position: None,
            fault,
        }
    }
}

impl fmt::Display for MshError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(position) = self.position {
            write!(out, "{position}: ")?;
        }
        if let Some(section) = &self.section {
            write!(out, "in ${section}: ")?;
        }
        write!(out, "{}", self.fault)
    }
}

impl std::error::Error for MshError {}
