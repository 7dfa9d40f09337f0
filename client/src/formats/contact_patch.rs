//! The outline of a contact patch on the deformed surface: the line half way between nodes
//! that press and their neighbours that do not, and the rim of the surface where the patch
//! reaches it.
//!
//! ```text
//! corners that press      the outline in a triangle
//! one, a                  (a + b)/2 to (a + c)/2
//! two, a and b            (a + c)/2 to (b + c)/2
//! three                   none; its sides on the rim
//! ```
//!
//! With quadratic pressures the triangles are the quarters of the faces. Lines are closed: that
//! of a hole goes around the hole, that of a half along the cut. In the plane a patch has ends in
//! the place of a line. A discrete pressure tells no more than between which nodes it ends: the
//! outline is exact to half their distance. Cost: one pass over the faces, a sort of those that
//! press.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::mesh::MeshFile;
use super::vtk_xml::{Notes, Writer};
use super::vtp::Vector;
use super::vtu::Grid;

/// Share of the largest pressure that is rounding in the coefficient of an edge.
const ROUNDING: f64 = 1e-9;

/// The faces of a body that may touch an obstacle, as triangles or lines between nodes.
#[derive(Clone, Debug)]
pub struct PatchSurface {
    /// Corners of each face: three vertices, or two.
    faces: Vec<Vec<u32>>,
    vertex_count: usize,
}

/// Lines on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchOutline {
    /// [points, 3], length.
    pub points: Vec<Vector>,
    /// Indices of points; the first one ends a closed line, too. In the plane one point each.
    pub lines: Vec<Vec<i64>>,
}

/// Nodes of a body that has moved, and which of them press.
struct Pressed<'a> {
    grid: &'a Grid,
    displacement: &'a [[f64; 3]],
    pressure: &'a [f64],
    /// Above this a coefficient presses.
    least: f64,
}

/// A node, and whether it presses.
type Corner = (usize, bool);

/// A place on the surface: half way between two nodes, or a node, which is named twice.
type Place = (usize, usize);

impl PatchSurface {
    /// The facets of some groups.
    pub fn new(mesh: &MeshFile, groups: &[String]) -> Self {
        let corners = mesh.vertices_per_cell.saturating_sub(1);
        let named = mesh
            .groups
            .iter()
            .filter(|group| group.dimension + 1 == corners && groups.contains(&group.name));
        let mut facets: Vec<u32> = named.flat_map(|group| &group.members).copied().collect();
        facets.sort_unstable();
        facets.dedup();
        let face = |facet: u32| {
            let first = facet as usize * corners;
            mesh.facets.get(first..first + corners).map(<[u32]>::to_vec)
        };
        Self {
            faces: facets.into_iter().filter_map(face).collect(),
            vertex_count: mesh.coordinates.len(),
        }
    }

    /// The outline of where it is pressed: `pressure` at nodes of the grid or at its vertices,
    /// `displacement` at nodes [nodes, 3].
    pub fn outline(&self, grid: &Grid, displacement: &[f64], pressure: &[f64]) -> PatchOutline {
        let largest = pressure.iter().copied().fold(0.0, f64::max);
        let pressed = Pressed {
            grid,
            displacement: displacement.as_chunks::<3>().0,
            pressure,
            least: ROUNDING * largest,
        };
        let is_linear = pressure.len() == self.vertex_count;
        let pieces = self.faces.iter().flat_map(|face| {
            if is_linear {
                vec![face.iter().map(|&v| Node::Vertex(v)).collect()]
            } else {
                quarters(face)
            }
        });
        let corners = |piece: Vec<Node>| -> Option<Vec<Corner>> {
            let corners = piece.into_iter().map(|node| pressed.corner(node));
            let corners: Vec<Corner> = corners.collect::<Option<_>>()?;
            let presses = corners.iter().any(|(_, presses)| *presses);
            presses.then_some(corners)
        };
        let pieces: Vec<Vec<Corner>> = pieces.filter_map(corners).collect();
        let mut outline = PatchOutline::default();
        for line in linked(borders(&pieces)) {
            outline.add(&line, |place| pressed.position(place));
        }
        outline
    }
}

