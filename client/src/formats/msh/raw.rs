//! The content of a mesh file before it is made into a mesh: nodes by number,
//! elements in blocks, and what ties them to physical groups.

use std::collections::{BTreeMap, HashMap};

use super::error::Fault;

/// A Gmsh element type that this reader knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementKind {
    /// 0 point, 1 line, 2 triangle, 3 tetrahedron.
    pub(super) dimension: usize,
    /// Nodes written in the file, vertices first.
    pub(super) nodes: usize,
}

impl ElementKind {
    /// Corners, which come first among the nodes of an element.
    pub(super) fn vertices(self) -> usize {
        self.dimension + 1
    }

    /// Ends of the edge of each further node, in the order of Gmsh: the last two edges
    /// of a tetrahedron are (2,3) and (1,3). None for elements of first order.
    pub(super) fn edges(self) -> &'static [(usize, usize)] {
        match (self.dimension, self.nodes) {
            (1, 3) => &[(0, 1)],
            (2, 6) => &[(0, 1), (1, 2), (0, 2)],
            (3, 10) => &[(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)],
            _ => &[],
        }
    }

    /// The kind of a Gmsh type number.
    pub(super) fn from_number(number: i64) -> Result<Self, Fault> {
        let (dimension, nodes) = match number {
            15 => (0, 1),
            1 => (1, 2),
            8 => (1, 3),
            2 => (2, 3),
            9 => (2, 6),
            4 => (3, 4),
            11 => (3, 10),
            other => return Err(Fault::UnsupportedElement(describe(other))),
        };
        Ok(Self { dimension, nodes })
    }
}

fn describe(number: i64) -> String {
    let name = match number {
        3 | 10 | 16 => "quadrangles",
        5 | 12 | 17 | 92 | 93 => "hexahedra",
        6 | 13 | 18 => "prisms",
        7 | 14 | 19 => "pyramids",
        20..=25 => "triangles of order three or more",
        26..=28 => "lines of order three or more",
        29..=31 => "tetrahedra of order three or more",
        _ => return format!("Gmsh element type {number}"),
    };
    format!("{name} (Gmsh element type {number})")
}

/// What says which physical groups a block of elements is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// A physical group number; zero is none (MSH 2.2).
    Physical(i64),
    /// The number of the geometric entity (MSH 4.1).
    Entity(i64),
}

/// Consecutive elements of one kind and owner.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) kind: ElementKind,
    pub(super) owner: Owner,
    /// Node numbers, `kind.nodes` for each element.
    pub(super) nodes: Vec<u64>,
}

/// Everything read from a file.
#[derive(Clone, Debug, Default)]
pub(super) struct RawMesh {
    /// Names by dimension and physical group number.
    pub(super) names: BTreeMap<(usize, i64), String>,
    /// Physical group numbers by dimension and entity number.
    pub(super) entities: HashMap<(usize, i64), Vec<i64>>,
    /// Node numbers with coordinates, in file order.
    pub(super) nodes: Option<Vec<(u64, [f64; 3])>>,
    /// Elements in file order.
    pub(super) blocks: Option<Vec<Block>>,
}
