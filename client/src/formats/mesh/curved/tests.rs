//! Meshes of second order: an octahedron of four tetrahedra about its axis, in both
//! versions of the format.

use std::fmt::Write as _;

use proptest::prelude::*;

use super::super::{CurvedEdge, MeshFault, MeshFile};
use crate::formats::msh::{Fault, MshError, read};

/// Corners of the octahedron; the axis from 0 to 1 is inside.
const POINTS: [[f64; 3]; 6] = [
    [0.0, 0.0, -1.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
];
const CELLS: [[usize; 4]; 4] = [[0, 2, 3, 1], [0, 3, 4, 1], [0, 4, 5, 1], [0, 5, 2, 1]];
const SIDE: [usize; 3] = [0, 3, 2];
/// Edges of a tetrahedron in the order of its further nodes.
const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)];

/// A file on its way: nodes and elements of second order.
struct Draft {
    points: Vec<[f64; 3]>,
    cells: Vec<Vec<usize>>,
    sides: Vec<Vec<usize>>,
}

impl Draft {
    /// The octahedron with the middles at their means plus `offset` of the ends.
    fn new(offset: impl Fn(usize, usize) -> [f64; 3]) -> Self {
        let mut draft = Self {
            points: POINTS.to_vec(),
            cells: Vec::new(),
            sides: Vec::new(),
        };
        let mut middles = std::collections::BTreeMap::new();
        for cell in CELLS {
            let mut nodes = cell.to_vec();
            for (a, b) in EDGES.map(|(a, b)| (cell[a].min(cell[b]), cell[a].max(cell[b]))) {
                let node = *middles.entry((a, b)).or_insert_with(|| {
                    let offset = offset(a, b);
                    let mean = |i: usize| 0.5 * (POINTS[a][i] + POINTS[b][i]) + offset[i];
                    draft.points.push([mean(0), mean(1), mean(2)]);
                    draft.points.len() - 1
                });
                nodes.push(node);
            }
            draft.cells.push(nodes);
        }
        let [a, b, c] = SIDE;
        let on = |a: usize, b: usize| middles[&(a.min(b), a.max(b))];
        draft.sides = vec![vec![a, b, c, on(a, b), on(b, c), on(a, c)]];
        draft
    }

    fn text_22(&self) -> String {
        let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n".to_owned();
        writeln!(text, "{}", self.points.len()).unwrap();
        for (index, [x, y, z]) in self.points.iter().enumerate() {
            writeln!(text, "{} {x:e} {y:e} {z:e}", index + 1).unwrap();
        }
        let count = self.cells.len() + self.sides.len();
        writeln!(text, "$EndNodes\n$Elements\n{count}").unwrap();
        for (element, group) in self.elements() {
            let kind = kind(element.len());
            write!(text, "1 {kind} 2 {group} {group}").unwrap();
            writeln!(text, "{}", tags(element)).unwrap();
        }
        text + "$EndElements\n"
    }

    fn text_41(&self) -> String {
        let mut text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n".to_owned();
        text += "$Entities\n0 0 1 1\n7 0 0 0 1 1 1 1 7 0\n1 0 0 0 1 1 1 1 1 0\n$EndEntities\n";
        let nodes = self.points.len();
        writeln!(text, "$Nodes\n1 {nodes} 1 {nodes}\n3 1 0 {nodes}").unwrap();
        (1..=nodes).for_each(|tag| writeln!(text, "{tag}").unwrap());
        for [x, y, z] in &self.points {
            writeln!(text, "{x:e} {y:e} {z:e}").unwrap();
        }
        let count = self.cells.len() + self.sides.len();
        writeln!(text, "$EndNodes\n$Elements\n{count} {count} 1 {count}").unwrap();
        for (element, group) in self.elements() {
            let dimension = if group == 7 { 2 } else { 3 };
            writeln!(text, "{dimension} {group} {} 1", kind(element.len())).unwrap();
            writeln!(text, "1{}", tags(element)).unwrap();
        }
        text + "$EndElements\n"
    }

    /// Elements with their physical groups.
    fn elements(&self) -> impl Iterator<Item = (&[usize], usize)> {
        let sides = self.sides.iter().map(|side| (&side[..], 7));
        sides.chain(self.cells.iter().map(|cell| (&cell[..], 1)))
    }

    /// The mesh, which both versions agree on.
    fn read(&self) -> Result<MeshFile, MshError> {
        let mesh = read(self.text_22().as_bytes());
        assert_eq!(read(self.text_41().as_bytes()), mesh);
        mesh
    }

    fn fault(&self) -> MeshFault {
        let Fault::Mesh(fault) = self.read().unwrap_err().fault else {
            panic!("a fault of the mesh is expected");
        };
        fault
    }
}

fn kind(nodes: usize) -> usize {
    match nodes {
        3 => 2,
        4 => 4,
        6 => 9,
        _ => 11,
    }
}

fn tags(element: &[usize]) -> String {
    element
        .iter()
        .map(|node| format!(" {}", node + 1))
        .collect()
}

/// Outwards, by how much depends on the ends.
fn bulge(a: usize, b: usize) -> [f64; 3] {
    let size = 0.01 * (1 + a + 3 * b) as f64;
    [0, 1, 2].map(|i| size * (POINTS[a][i] + POINTS[b][i]))
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15)
}

#[test]
fn edges_of_the_surface_keep_their_offsets() {
    let mesh = Draft::new(bulge).read().unwrap();
    assert_eq!((mesh.coordinates.len(), mesh.curved.len()), (6, 12));
    assert!(mesh.curved.is_sorted_by_key(|edge| edge.ends));
    for CurvedEdge { ends, offset } in mesh.curved {
        let [a, b] = ends.map(|end| end as usize);
        assert!(a < b && close(offset, bulge(a, b)), "{a} {b} {offset:?}");
    }
    assert!(mesh.warnings.is_empty());
}

