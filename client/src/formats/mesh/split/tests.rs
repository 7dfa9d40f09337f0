//! Grids of hexahedra, wedges and pyramids under any numbering of their nodes, and cells of
//! second order with the shapes that their middles give.

use std::collections::HashMap;
use std::fmt::Write as _;

use proptest::prelude::*;

use crate::formats::inp::{InpFault, read};
use crate::formats::mesh::{MeshFault, MeshFile};

/// Cells along each axis.
const SIDE: usize = 2;
const EDGE: usize = SIDE + 1;

/// Local corners of the halves and sixths of a hexahedron; 8 is its centre.
const WEDGES: [[usize; 6]; 2] = [[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]];
const PYRAMIDS: [[usize; 5]; 6] = [
    [0, 1, 2, 3, 8],
    [4, 7, 6, 5, 8],
    [0, 4, 5, 1, 8],
    [1, 5, 6, 2, 8],
    [2, 6, 7, 3, 8],
    [3, 7, 4, 0, 8],
];

/// What a column of the grid is made of.
#[derive(Clone, Copy, Debug)]
enum Column {
    Hexahedra,
    Wedges,
    Pyramids,
}

/// A file of the grid: elements by type and the nodes at their places.
fn deck(columns: &[Column], numbers: &[usize], place: impl Fn(usize) -> [f64; 3]) -> String {
    let mut text = "*NODE\n".to_owned();
    for (node, number) in numbers.iter().enumerate() {
        let [x, y, z] = place(node);
        let _infallible = writeln!(text, "{number}, {x:?}, {y:?}, {z:?}");
    }
    let mut element = 0;
    let mut add = |kind: &str, nodes: &[usize]| {
        element += 1;
        let nodes: Vec<String> = nodes.iter().map(|at| numbers[*at].to_string()).collect();
        let _infallible = writeln!(
            text,
            "*ELEMENT, TYPE={kind}\n{element}, {}",
            nodes.join(", ")
        );
    };
    for cell in 0..SIDE * SIDE * SIDE {
        let corners = corners(cell);
        let of = |local: &[usize]| -> Vec<usize> { local.iter().map(|at| corners[*at]).collect() };
        match columns[cell % (SIDE * SIDE)] {
            Column::Hexahedra => add("C3D8R", &corners[..8]),
            Column::Wedges => WEDGES.iter().for_each(|wedge| add("C3D6", &of(wedge))),
            Column::Pyramids => PYRAMIDS.iter().for_each(|one| add("C3D5", &of(one))),
        }
    }
    text
}

/// Nodes of a cell: its corners in the order of Abaqus, and its centre.
fn corners(cell: usize) -> Vec<usize> {
    let [i, j, k] = [cell % SIDE, cell / SIDE % SIDE, cell / SIDE / SIDE];
    let node = |[a, b, c]: [usize; 3]| i + a + EDGE * (j + b) + EDGE * EDGE * (k + c);
    let square = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let both = (0..2).flat_map(|c| square.map(|[a, b]| node([a, b, c])));
    both.chain([EDGE * EDGE * EDGE + cell]).collect()
}

/// Nodes of the grid, then the centres of its cells.
const NODES: usize = EDGE * EDGE * EDGE + SIDE * SIDE * SIDE;

/// A node of the grid of unit cells, moved by up to `by` of a cell where it is inside.
fn place(node: usize, by: &[f64]) -> [f64; 3] {
    let Some(cell) = node.checked_sub(EDGE * EDGE * EDGE) else {
        let at = [node % EDGE, node / EDGE % EDGE, node / EDGE / EDGE];
        let inside = at.iter().all(|x| (1..SIDE).contains(x));
        let moved = |axis: usize| if inside { by[axis] } else { 0.0 };
        return [0, 1, 2].map(|axis| at[axis] as f64 + moved(axis));
    };
    [0, 1, 2].map(|axis| {
        let sum: f64 = corners(cell)[..8]
            .iter()
            .map(|at| place(*at, by)[axis])
            .sum();
        sum / 8.0
    })
}

fn volumes(mesh: &MeshFile) -> Vec<f64> {
    let point = |at: &u32| mesh.coordinates[*at as usize];
    let volume = |cell: &[u32]| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|at| point(&cell[at]));
        let side = |to: [f64; 3]| [0, 1, 2].map(|axis| to[axis] - a[axis]);
        let ([a, b, c], [d, e, f], [g, h, i]) = (side(b), side(c), side(d));
        (a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)) / 6.0
    };
    mesh.cells.chunks(4).map(volume).collect()
}

