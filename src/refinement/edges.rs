//! Edges of a mesh under bisection: those that it began with keep their numbers, new ones follow,
//! and each of these knows how a quadratic continues on it,
//!
//! ```text
//! c = value in the middle - mean of the ends
//! half of an edge e:                          c = c_e / 4
//! from the middle of e = (a, b) to k:         c = (c_ak + c_bk) / 2 - c_e / 4
//! at the middle of e:                         u = (u_a + u_b) / 2 + c_e
//! ```
//!
//! which holds for displacements and for the offsets of curved edges alike. Both cells at a facet
//! name its edges alike, so that what is inherited is the same from either. Cost: one look-up an
//! edge of a cell that is halved.

use std::collections::HashMap;

use crate::mesh::Mesh;

/// Where an edge comes from, by numbers of earlier edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Recipe {
    /// Half of an edge.
    Half(u32),
    /// From the middle of an edge to a vertex, with the edges from that vertex to its ends.
    Spoke {
        /// The edge whose middle it starts at.
        halved: u32,
        /// The edges from its ends to the same vertex.
        sides: [u32; 2],
    },
}

impl Recipe {
    /// Earlier edges with their shares of c.
    pub(super) fn shares(self) -> [(u32, f64); 3] {
        match self {
            Self::Half(whole) => [(whole, 0.25), (whole, 0.0), (whole, 0.0)],
            Self::Spoke { halved, sides } => [(sides[0], 0.5), (sides[1], 0.5), (halved, -0.25)],
        }
    }
}

/// A vertex that a bisection has made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Middle {
    /// Ends of the edge that it halves.
    pub(super) ends: [u32; 2],
    /// Number of that edge.
    pub(super) edge: u32,
}

/// All edges so far.
pub(super) struct Edges<'a> {
    /// The mesh at the start.
    mesh: &'a Mesh,
    /// New edges, by their ends.
    numbers: HashMap<[u32; 2], u32>,
    /// Vertex in the middle of each edge that is halved.
    halved: HashMap<u32, u32>,
    /// How each new edge continues what there was.
    pub(super) recipes: Vec<Recipe>,
    /// Ends of each new edge, ascending.
    pub(super) ends: Vec<[u32; 2]>,
    /// New vertices, numbered after those at the start.
    pub(super) middles: Vec<Middle>,
}

impl<'a> Edges<'a> {
    /// Those of a mesh.
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        Self {
            mesh,
            numbers: HashMap::new(),
            halved: HashMap::new(),
            recipes: Vec::new(),
            ends: Vec::new(),
            middles: Vec::new(),
        }
    }

    /// The number of an edge.
    pub(super) fn number(&self, a: u32, b: u32) -> Option<u32> {
        let ends = [a.min(b), a.max(b)];
        if (ends[1] as usize) < self.mesh.coordinates().len() {
            self.mesh.edge_between(a, b)
        } else {
            self.numbers.get(&ends).copied()
        }
    }

    /// The vertex in the middle of an edge that is halved.
    pub(super) fn middle(&self, a: u32, b: u32) -> Option<u32> {
        let edge = self.number(a, b)?;
        self.halved.get(&edge).copied()
    }

    /// Whether an edge, old or new, is whole.
    pub(super) fn is_whole(&self, edge: u32) -> bool {
        !self.halved.contains_key(&edge)
    }

    /// The vertex in the middle of an edge, which it halves if it is whole.
    pub(super) fn halve(&mut self, a: u32, b: u32) -> Option<u32> {
        let edge = self.number(a, b)?;
        if let Some(&middle) = self.halved.get(&edge) {
            return Some(middle);
        }
        let middle = (self.mesh.coordinates().len() + self.middles.len()) as u32;
        self.middles.push(Middle {
            ends: [a.min(b), a.max(b)],
            edge,
        });
        self.halved.insert(edge, middle);
        for end in [a.min(b), a.max(b)] {
            self.add([end, middle], Recipe::Half(edge));
        }
        Some(middle)
    }

    /// The edge from the middle of (a, b) to a vertex that has edges to both.
    pub(super) fn join(&mut self, middle: u32, [a, b]: [u32; 2], vertex: u32) -> Option<()> {
        let ends = [middle.min(vertex), middle.max(vertex)];
        if self.numbers.contains_key(&ends) {
            return Some(());
        }
        let halved = self.number(a, b)?;
        let sides = [self.number(a, vertex)?, self.number(b, vertex)?];
        self.add(ends, Recipe::Spoke { halved, sides });
        Some(())
    }

    /// A new edge.
    fn add(&mut self, ends: [u32; 2], recipe: Recipe) {
        let number = (self.mesh.edges().len() + self.recipes.len()) as u32;
        self.numbers.insert(ends, number);
        self.recipes.push(recipe);
        self.ends.push(ends);
    }
}