#[test]
fn edges_inside_the_body_are_lines() {
    let mesh = Draft::new(|a, b| match (a, b) {
        (0, 1) => [0.1, 0.0, 0.0],
        _ => [0.0; 3],
    });
    let mesh = mesh.read().unwrap();
    assert!(mesh.curved.is_empty());
    assert!(mesh.warnings[0].contains("every edge of the surface is a straight line"));
}

#[test]
fn rounding_is_no_offset() {
    let mesh = Draft::new(|_, _| [1e-10; 3]).read().unwrap();
    assert!(mesh.curved.is_empty());
}

#[test]
fn a_middle_at_a_quarter_of_its_edge_is_kept() {
    let along = |a: usize, b: usize| [0, 1, 2].map(|i| 0.25 * (POINTS[b][i] - POINTS[a][i]));
    let mesh = Draft::new(along).read().unwrap();
    assert_eq!(mesh.curved.len(), 12);
}

#[test]
fn mirrored_cells_keep_the_middles_of_their_edges() {
    let mut draft = Draft::new(bulge);
    for cell in &mut draft.cells {
        // Vertices 2 and 3 change places, and with them their edges.
        for (a, b) in [(2, 3), (6, 7), (5, 9)] {
            cell.swap(a, b);
        }
    }
    assert_eq!(
        draft.read().unwrap().curved,
        Draft::new(bulge).read().unwrap().curved
    );
}

#[test]
fn facets_of_second_order_curve_cells_of_first() {
    let mut draft = Draft::new(bulge);
    draft.cells.iter_mut().for_each(|cell| cell.truncate(4));
    let mesh = draft.read().unwrap();
    let ends: Vec<[u32; 2]> = mesh.curved.iter().map(|edge| edge.ends).collect();
    assert_eq!(ends, [[0, 2], [0, 3], [2, 3]]);
}

#[test]
fn elements_that_put_one_middle_apart_are_refused() {
    let mut draft = Draft::new(bulge);
    let shared = draft.points[draft.cells[0][5]];
    draft.points.push(shared.map(|x| x + 1e-12));
    let own = draft.points.len() - 1;
    draft.sides[0][4] = own;
    draft.read().unwrap();
    draft.points[own] = shared.map(|x| x + 1e-3);
    assert_eq!(draft.fault(), MeshFault::EdgeDisagrees(3, 4));
}

#[test]
fn the_order_of_another_program_is_refused() {
    let mut draft = Draft::new(bulge);
    for cell in &mut draft.cells {
        cell.swap(8, 9);
    }
    let fault = draft.fault();
    assert!(
        matches!(
            fault,
            MeshFault::EdgeDisagrees(..) | MeshFault::EdgeTooFar(..)
        ),
        "{fault:?}"
    );
    assert_eq!(
        Draft::new(|_, _| [0.9, 0.0, 0.0]).fault(),
        MeshFault::EdgeTooFar(1, 3)
    );
}

#[test]
fn middles_that_are_no_points_are_refused() {
    let mut draft = Draft::new(bulge);
    draft.points[7][1] = f64::INFINITY;
    assert!(draft.read().is_err());
    let mut draft = Draft::new(bulge);
    draft.cells[2][6] = 400;
    assert_eq!(draft.fault(), MeshFault::UnknownNode(401));
}

#[test]
fn a_plane_mesh_keeps_the_arcs_of_its_lines() {
    let text = |middle: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 {middle}\n3 1 0 0\n\
             4 0 1 0\n5 0.75 0.75 0\n6 0 0.5 0\n$EndNodes\n$Elements\n2\n1 9 2 4 4 1 3 4 2 5 6\n\
             2 8 2 5 5 1 3 2\n$EndElements\n"
        )
    };
    let mesh = read(text("0.5 -0.125 1e-14").as_bytes()).unwrap();
    let edge = |ends, offset| CurvedEdge { ends, offset };
    let expected = [
        edge([0, 1], [0.0, -0.125, 0.0]),
        edge([1, 2], [0.25, 0.25, 0.0]),
    ];
    assert_eq!(mesh.curved, expected);
    let error = read(text("0.5 0 0.1").as_bytes()).unwrap_err();
    assert!(
        matches!(
            error.fault,
            Fault::Mesh(MeshFault::NotPlanar { node: 2, .. })
        ),
        "{error}"
    );
}

#[test]
fn the_middles_of_a_ball_of_gmsh_lie_on_its_sphere() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/meshes/globe_h80.msh");
    let mesh = read(&std::fs::read(path).unwrap()).unwrap();
    // A closed surface of triangles has three edges for two facets.
    assert_eq!(2 * mesh.curved.len(), 3 * mesh.facet_count());
    let size = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    for CurvedEdge { ends, offset } in mesh.curved {
        let [a, b] = ends.map(|end| mesh.coordinates[end as usize]);
        let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]) + offset[i]);
        assert!((size(middle) - 1.0).abs() < 1e-12, "{ends:?}");
    }
}

proptest! {
    #[test]
    fn every_offset_comes_back(noise in prop::collection::vec(-0.2..0.2_f64, 36 * 3)) {
        let offset = |a: usize, b: usize| {
            let first = 3 * (6 * a + b);
            [noise[first], noise[first + 1], noise[first + 2]]
        };
        let mesh = Draft::new(offset).read().unwrap();
        prop_assert!(mesh.curved.len() == 12);
        for edge in mesh.curved {
            let [a, b] = edge.ends.map(|end| end as usize);
            prop_assert!(close(edge.offset, offset(a, b)));
        }
    }
}
