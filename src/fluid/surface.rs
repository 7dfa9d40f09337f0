//! The surface that a fluid can reach, as a graph of its displacement nodes.
//!
//! Shapes: all vectors `[nodes of the surface]`, ascending by node. Cost: one sort of the nodes
//! and one of their pairs.

use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// Pairs of a segment's nodes that are beside each other: corners, then the middle.
const SEGMENT: &[[usize; 2]] = &[[0, 2], [2, 1]];
/// The same of a triangle: corners, then the middles of (0, 1), (0, 2), (1, 2).
const TRIANGLE: &[[usize; 2]] = &[
    [0, 3],
    [3, 1],
    [0, 4],
    [4, 2],
    [1, 5],
    [5, 2],
    [3, 4],
    [3, 5],
    [4, 5],
];

/// Facets that a fluid can reach, with what it starts from and what it must not reach.
#[derive(Clone, Copy, Debug)]
pub struct Reach<'a> {
    /// Facets on which it may act.
    pub facets: &'a [u32],
    /// Facets that are wet from the start, among them.
    pub from: &'a [u32],
    /// Facets that it must not reach.
    pub dry: &'a [u32],
}

/// The surface of a fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidSurface {
    /// Displacement nodes, ascending.
    pub nodes: Vec<u32>,
    /// Whether a node is wet from the start.
    pub sources: Vec<bool>,
    /// Whether a node must stay dry.
    pub dry: Vec<bool>,
    /// Nodes of each facet, by their places here: corners, then edges.
    pub facets: Vec<Vec<u32>>,
    /// Where the neighbours of each node begin; one more at the end.
    starts: Vec<u32>,
    /// Neighbours of all nodes, one node after the other, ascending.
    neighbours: Vec<u32>,
}

impl FluidSurface {
    /// The surface of `reach` on `mesh`.
    pub fn new(mesh: &Mesh, space: &TaylorHood, reach: Reach<'_>) -> Self {
        let of_facets = |facets: &[u32]| -> Vec<Vec<u32>> {
            let facets = facets.iter();
            facets
                .map(|&facet| space.facet_nodes(mesh.facet(facet as usize)))
                .collect()
        };
        let by_nodes = of_facets(reach.facets);
        let nodes = sorted(by_nodes.concat());
        let place = |node: &u32| nodes.partition_point(|other| other < node) as u32;
        let facets = by_nodes.iter().map(|own| own.iter().map(place).collect());
        let facets: Vec<Vec<u32>> = facets.collect();
        let is_among = |facets: &[u32]| -> Vec<bool> {
            let chosen = sorted(of_facets(facets).concat());
            let is_chosen = |node: &u32| chosen.binary_search(node).is_ok();
            nodes.iter().map(is_chosen).collect()
        };
        let (starts, neighbours) = graph(nodes.len(), pairs(&facets));
        Self {
            sources: is_among(reach.from),
            dry: is_among(reach.dry),
            facets,
            starts,
            neighbours,
            nodes,
        }
    }

    /// The nodes beside node `place`, by their places.
    pub fn beside(&self, place: usize) -> impl Iterator<Item = usize> + '_ {
        let own = self.starts[place] as usize..self.starts[place + 1] as usize;
        self.neighbours[own].iter().map(|&other| other as usize)
    }

    /// The same where just the nodes of these pairs, by their places, are beside each other.
    pub fn with_neighbours(&self, pairs: impl Iterator<Item = [usize; 2]>) -> Self {
        let pairs = pairs.map(|pair| pair.map(|place| place as u32)).collect();
        let (starts, neighbours) = graph(self.nodes.len(), pairs);
        Self {
            starts,
            neighbours,
            ..self.clone()
        }
    }

    /// The first wet node, by its place, that must stay `dry`.
    pub fn leak(wet: &[bool], dry: &[bool]) -> Option<usize> {
        wet.iter().zip(dry).position(|(wet, dry)| *wet && *dry)
    }

    /// Values at its nodes of quadratic Bernstein functions with these coefficients: half of an edge's
    /// and a quarter of its ends'.
    pub fn values(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut values = coefficients.to_vec();
        for nodes in &self.facets {
            let corners = if nodes.len() == 3 { 2 } else { 3 };
            let mut edge = corners;
            for a in 0..corners {
                for b in a + 1..corners {
                    let [a, b, e] = [a, b, edge].map(|k| nodes[k] as usize);
                    let ends = coefficients[a] + coefficients[b];
                    values[e] = 0.5 * coefficients[e] + 0.25 * ends;
                    edge += 1;
                }
            }
        }
        values
    }

    /// Its part of values of all displacement nodes.
    pub fn own<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.nodes.iter().map(|&node| all[node as usize]).collect()
    }
}

fn sorted(mut nodes: Vec<u32>) -> Vec<u32> {
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Nodes that are beside each other on facets, either way.
fn pairs(facets: &[Vec<u32>]) -> Vec<[u32; 2]> {
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for own in facets {
        let sides = if own.len() == 3 { SEGMENT } else { TRIANGLE };
        for side in sides {
            let [a, b] = side.map(|k| own[k]);
            pairs.extend([[a, b], [b, a]]);
        }
    }
    pairs
}

/// Starts and neighbours of every node.
fn graph(nodes: usize, mut pairs: Vec<[u32; 2]>) -> (Vec<u32>, Vec<u32>) {
    pairs.sort_unstable();
    pairs.dedup();
    let start = |node: usize| pairs.partition_point(|pair| (pair[0] as usize) < node) as u32;
    let starts = (0..=nodes).map(start).collect();
    (starts, pairs.iter().map(|pair| pair[1]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{GroupKind, samples};

    fn group(mesh: &Mesh, name: &str) -> Vec<u32> {
        let group = mesh.group(name, GroupKind::Facets).expect("a side");
        group.members.clone()
    }

    #[test]
    fn nodes_along_a_side_are_joined_through_the_middles_of_its_facets() {
        let mesh = samples::rectangle(2, 1);
        let space = TaylorHood::new(&mesh);
        let [bottom, left, right] = ["y0", "x0", "x1"].map(|name| group(&mesh, name));
        let reach = Reach {
            facets: &bottom,
            from: &left,
            dry: &right,
        };
        let surface = FluidSurface::new(&mesh, &space, reach);
        assert_eq!(surface.nodes.len(), 5);
        let degrees = (0..5).map(|place| surface.beside(place).count());
        assert_eq!(degrees.filter(|&degree| degree == 1).count(), 2);
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
        assert_eq!([count(&surface.sources), count(&surface.dry)], [1, 1]);
    }

    #[test]
    fn nodes_of_a_face_are_joined_along_the_sides_of_its_four_parts() {
        let mesh = samples::cube(1);
        let space = TaylorHood::new(&mesh);
        let top = group(&mesh, "z1");
        let reach = Reach {
            facets: &top,
            from: &[],
            dry: &[],
        };
        let surface = FluidSurface::new(&mesh, &space, reach);
        // Two triangles: 9 nodes; 18 sides of parts, of which 2 are common.
        let pairs: usize = (0..9).map(|place| surface.beside(place).count()).sum();
        assert_eq!((surface.nodes.len(), pairs), (9, 2 * 16));
        for place in 0..9 {
            assert!(
                surface
                    .beside(place)
                    .all(|other| surface.beside(other).any(|one| one == place))
            );
        }
    }
}