/// A node by its number, or by the vertices that it lies between.
#[derive(Clone, Copy)]
enum Node {
    Vertex(u32),
    Edge(u32, u32),
}

/// A face cut at the middles of its edges.
fn quarters(face: &[u32]) -> Vec<Vec<Node>> {
    use Node::{Edge, Vertex};
    match *face {
        [a, b] => vec![vec![Vertex(a), Edge(a, b)], vec![Edge(a, b), Vertex(b)]],
        [a, b, c] => vec![
            vec![Vertex(a), Edge(a, b), Edge(c, a)],
            vec![Edge(a, b), Vertex(b), Edge(b, c)],
            vec![Edge(c, a), Edge(b, c), Vertex(c)],
            vec![Edge(a, b), Edge(b, c), Edge(c, a)],
        ],
        _ => Vec::new(),
    }
}

impl Pressed<'_> {
    /// Number of a node, and whether its coefficient presses: that of an edge is twice the
    /// pressure in its middle less the mean of its ends.
    fn corner(&self, node: Node) -> Option<Corner> {
        let at = |index: usize| self.pressure.get(index).copied().unwrap_or_default();
        let (index, coefficient) = match node {
            Node::Vertex(vertex) => (vertex as usize, at(vertex as usize)),
            Node::Edge(a, b) => {
                let index = self.grid.edge_node(a, b)?;
                let ends = at(a as usize) + at(b as usize);
                (index, 2.0 * at(index) - 0.5 * ends)
            }
        };
        Some((index, coefficient > self.least))
    }

    /// Where a place has moved to.
    fn position(&self, (a, b): Place) -> Vector {
        let (points, _) = self.grid.points().as_chunks::<3>();
        let node = |index: usize| -> Vector {
            let row = |rows: &[[f64; 3]]| rows.get(index).copied().unwrap_or_default();
            let ([x, y, z], [u, v, w]) = (row(points), row(self.displacement));
            [x + u, y + v, z + w]
        };
        let ([x, y, z], [u, v, w]) = (node(a), node(b));
        [0.5 * (x + u), 0.5 * (y + v), 0.5 * (z + w)]
    }
}

impl PatchOutline {
    /// Adds a line whose end is its start where it is closed.
    fn add(&mut self, line: &[Place], position: impl Fn(Place) -> Vector) {
        let first = self.points.len() as i64;
        let is_closed = line.len() > 1 && line.first() == line.last();
        let own = line.len() - usize::from(is_closed);
        let places = line.iter().take(own);
        self.points.extend(places.map(|place| position(*place)));
        let mut indices: Vec<i64> = (first..self.points.len() as i64).collect();
        indices.extend(is_closed.then_some(first));
        self.lines.push(indices);
    }

    /// The bytes of a VTP file with the lines, or the ends in the plane.
    pub fn write(&self, notes: &Notes) -> Vec<u8> {
        let (ends, lines): (Vec<_>, Vec<_>) = self.lines.iter().partition(|line| line.len() == 1);
        let points: Vec<f64> = self.points.iter().flatten().copied().collect();
        let mut file = Writer::new("PolyData");
        file.line("<PolyData>");
        file.notes(notes);
        file.line(&format!(
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
            self.points.len(),
            ends.len(),
            lines.len()
        ));
        file.line("<Points>");
        file.array("Points", 3, &points);
        file.line("</Points>");
        for (name, cells) in [("Verts", ends), ("Lines", lines)] {
            let flat: Vec<i64> = cells.iter().copied().flatten().copied().collect();
            let offsets = cells.iter().scan(0, |end, cell| {
                *end += cell.len() as i64;
                Some(*end)
            });
            file.line(&format!("<{name}>"));
            file.array("connectivity", 1, &flat);
            file.array("offsets", 1, &offsets.collect::<Vec<i64>>());
            file.line(&format!("</{name}>"));
        }
        file.line("</Piece>");
        file.finish("PolyData")
    }
}

