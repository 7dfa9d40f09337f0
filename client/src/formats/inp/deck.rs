//! What an Abaqus file holds: nodes, elements, sets and surfaces.

use super::sets::Sets;
use crate::formats::mesh::raw::ElementKind;

/// An element of any dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) number: u64,
    pub(super) kind: ElementKind,
    /// Where its nodes begin in [`Deck::element_nodes`].
    first: usize,
}

/// Faces of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    /// `S1` to `S6` of cells.
    Number(usize),
    /// The faces of cells that are on the surface of the body, or elements of the surface.
    Outer,
}

/// One line of a surface.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// A set of elements, or one element by its number.
    pub(super) of: Result<usize, u64>,
    pub(super) face: Face,
}

/// A surface made of faces of elements.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) name: String,
    /// Name of the instance that it is of; empty where it is of none.
    pub(super) owner: String,
    pub(super) entries: Vec<Entry>,
}

/// The largest numbers of a deck; zero where there are none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest {
    pub(super) node: u64,
    pub(super) element: u64,
}

/// The content of a file, or of a part of it.
#[derive(Clone, Default)]
pub(super) struct Deck {
    pub(super) nodes: Vec<(u64, [f64; 3])>,
    pub(super) elements: Vec<Element>,
    element_nodes: Vec<u64>,
    pub(super) node_sets: Sets,
    pub(super) element_sets: Sets,
    /// Sets of nodes that hold the nodes of sets of elements.
    pub(super) nodes_of_elements: Vec<(usize, usize)>,
    pub(super) surfaces: Vec<Surface>,
    /// Sets of elements with the name of their material.
    pub(super) sections: Vec<(usize, String)>,
    pub(super) largest: Largest,
    pub(super) warnings: Vec<String>,
    /// Types of elements of the file with their dimensions, each once.
    pub(super) types: Vec<(String, usize)>,
}

impl Deck {
    /// Node numbers of an element.
    pub(super) fn nodes_of(&self, element: &Element) -> &[u64] {
        let range = element.first..element.first + element.kind.nodes;
        self.element_nodes.get(range).unwrap_or_default()
    }

    /// Adds a node.
    pub(super) fn push_node(&mut self, number: u64, point: [f64; 3]) {
        self.largest.node = self.largest.node.max(number);
        self.nodes.push((number, point));
    }

    /// Adds an element and its nodes.
    pub(super) fn push(&mut self, number: u64, kind: ElementKind, nodes: &[u64]) {
        self.largest.element = self.largest.element.max(number);
        let first = self.element_nodes.len();
        self.element_nodes.extend(nodes);
        self.elements.push(Element {
            number,
            kind,
            first,
        });
    }
}
