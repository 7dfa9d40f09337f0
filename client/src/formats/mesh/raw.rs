//! The content of a mesh file before it is made into a mesh: nodes by number,
//! elements in blocks, and what ties them to groups. Readers of every format fill it.

use std::collections::{BTreeMap, HashMap};

/// An element that a mesh can be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ElementKind {
    /// 0 point, 1 line, 2 triangle or quadrangle, 3 a cell of the space.
    pub(crate) dimension: usize,
    /// Nodes of an element, corners first; their number tells the shape.
    pub(crate) nodes: usize,
}

/// What says which groups a block of elements is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// A group number; zero is none. Elements of the same nodes are copies of one (MSH 2.2).
    Physical(i64),
    /// A number that `RawMesh::entities` has the groups of.
    Entity(i64),
}

/// Consecutive elements of one kind and owner.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) kind: ElementKind,
    pub(crate) owner: Owner,
    /// Node numbers, `kind.nodes` for each element.
    pub(crate) nodes: Vec<u64>,
}

/// Everything read from a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct RawMesh {
    /// Names by dimension and group number.
    pub(crate) names: BTreeMap<(usize, i64), String>,
    /// Group numbers by dimension and entity number.
    pub(crate) entities: HashMap<(usize, i64), Vec<i64>>,
    /// Node numbers with coordinates, in file order.
    pub(crate) nodes: Vec<(u64, [f64; 3])>,
    /// Elements in file order.
    pub(crate) blocks: Vec<Block>,
}

impl RawMesh {
    /// Adds an element, joined to the last block where they fit.
    pub(crate) fn push(&mut self, kind: ElementKind, owner: Owner, nodes: &[u64]) {
        match self.blocks.last_mut() {
            Some(last) if last.kind == kind && last.owner == owner => last.nodes.extend(nodes),
            _ => self.blocks.push(Block {
                kind,
                owner,
                nodes: nodes.to_vec(),
            }),
        }
    }
}