fn place(a: usize, b: usize) -> Place {
    (a.min(b), a.max(b))
}

/// What bounds the patch: pairs of places, or single ones in the plane, which are pairs of the
/// same.
fn borders(pieces: &[Vec<Corner>]) -> Vec<[Place; 2]> {
    let mut borders: Vec<[Place; 2]> = pieces.iter().filter_map(|piece| across(piece)).collect();
    let mut sides: BTreeMap<Place, ([Corner; 2], usize)> = BTreeMap::new();
    for side in pieces.iter().flat_map(|piece| rim_of(piece)) {
        let key = place(side[0].0, side[1].0);
        sides.entry(key).or_insert((side, 0)).1 += 1;
    }
    let rim = sides.into_values().filter(|(_, times)| *times == 1);
    borders.extend(rim.filter_map(|(side, _)| along(side)));
    // Lines begin at the same place whatever the order of the faces and of their corners.
    borders.iter_mut().for_each(|pair| pair.sort_unstable());
    borders.sort_unstable();
    borders
}

/// The outline within a triangle or a line.
fn across(piece: &[Corner]) -> Option<[Place; 2]> {
    let mut ends = sides_of(piece)
        .into_iter()
        .filter(|[(_, a), (_, b)]| a != b)
        .map(|[(a, _), (b, _)]| place(a, b));
    let first = ends.next()?;
    Some([first, ends.next().unwrap_or(first)])
}

/// Pairs of corners that are next to each other.
fn sides_of(piece: &[Corner]) -> Vec<[Corner; 2]> {
    match *piece {
        [a, b] => vec![[a, b]],
        [a, b, c] => vec![[a, b], [b, c], [c, a]],
        _ => Vec::new(),
    }
}

/// What the rim has once: sides, or of a line its ends.
fn rim_of(piece: &[Corner]) -> Vec<[Corner; 2]> {
    match *piece {
        [a, b] => vec![[a, a], [b, b]],
        _ => sides_of(piece),
    }
}

/// What of a side on the rim the patch has.
fn along([(a, a_presses), (b, b_presses)]: [Corner; 2]) -> Option<[Place; 2]> {
    match (a_presses, b_presses) {
        (true, true) => Some([(a, a), (b, b)]),
        (true, false) => Some([(a, a), place(a, b)]),
        (false, true) => Some([place(a, b), (b, b)]),
        (false, false) => None,
    }
}

/// Pairs joined to lines, closed ones with their start at their end; a pair of the same place is
/// that place alone.
fn linked(pairs: Vec<[Place; 2]>) -> Vec<Vec<Place>> {
    let mut at: BTreeMap<Place, Vec<usize>> = BTreeMap::new();
    for (index, pair) in pairs.iter().enumerate() {
        pair.iter()
            .for_each(|end| at.entry(*end).or_default().push(index));
    }
    let mut is_free = vec![true; pairs.len()];
    let mut lines = Vec::new();
    for (index, &[first, _]) in pairs.iter().enumerate() {
        let (mut line, mut here, mut next) = (vec![first], first, Some(index));
        while let Some(pair) = next.and_then(|one| pairs.get(one)) {
            let taken = next.and_then(|one| is_free.get_mut(one));
            if !taken.is_some_and(std::mem::take) {
                break;
            }
            here = if pair[0] == here { pair[1] } else { pair[0] };
            line.push(here);
            let candidates = at.get(&here).into_iter().flatten();
            next = candidates
                .copied()
                .find(|&one| is_free.get(one) == Some(&true));
        }
        match line[..] {
            [_] => {}
            [a, b] if a == b => lines.push(vec![a]),
            _ => lines.push(line),
        }
    }
    lines
}