/// Facets of cells with how many have them.
fn shared(mesh: &MeshFile) -> HashMap<Vec<u32>, usize> {
    let mut shared = HashMap::new();
    for cell in mesh.cells.chunks(4) {
        for left_out in cell {
            let mut facet: Vec<u32> = cell.iter().copied().filter(|at| at != left_out).collect();
            facet.sort_unstable();
            *shared.entry(facet).or_default() += 1;
        }
    }
    shared
}

fn column() -> impl Strategy<Value = Column> {
    prop_oneof![
        Just(Column::Hexahedra),
        Just(Column::Wedges),
        Just(Column::Pyramids)
    ]
}

proptest! {
    #[test]
    fn any_numbering_gives_a_conforming_mesh_of_the_same_volume(
        columns in prop::collection::vec(column(), SIDE * SIDE),
        numbers in Just((1..=NODES).collect::<Vec<usize>>()).prop_shuffle(),
        by in prop::collection::vec(-0.2..0.2_f64, 3),
    ) {
        let mesh = read(deck(&columns, &numbers, |node| place(node, &by)).as_bytes()).unwrap();
        let volumes = volumes(&mesh);
        prop_assert!(volumes.iter().all(|volume| *volume > 1e-3));
        let whole = (SIDE * SIDE * SIDE) as f64;
        prop_assert!((volumes.iter().sum::<f64>() - whole).abs() < 1e-12 * whole);
        let shared = shared(&mesh);
        prop_assert!(shared.values().all(|cells| *cells <= 2));
        // Two triangles of each square of the surface, nothing else is outside.
        let outer = shared.values().filter(|cells| **cells == 1).count();
        prop_assert_eq!(outer, 6 * SIDE * SIDE * 2);
        prop_assert_eq!(mesh.facet_count(), outer);
    }
}

#[test]
fn cells_have_their_counts_and_the_split_is_told() {
    let numbers: Vec<usize> = (1..=NODES).collect();
    let [hexahedra, wedges, pyramids] = [Column::Hexahedra, Column::Wedges, Column::Pyramids];
    let columns = [hexahedra, wedges, pyramids, hexahedra];
    let mesh = read(deck(&columns, &numbers, |node| place(node, &[0.1; 3])).as_bytes()).unwrap();
    assert_eq!(mesh.cell_count(), 4 * 6 + 4 * 3 + 12 * 2);
    let told = "4 hexahedra, 12 pyramids, 4 wedges are split into tetrahedra, each face along the \
        diagonal through its smallest node number";
    assert_eq!(mesh.warnings, [told]);
}

#[test]
fn a_collapsed_hexahedron_is_the_wedge_that_it_stands_for() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n5, 1., 0., 1.\n\
        6, 0., 1., 1.\n";
    let collapsed = format!("{nodes}*ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 3, 4, 5, 6, 6\n");
    let wedge = format!("{nodes}*ELEMENT, TYPE=C3D6\n1, 1, 2, 3, 4, 5, 6\n");
    let sorted = |text: &str| {
        let mesh = read(text.as_bytes()).unwrap();
        let mut cells: Vec<Vec<u32>> = mesh.cells.chunks(4).map(<[u32]>::to_vec).collect();
        cells.iter_mut().for_each(|cell| cell.sort_unstable());
        cells.sort();
        cells
    };
    assert_eq!(sorted(&collapsed).len(), 3);
    assert_eq!(sorted(&collapsed), sorted(&wedge));
}

#[test]
fn a_cell_that_is_folded_is_refused_by_its_nodes() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n\
        6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n*ELEMENT, TYPE=C3D8\n";
    // Two corners of the top are exchanged.
    let folded = format!("{text}1, 1, 2, 3, 4, 5, 6, 8, 7\n");
    let fault = read(folded.as_bytes()).unwrap_err().fault;
    let nodes = "1, 2, 3, 4, 5, 6, 8, 7".to_owned();
    assert_eq!(fault, InpFault::Mesh(MeshFault::Folded(nodes)));
    // Numbered from the top: all tetrahedra would be turned over, and are turned.
    let turned = format!("{text}1, 5, 6, 7, 8, 1, 2, 3, 4\n");
    let mesh = read(turned.as_bytes()).unwrap();
    assert!(volumes(&mesh).iter().all(|volume| *volume > 0.0));
}

#[test]
fn a_quadrangle_that_bends_inwards_takes_the_diagonal_inside() {
    let text = "*NODE\n1, 2., 0.\n2, 0., 1.\n3, 0.5, 0.\n4, 0., -1.\n*ELEMENT, TYPE=CPE4R\n1, 1, 2, 3, 4\n";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!(mesh.cells, [0, 1, 2, 0, 2, 3]);
    // Its smallest node is a side now, and the diagonal through it is outside.
    let numbers = text.replace("1, 1, 2, 3, 4", "1, 4, 1, 2, 3");
    let moved = numbers
        .replace("1, 2., 0.\n2, 0., 1.\n", "1, 0., 1.\n2, 0.5, 0.\n")
        .replace("3, 0.5, 0.\n4, 0., -1.\n", "3, 0., -1.\n4, 2., 0.\n");
    let mesh = read(moved.as_bytes()).unwrap();
    let halves: Vec<bool> = mesh
        .cells
        .chunks(3)
        .map(|cell| cell.contains(&1) && cell.contains(&3))
        .collect();
    assert_eq!(halves, [true, true]);
    assert_eq!(mesh.curved, []);
}

