//! What can be wrong with an Abaqus file, and where.

use std::fmt;

use crate::formats::mesh::MeshFault;

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InpFault {
    /// No line of the file is a keyword.
    #[error("not an Abaqus input file: no line begins with * and a keyword")]
    NotInp,
    /// The mesh, or a part of it, is in another file, and there is no folder to look into.
    #[error(
        "the file {0} is included, and these bytes come without a folder: give the path of the deck, with the file beside it"
    )]
    Include(String),
    /// A file that is included and cannot be.
    #[error("the file {file} is included: {said}")]
    NotIncluded {
        /// As the deck names it.
        file: String,
        /// Why it cannot be.
        said: String,
    },
    /// An instance of no part.
    #[error("there is no part {0}")]
    UnknownPart(String),
    /// An instance that is named and is not there.
    #[error("there is no instance {0}")]
    UnknownInstance(String),
    /// Two instances of one name.
    #[error("there are two instances {0}")]
    DuplicateInstance(String),
    /// Instances whose parts take more than a file of this size may have.
    #[error(
        "the instances have more than {0} nodes and elements in all, four for each byte of the file: write them as one part"
    )]
    TooManyCopies(usize),
    /// Something that the format allows and this reader does not take.
    #[error("not supported yet: {0}")]
    Unsupported(String),
    /// An element shape that the solver does not have.
    #[error(
        "elements of type {0}: tetrahedra (C3D4, C3D10), hexahedra (C3D8, C3D20), wedges (C3D6, C3D15), pyramids (C3D5, C3D13), triangles and quadrangles (CPE, CPS, CAX with 3, 4, 6 or 8), each with suffixes such as H, R and M, carry a solution"
    )]
    UnsupportedElement(String),
    /// A keyword without a parameter that it needs.
    #[error("the parameter {0} is missing")]
    MissingParameter(&'static str),
    /// Something else stands where a value belongs.
    #[error("{expected} is expected, found {found}")]
    Unexpected {
        /// What belongs here.
        expected: &'static str,
        /// The beginning of what is there.
        found: String,
    },
    /// An element with too many or too few nodes.
    #[error("element {element} of type {kind} has {expected} nodes, found {found}")]
    NodeCount {
        /// Its number.
        element: u64,
        /// Its type.
        kind: String,
        /// Nodes of the type.
        expected: usize,
        /// Numbers found.
        found: usize,
    },
    /// An element number used twice.
    #[error("element {0} is defined twice")]
    DuplicateElement(u64),
    /// An element with a node that does not exist.
    #[error("element {element} refers to node {node}, which does not exist")]
    UnknownNode {
        /// Number of the element.
        element: u64,
        /// Number of the node.
        node: u64,
    },
    /// A set that is named before it is defined.
    #[error("there is no set {0}")]
    UnknownSet(String),
    /// An element that is named and does not exist.
    #[error("there is no element {0}")]
    UnknownElement(u64),
    /// A face that an element does not have.
    #[error("element {element} has no face {face}")]
    UnknownFace {
        /// Number of the element.
        element: u64,
        /// Identifier of the face, such as `S5`.
        face: String,
    },
    /// Sets with more members than the file may have.
    #[error("the sets have more than {0} members, four for each byte of the file")]
    TooManyMembers(usize),
    /// Nodes and elements that make no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
}

impl InpFault {
    /// The words for copies of parts where those for members of sets are.
    pub(super) fn copies(self) -> Self {
        if let Self::TooManyMembers(limit) = self {
            Self::TooManyCopies(limit)
        } else {
            self
        }
    }
}

/// A fault with its keyword and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InpError {
    /// The file that is included where the line is; none in the deck itself.
    pub file: Option<String>,
    /// Line, from 1; none when the fault concerns the mesh as a whole.
    pub line: Option<usize>,
    /// Keyword in capitals, without its star; none outside one.
    pub keyword: Option<String>,
    /// What.
    pub fault: InpFault,
}

impl InpError {
    /// A fault of the mesh as a whole.
    pub(super) fn whole(fault: InpFault) -> Self {
        Self {
            file: None,
            line: None,
            keyword: None,
            fault,
        }
    }
}

impl fmt::Display for InpError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(out, "{file}: ")?;
        }
        if let Some(line) = self.line {
            write!(out, "line {line}: ")?;
        }
        if let Some(keyword) = &self.keyword {
            write!(out, "in *{keyword}: ")?;
        }
        write!(out, "{}", self.fault)
    }
}

impl std::error::Error for InpError {}
