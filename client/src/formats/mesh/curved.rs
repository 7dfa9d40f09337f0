//! Where the middles of edges are, from elements of second order:
//!
//! ```text
//! offset of an edge = middle - (a + b) / 2
//! ```
//!
//! Cells and facets that share an edge must agree on its middle. Only edges of the
//! surface keep an offset, and only one that is more than rounding: inside the body
//! edges are lines. Where a face of four corners is split, its diagonal goes through the centre
//! of the face: its node, else the serendipity value (half the sum of the middles less a quarter of
//! the sum of the corners). Cost: one sort of all edges, nothing in a mesh of first order.

use std::collections::HashMap;

use super::CurvedEdge;
use super::fault::MeshFault;
use super::plane::{PLANE_TOLERANCE, extent};
use super::raw::Block;
use super::split::{picked, triangles};

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
        let mut middles = self.middles(&index)?;
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
        let is_known = |ends: [u32; 2]| {
            let known = middles.binary_search_by_key(&ends, |middle| middle.ends);
            known.is_ok() || surface.binary_search(&ends).is_err()
        };
        for diagonal in self.diagonals(index, &places)? {
            let (size, length) = (
                distance(&diagonal.offset, &[0.0; 3]),
                self.length(diagonal.ends),
            );
            if is_known(diagonal.ends) || size <= ROUNDING * length {
                continue;
            }
            if size > FARTHEST * length {
                let [a, b] = diagonal.ends.map(tag);
                return Err(MeshFault::EdgeTooFar(a, b));
            }
            curved.push(diagonal);
        }
        curved.sort_by_key(|edge| edge.ends);
        curved.dedup_by_key(|edge| edge.ends);
        Ok(curved)
    }

    /// The diagonals of the faces of four corners that have middles.
    fn diagonals(
        &self,
        index: impl Fn(u64) -> Result<u32, MeshFault>,
        places: &HashMap<u64, [f64; 3]>,
    ) -> Result<Vec<CurvedEdge>, MeshFault> {
        let mut diagonals = Vec::new();
        // Those of quadrangles of the plane are inside.
        let blocks = self.blocks.iter().filter(|_| self.dimension == 3);
        for block in blocks.filter(|block| block.kind.composite().is_some()) {
            for element in block.nodes.chunks_exact(block.kind.nodes) {
                for face in Face::of(block, element) {
                    let [a, b] = face.diagonal;
                    let (a, b) = (index(a)?, index(b)?);
                    let ends = [a.min(b), a.max(b)];
                    let corner = |tag: u64| index(tag).map(|vertex| self.point(vertex));
                    let centre = face.centre(corner, |node| places.get(&node).copied())?;
                    let [a, b] = ends.map(|end| self.point(end));
                    let mean = combined([(0.5, a), (0.5, b)]);
                    let offset = combined([(1.0, centre), (-1.0, mean)]);
                    diagonals.push(CurvedEdge { ends, offset });
                }
            }
        }
        Ok(diagonals)
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
                    // Cells that are collapsed have edges of one node.
                    if a != b {
                        middles.push(Middle { ends, node });
                    }
                }
            }
        }
        Ok(middles)
    }

    /// Where the nodes of the middles are.
    fn places(&self, middles: &[Middle]) -> Result<HashMap<u64, [f64; 3]>, MeshFault> {
        let mut wanted: Vec<u64> = middles.iter().map(|middle| middle.node).collect();
        for block in self.blocks {
            let centres = (0..).map_while(|face| block.kind.faces().get(face).map(|_| face));
            let centres: Vec<usize> = centres.filter_map(|face| block.kind.centre(face)).collect();
            for element in block.nodes.chunks_exact(block.kind.nodes) {
                wanted.extend(centres.iter().filter_map(|at| element.get(*at)));
            }
        }
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

/// A face of four corners with its middles.
struct Face {
    diagonal: [u64; 2],
    corners: [u64; 4],
    middles: [u64; 4],
    centre: Option<u64>,
}

impl Face {
    /// Those of an element that are split; a quadrangle is its own.
    fn of<'a>(block: &'a Block, element: &'a [u64]) -> impl Iterator<Item = Self> + 'a {
        let kind = block.kind;
        const WHOLE: &[&[usize]] = &[&[0, 1, 2, 3]];
        let faces = if kind.dimension == 2 {
            WHOLE
        } else {
            kind.faces()
        };
        faces.iter().enumerate().filter_map(move |(number, local)| {
            let &[a, b, c, d] = *local else { return None };
            let corners = picked(element, local);
            let mut halves = triangles(corners);
            // Both halves begin at an end of the diagonal.
            let ([first, ..], [_, _, _]) = (halves.next()?, halves.next()?);
            let at = corners.iter().position(|corner| *corner == first)?;
            let diagonal = [first, *corners.get((at + 2) % 4)?];
            let middle = |ends: (usize, usize)| {
                let is_edge = |edge: &(usize, usize)| *edge == ends || *edge == (ends.1, ends.0);
                let edge = kind.edges().iter().position(is_edge)?;
                element.get(kind.vertices() + edge).copied()
            };
            Some(Self {
                diagonal,
                corners,
                middles: [
                    middle((a, b))?,
                    middle((b, c))?,
                    middle((c, d))?,
                    middle((d, a))?,
                ],
                centre: kind.centre(number).and_then(|at| element.get(at).copied()),
            })
        })
    }

    fn centre(
        &self,
        corner: impl Fn(u64) -> Result<[f64; 3], MeshFault>,
        place: impl Fn(u64) -> Option<[f64; 3]>,
    ) -> Result<[f64; 3], MeshFault> {
        let found = |node: u64| place(node).ok_or(MeshFault::UnknownNode(node));
        if let Some(node) = self.centre {
            return found(node);
        }
        let mut centre = [0.0; 3];
        for (&at, &middle) in self.corners.iter().zip(&self.middles) {
            centre = combined([(1.0, centre), (-0.25, corner(at)?)]);
            centre = combined([(1.0, centre), (0.5, found(middle)?)]);
        }
        Ok(centre)
    }
}

/// The sum of two points with weights.
fn combined([(s, [a, b, c]), (t, [x, y, z])]: [(f64, [f64; 3]); 2]) -> [f64; 3] {
    [s * a + t * x, s * b + t * y, s * c + t * z]
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