#[test]
fn diagonals_of_second_order_lie_on_the_surface_that_the_middles_give() {
    let mesh = read(ring().as_bytes()).unwrap();
    assert_eq!(mesh.cell_count(), 12);
    let mut diagonals = 0;
    for edge in &mesh.curved {
        let [a, b] = edge.ends.map(|end| mesh.coordinates[end as usize]);
        let middle = [0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis]) + edge.offset[axis]);
        let radius = |point: [f64; 3]| point[0].hypot(point[1]);
        let is_on_one_face = (radius(a) - radius(b)).abs() < 1e-9;
        if is_on_one_face {
            // Twice the angle of a face of 45 degrees: the serendipity value is 0.2 % off.
            assert!((radius(middle) / radius(a) - 1.0).abs() < 3e-3, "{edge:?}");
        }
        diagonals += usize::from(is_on_one_face && (a[2] - b[2]).abs() > 0.1);
    }
    // One on the inner and one on the outer face of each of two cells.
    assert_eq!(diagonals, 4);
}

#[test]
fn gmsh_and_abaqus_number_one_ring_in_their_own_ways() {
    use crate::formats::msh;
    let ours = read(ring().as_bytes()).unwrap();
    let (nodes, elements) = ring()
        .split_once("*ELEMENT, TYPE=C3D20R\n")
        .map(|(a, b)| (a.to_owned(), b.replace(",\n", ", ")))
        .unwrap();
    let nodes: Vec<&str> = nodes.lines().skip(1).collect();
    let mut text = format!(
        "$Comments\nby hand\n$EndComments\n$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n",
        nodes.len()
    );
    for node in nodes {
        text += &format!("{}\n", node.replace(',', ""));
    }
    text += "$EndNodes\n$Elements\n2\n";
    for element in elements.lines() {
        let numbers: Vec<&str> = element.split(", ").collect();
        let mut of_gmsh = vec![""; 20];
        for (own, at) in OF_ABAQUS_IN_GMSH.iter().enumerate() {
            of_gmsh[*at] = numbers[own + 1];
        }
        text += &format!("{} 17 2 1 1 {}\n", numbers[0], of_gmsh.join(" "));
    }
    text += "$EndElements\n";
    let mesh = msh::read(text.as_bytes()).unwrap();
    assert_eq!((mesh.cells, mesh.curved), (ours.cells, ours.curved));
}

/// Where Gmsh has each node of a hexahedron of second order of Abaqus, from its table of edges.
const OF_ABAQUS_IN_GMSH: [usize; 20] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15,
];

/// Two hexahedra of second order: a quarter of a ring of radii 1 and 2 and height 1.
fn ring() -> String {
    let node = |i: usize, j: usize, k: usize| 1 + i + 5 * j + 15 * k;
    let mut text = "*NODE\n".to_owned();
    for (i, j, k) in (0..45).map(|at| (at % 5, at / 5 % 3, at / 15)) {
        let odd = i % 2 + j % 2 + k % 2;
        if odd > 1 {
            continue;
        }
        let angle = i as f64 * std::f64::consts::PI / 8.0;
        let (radius, z) = (1.0 + 0.5 * j as f64, 0.5 * k as f64);
        let (x, y) = (radius * angle.cos(), radius * angle.sin());
        let _infallible = writeln!(text, "{}, {x:?}, {y:?}, {z:?}", node(i, j, k));
    }
    text += "*ELEMENT, TYPE=C3D20R\n";
    for cell in 0..2 {
        let i = 2 * cell;
        let square = [[0, 0], [0, 2], [2, 2], [2, 0]];
        let sides = [[0, 1], [1, 2], [2, 1], [1, 0]];
        let at = |[a, b]: [usize; 2], k: usize| node(i + a, b, k).to_string();
        let mut nodes: Vec<String> = vec![(cell + 1).to_string()];
        for (rows, k) in [
            (square, 0),
            (square, 2),
            (sides, 0),
            (sides, 2),
            (square, 1),
        ] {
            nodes.extend(rows.map(|row| at(row, k)));
        }
        let _infallible = writeln!(
            text,
            "{},\n{}",
            nodes[..11].join(", "),
            nodes[11..].join(", ")
        );
    }
    text
}
