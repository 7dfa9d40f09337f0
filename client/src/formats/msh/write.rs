//! Writes a mesh as Gmsh MSH 2.2 in text: what [`read`](super::read) makes of it is the mesh again.
//!
//! Groups are physical groups, facet groups first; an element of several groups is written once
//! for each, as that version asks. Cells and facets of a mesh with curved edges are of second
//! order, middles of other edges halfway. Numbers have as many digits as they need to be read with
//! the same bits. Cost: one pass; the text takes some 40 bytes a cell, of second order 150.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use thiserror::Error;

use super::{MeshFile, MeshGroup};

/// Local ends of the edges of elements of second order, in the order of Gmsh.
const OF_LINE: &[(usize, usize)] = &[(0, 1)];
const OF_TRIANGLE: &[(usize, usize)] = &[(0, 1), (1, 2), (0, 2)];
const OF_TETRAHEDRON: &[(usize, usize)] = &[(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)];

/// Why a mesh is not written.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum WriteError {
    /// A name that the file would end.
    #[error(
        "the name of group {0:?} has a quotation mark or a line break, which MSH cannot hold: rename it"
    )]
    Name(String),
}

/// Number of the node in the middle of each edge, and where it is.
type Middles = BTreeMap<[u32; 2], (usize, [f64; 3])>;

/// Elements of one dimension.
struct Elements<'a> {
    /// Vertices of one element.
    width: usize,
    /// Vertices of all, flat.
    vertices: &'a [u32],
    /// Number of the group of the first of `groups`.
    first: usize,
    groups: Vec<&'a MeshGroup>,
}

impl Elements<'_> {
    /// Numbers of the groups of each element; zero where it has none.
    fn tags(&self) -> Vec<Vec<usize>> {
        let count = self.vertices.len() / self.width.max(1);
        let mut tags = vec![Vec::new(); count];
        for (tag, group) in (self.first..).zip(&self.groups) {
            for &member in &group.members {
                if let Some(own) = tags.get_mut(member as usize) {
                    own.push(tag);
                }
            }
        }
        let unnamed = tags.iter_mut().filter(|own| own.is_empty());
        unnamed.for_each(|own| own.push(0));
        tags
    }

    fn edges(&self) -> &'static [(usize, usize)] {
        match self.width {
            2 => OF_LINE,
            3 => OF_TRIANGLE,
            _ => OF_TETRAHEDRON,
        }
    }

    /// The number of Gmsh for the type, with or without middles.
    fn kind(&self, middles: &Middles) -> u32 {
        match (self.width, middles.is_empty()) {
            (2, true) => 1,
            (2, false) => 8,
            (3, true) => 2,
            (3, false) => 9,
            (_, true) => 4,
            (_, false) => 11,
        }
    }

    /// Ends of the edges of an element, in their order.
    fn ends(&self, element: &[u32]) -> Vec<[u32; 2]> {
        let pairs = self.edges().iter().filter_map(|&(a, b)| {
            let (a, b) = (*element.get(a)?, *element.get(b)?);
            Some([a.min(b), a.max(b)])
        });
        pairs.collect()
    }

    /// Appends all elements, numbered from `next` on.
    fn write(&self, middles: &Middles, next: &mut usize, text: &mut String) {
        let kind = self.kind(middles);
        let rows = self.vertices.chunks_exact(self.width.max(1));
        for (element, tags) in rows.zip(self.tags()) {
            let vertices = element.iter().map(|&vertex| vertex as usize + 1);
            let inner = self.ends(element).into_iter();
            let inner = inner.filter_map(|ends| middles.get(&ends).map(|(node, _)| *node));
            let nodes: Vec<usize> = vertices.chain(inner).collect();
            for tag in tags {
                add(text, format_args!("{next} {kind} 2 {tag} {tag}"));
                nodes
                    .iter()
                    .for_each(|node| add(text, format_args!(" {node}")));
                text.push('\n');
                *next += 1;
            }
        }
    }
}

/// Appends to a text.
fn add(text: &mut String, what: std::fmt::Arguments<'_>) {
    // A text takes everything.
    let _whole = text.write_fmt(what);
}

/// The mesh as a file.
///
/// # Errors
/// [`WriteError`] for names that the format cannot hold.
pub fn write(mesh: &MeshFile) -> Result<String, WriteError> {
    let is_bad = |group: &&MeshGroup| group.name.contains(['"', '\n', '\r']);
    if let Some(group) = mesh.groups.iter().find(is_bad) {
        return Err(WriteError::Name(group.name.clone()));
    }
    let cells = mesh.vertices_per_cell;
    let of = |dimension: usize| -> Vec<&MeshGroup> {
        let groups = mesh.groups.iter();
        groups
            .filter(|group| group.dimension == dimension)
            .collect()
    };
    let facets = Elements {
        width: cells - 1,
        vertices: &mesh.facets,
        first: 1,
        groups: of(cells - 2),
    };
    let cells = Elements {
        width: cells,
        vertices: &mesh.cells,
        first: 1 + facets.groups.len(),
        groups: of(cells - 1),
    };
    let middles = middles(mesh, &cells);
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n".to_owned();
    names([&facets, &cells], &mut text);
    nodes(mesh, &middles, &mut text);
    elements([&facets, &cells], &middles, &mut text);
    Ok(text)
}

