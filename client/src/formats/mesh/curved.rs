//! Where the middles of edges are, from elements of second order:
//!
//! ```text
//! offset of an edge = middle - (a + b) / 2
//! ```
//!
//! Cells and facets that share an edge must agree on its middle. Only edges of the
//! surface keep an offset, and only one that is more than rounding: inside the body
//! edges are lines. Cost: one sort of all edges, nothing in a mesh of first order.

use std::collections::HashMap;

use super::CurvedEdge;
use super::fault::MeshFault;
use super::plane::{PLANE_TOLERANCE, extent};
use super::raw::Block;

/// Distance over the length of an edge that is taken as rounding.
const ROUNDING: f64 = 1e-9;
/// Offset over the length of an edge at most: that of a half circle.
const FARTHEST: f64 = 0.5;

/// The middle of an edge as one element has it.
struct Middle {
    /// Vertices by their own numbers, the lower one first.
    ends: [u32; 2],
    /// Number of the node in the file.
    node: u64,
}

/// Nodes and elements of a file with the mesh that they give.
pub(super) struct Source<'a> {
    /// Node numbers with coordinates, in file order.
    pub(super) nodes: &'a [(u64, [f64; 3])],
    /// Elements in file order.
    pub(super) blocks: &'a [Block],
    /// Of the cells.
    pub(super) dimension: usize,
    /// Coordinates of the vertices.
    pub(super) coordinates: &'a [[f64; 3]],
    /// Vertices of the cells, flat.
    pub(super) cells: &'a [u32],
}

impl Source<'_> {
    /// The curved edges of the surface, ascending; `index` numbers the vertices by their
    /// nodes, `tag` finds the node of a vertex.
    pub(super) fn edges(
        &self,
        index: impl Fn(u64) -> Result<u32, MeshFault>,
        tag: impl Fn(u32) -> u64,
    ) -> Result<Vec<CurvedEdge>, MeshFault> {
        let mut middles = self.middles(index)?;
        if middles.is_empty() {
            return Ok(Vec::new());
        }
        middles.sort_by_key(|middle| middle.ends);
        let places = self.places(&middles)?;
        let surface = self.surface_edges();
        let mut curved = Vec::new();
        for same in middles.chunk_by(|a, b| a.ends == b.ends) {
            let offsets = same.iter().map(|middle| self.offset(middle, &places));
            let offsets = offsets.collect::<Result<Vec<_>, _>>()?;
            let Some((first, others)) = offsets.split_first() else {
                continue;
            };
            let ends = same.first().map_or([0; 2], |middle| middle.ends);
            let length = self.length(ends);
            let differs = |other: &[f64; 3]| distance(first, other) > ROUNDING * length;
            if others.iter().any(differs) {
                return Err(MeshFault::EdgeDisagrees(tag(ends[0]), tag(ends[1])));
            }
            let size = distance(first, &[0.0; 3]);
            if size > FARTHEST * length {
                return Err(MeshFault::EdgeTooFar(tag(ends[0]), tag(ends[1])));
            }
            if size > ROUNDING * length && surface.binary_search(&ends).is_ok() {
                let offset = *first;
                curved.push(CurvedEdge { ends, offset });
            }
        }
        Ok(curved)
    }

    /// The middles of the edges of all cells and facets of second order.
    fn middles(
        &self,
        index: impl Fn(u64) -> Result<u32, MeshFault>,
    ) -> Result<Vec<Middle>, MeshFault> {
        let mut middles = Vec::new();
        let bounding = self.dimension - 1..=self.dimension;
        let counted = self.blocks.iter();
        for block in counted.filter(|block| bounding.contains(&block.kind.dimension)) {
            let edges = block.kind.edges();
            for element in block.nodes.chunks_exact(block.kind.nodes) {
                let (vertices, further) = element.split_at(block.kind.vertices());
                for (&(a, b), &node) in edges.iter().zip(further) {
                    let (Some(&a), Some(&b)) = (vertices.get(a), vertices.get(b)) else {
                        continue;
                    };
                    let (a, b) = (index(a)?, index(b)?);
                    let ends = [a.min(b), a.max(b)];
                    middles.push(Middle { ends, node });
                }
            }
        }
        Ok(middles)
    }

    /// Where the nodes of the middles are.
    fn places(&self, middles: &[Middle]) -> Result<HashMap<u64, [f64; 3]>, MeshFault> {
        let mut wanted: Vec<u64> = middles.iter().map(|middle| middle.node).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let flat = match self.dimension {
            2 => PLANE_TOLERANCE * extent(self.coordinates.iter()),
            _ => f64::INFINITY,
        };
        let mut places = HashMap::with_capacity(wanted.len());
        let all = self.nodes.iter();
        for &(node, mut point) in all.filter(|(node, _)| wanted.binary_search(node).is_ok()) {
            let [x, y, z] = point;
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return Err(MeshFault::NotFinite(node));
            }
            if z.abs() > flat {
                let z = z.to_string();
                return Err(MeshFault::NotPlanar { node, z });
            }
            if self.dimension == 2 {
                point = [x, y, 0.0];
            }
            if places.insert(node, point).is_some() {
                return Err(MeshFault::DuplicateNode(node));
            }
        }
        Ok(places)
    }

    /// Offset of a middle from the mean of its ends.
    fn offset(
        &self,
        middle: &Middle,
        places: &HashMap<u64, [f64; 3]>,
    ) -> Result<[f64; 3], MeshFault> {
        let place = places.get(&middle.node);
        let [x, y, z] = *place.ok_or(MeshFault::UnknownNode(middle.node))?;
        let [[ax, ay, az], [bx, by, bz]] = middle.ends.map(|end| self.point(end));
        Ok([
            x - 0.5 * (ax + bx),
            y - 0.5 * (ay + by),
            z - 0.5 * (az + bz),
        ])
    }

    fn point(&self, vertex: u32) -> [f64; 3] {
        let found = self.coordinates.get(vertex as usize);
        found.copied().unwrap_or_default()
    }

    fn length(&self, [a, b]: [u32; 2]) -> f64 {
        distance(&self.point(a), &self.point(b))
    }

    /// Edges of facets that one cell alone has, ascending.
    fn surface_edges(&self) -> Vec<[u32; 2]> {
        let mut facets = Vec::with_capacity(self.cells.len());
        for cell in self.cells.chunks_exact(self.dimension + 1) {
            for left_out in cell {
                let mut facet: Vec<u32> = cell.iter().copied().filter(|v| v != left_out).collect();
                facet.sort_unstable();
                // A segment repeats its second vertex.
                if let (Some(&a), Some(&b), Some(&c)) = (facet.first(), facet.get(1), facet.last())
                {
                    facets.push([a, b, c]);
                }
            }
        }
        facets.sort_unstable();
        let alone = facets
            .chunk_by(|a, b| a == b)
            .filter(|same| same.len() == 1);
        let edges = alone
            .flatten()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
        let mut edges: Vec<[u32; 2]> = edges.filter(|[a, b]| a != b).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
