//! What can be wrong with a VTK file, and where.

use std::fmt;

use crate::formats::mesh::MeshFault;

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VtkFault {
    /// Neither form of the format.
    #[error("not a VTK file: it begins neither with `# vtk DataFile` nor with XML")]
    NotVtk,
    /// Text that is no XML.
    #[error("the XML is not well formed: {0}")]
    Xml(String),
    /// Something that the format allows and this reader does not take.
    #[error("not supported yet: {0}")]
    Unsupported(String),
    /// A part that must exist does not.
    #[error("{0} is missing")]
    Missing(&'static str),
    /// Something else stands where a value belongs.
    #[error("{expected} is expected, found {found}")]
    Unexpected {
        /// What belongs here.
        expected: &'static str,
        /// The beginning of what is there.
        found: String,
    },
    /// The data end too early.
    #[error("the data end where {0} is expected")]
    Truncated(&'static str),
    /// A count that the rest of the file cannot hold.
    #[error("{declared} values are declared, more than the rest of the file can hold")]
    Count {
        /// The declared value.
        declared: u64,
    },
    /// An array that is longer or shorter than the others ask for.
    #[error("{expected} values are expected, found {found}")]
    Length {
        /// Asked for.
        expected: usize,
        /// There.
        found: usize,
    },
    /// Compressed data that cannot be restored.
    #[error("the compressed data are damaged")]
    Compression,
    /// Text that is no base64.
    #[error("the data are no base64")]
    Base64,
    /// A cell shape that the solver does not have.
    #[error(
        "{0}: triangles, quadrangles, tetrahedra, hexahedra, wedges and pyramids of first and second order carry a solution"
    )]
    UnsupportedCell(String),
    /// A cell with a point that does not exist.
    #[error("it refers to point {point} of {count}")]
    UnknownPoint {
        /// Index found.
        point: i64,
        /// Points of the file.
        count: usize,
    },
    /// Points and cells that make no mesh; nodes are points, from 0.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
}

/// Where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a legacy file, from 1.
    Line(usize),
    /// Name of an array.
    Array(String),
    /// Index of a cell, from 0.
    Cell(usize),
}

/// A fault with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VtkError {
    /// None when the fault concerns the file as a whole.
    pub place: Option<Place>,
    /// What.
    pub fault: VtkFault,
}

impl VtkFault {
    /// Of the file as a whole.
    pub(super) fn whole(self) -> VtkError {
        VtkError {
            place: None,
            fault: self,
        }
    }

    /// At a place.
    pub(super) fn at(self, place: Place) -> VtkError {
        VtkError {
            place: Some(place),
            fault: self,
        }
    }

    /// Of an array.
    pub(super) fn in_array(self, name: &str) -> VtkError {
        self.at(Place::Array(name.to_owned()))
    }
}

impl fmt::Display for VtkError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(Place::Line(line)) => write!(out, "line {line}: ")?,
            Some(Place::Array(name)) => write!(out, "array {name}: ")?,
            Some(Place::Cell(cell)) => write!(out, "cell {cell}: ")?,
            None => {}
        }
        write!(out, "{}", self.fault)
    }
}

impl std::error::Error for VtkError {}