/// The section of names.
fn names(parts: [&Elements<'_>; 2], text: &mut String) {
    let count: usize = parts.iter().map(|part| part.groups.len()).sum();
    add(text, format_args!("$PhysicalNames\n{count}\n"));
    for part in parts {
        for (tag, group) in (part.first..).zip(&part.groups) {
            let (dimension, name) = (group.dimension, &group.name);
            add(text, format_args!("{dimension} {tag} \"{name}\"\n"));
        }
    }
    text.push_str("$EndPhysicalNames\n");
}

/// The section of nodes: vertices, then middles.
fn nodes(mesh: &MeshFile, middles: &Middles, text: &mut String) {
    let count = mesh.coordinates.len() + middles.len();
    add(text, format_args!("$Nodes\n{count}\n"));
    let vertices = (1..).zip(mesh.coordinates.iter().copied());
    for (number, [x, y, z]) in vertices.chain(middles.values().copied()) {
        add(text, format_args!("{number} {x:e} {y:e} {z:e}\n"));
    }
    text.push_str("$EndNodes\n");
}

/// The section of elements.
fn elements(parts: [&Elements<'_>; 2], middles: &Middles, text: &mut String) {
    let copies = |part: &&Elements<'_>| part.tags().iter().map(Vec::len).sum::<usize>();
    let count: usize = parts.iter().map(copies).sum();
    add(text, format_args!("$Elements\n{count}\n"));
    let mut next = 1;
    for part in parts {
        part.write(middles, &mut next, text);
    }
    text.push_str("$EndElements\n");
}

/// Middles of all edges where any edge is curved; else none.
fn middles(mesh: &MeshFile, cells: &Elements<'_>) -> Middles {
    let mut middles = Middles::new();
    if mesh.curved.is_empty() {
        return middles;
    }
    let place = |vertex: u32| {
        let found = mesh.coordinates.get(vertex as usize);
        found.copied().unwrap_or_default()
    };
    for cell in mesh.cells.chunks_exact(cells.width) {
        for ends in cells.ends(cell) {
            middles.entry(ends).or_default();
        }
    }
    for (number, (&[a, b], middle)) in (mesh.coordinates.len() + 1..).zip(&mut middles) {
        let ([ax, ay, az], [bx, by, bz]) = (place(a), place(b));
        *middle = (number, [0.5 * (ax + bx), 0.5 * (ay + by), 0.5 * (az + bz)]);
    }
    for edge in &mesh.curved {
        if let Some((_, middle)) = middles.get_mut(&edge.ends) {
            let moved = middle.iter_mut().zip(edge.offset);
            moved.for_each(|(x, offset)| *x += offset);
        }
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::msh::{CurvedEdge, read};

    fn square() -> MeshFile {
        let group = |name: &str, dimension: usize, members: &[u32]| MeshGroup {
            name: name.to_owned(),
            dimension,
            members: members.to_vec(),
        };
        MeshFile {
            vertices_per_cell: 3,
            coordinates: vec![
                [0.0; 3],
                [1.0 / 3.0, 0.0, 0.0],
                [1e-300, 0.7, 0.0],
                [1.0, 1.0, 0.0],
            ],
            cells: vec![0, 1, 2, 1, 3, 2],
            facets: vec![0, 1, 1, 3],
            groups: vec![
                group("base", 1, &[0]),
                group("both sides", 1, &[0, 1]),
                group("body", 2, &[0, 1]),
                group("upper", 2, &[1]),
            ],
            curved: Vec::new(),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn what_is_written_is_read_as_the_same_mesh() {
        let mesh = square();
        let text = write(&mesh).unwrap();
        assert_eq!(read(text.as_bytes()).unwrap(), mesh);
    }

    #[test]
    fn curved_edges_are_middles_of_second_order() {
        let mut mesh = square();
        mesh.curved = vec![CurvedEdge {
            ends: [0, 1],
            offset: [0.0, -0.0625, 0.0],
        }];
        let text = write(&mesh).unwrap();
        assert_eq!(read(text.as_bytes()).unwrap(), mesh);
    }

    #[test]
    fn tetrahedra_keep_their_curved_edges() {
        let offset = |ends| CurvedEdge {
            ends,
            offset: [0.0, 0.0625, 0.125],
        };
        let mesh = MeshFile {
            vertices_per_cell: 4,
            coordinates: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            cells: vec![0, 1, 2, 3],
            facets: vec![1, 2, 3],
            groups: vec![MeshGroup {
                name: "top".to_owned(),
                dimension: 2,
                members: vec![0],
            }],
            curved: vec![offset([1, 3]), offset([2, 3])],
            warnings: Vec::new(),
        };
        let text = write(&mesh).unwrap();
        assert_eq!(read(text.as_bytes()).unwrap(), mesh);
    }

    #[test]
    fn names_that_would_end_the_file_are_refused() {
        let mut mesh = square();
        if let Some(group) = mesh.groups.first_mut() {
            group.name = "a\"b".to_owned();
        }
        assert!(matches!(write(&mesh), Err(WriteError::Name(_))));
    }
}
