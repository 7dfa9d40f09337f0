//! What files of other programs have: every type of cell with its volume and the areas of its
//! faces, the forms of sets and surfaces, and what is no part of the body.

use super::read;
use crate::formats::mesh::MeshFile;

type Point = [f64; 3];

/// A cell of reference: corners, pairs of corners of its edges in the order of their middles, the
/// measure, and those of its faces S1, S2, ...
struct Shape {
    corners: &'static [Point],
    edges: &'static [[usize; 2]],
    measure: f64,
    faces: &'static [f64],
    linear: &'static [&'static str],
    quadratic: &'static [&'static str],
}

const ROOT: f64 = std::f64::consts::SQRT_2;
const LATERAL: f64 = 0.559_016_994_374_947_5;
const CUBE: [Point; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

#[rustfmt::skip]
const SHAPES: [Shape; 6] = [
    Shape {
        corners: &CUBE,
        edges: &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
        measure: 1.0,
        faces: &[1.0; 6],
        linear: &["C3D8", "C3D8R", "C3D8H", "C3D8RH", "C3D8I", "C3D8IH", "c3d8r"],
        quadratic: &["C3D20", "C3D20R", "C3D20H", "C3D20RH"],
    },
    Shape {
        corners: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        edges: &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
        measure: 0.5,
        faces: &[0.5, 0.5, 1.0, ROOT, 1.0],
        linear: &["C3D6", "C3D6H"],
        quadratic: &["C3D15", "C3D15H"],
    },
    Shape {
        corners: &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]],
        edges: &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
        measure: 1.0 / 3.0,
        faces: &[1.0, LATERAL, LATERAL, LATERAL, LATERAL],
        linear: &["C3D5", "C3D5H"],
        quadratic: &["C3D13"],
    },
    Shape {
        corners: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        edges: &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]],
        measure: 1.0 / 6.0,
        faces: &[0.5, 0.5, 0.866_025_403_784_438_6, 0.5],
        linear: &["C3D4", "C3D4H"],
        quadratic: &["C3D10", "C3D10M", "C3D10H", "C3D10MH", "C3D10HS"],
    },
    Shape {
        corners: &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        edges: &[[0, 1], [1, 2], [2, 3], [3, 0]],
        measure: 1.0,
        faces: &[1.0; 4],
        linear: &["CPE4", "CPE4R", "CPE4H", "CPE4RH", "CPE4I", "CPS4R", "CAX4", "CAX4H", "CAX4RH"],
        quadratic: &["CPE8", "CPE8RH", "CPS8R", "CAX8", "CAX8H", "CAX8R", "CAX8RH"],
    },
    Shape {
        corners: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        edges: &[[0, 1], [1, 2], [2, 0]],
        measure: 0.5,
        faces: &[1.0, ROOT, 1.0],
        linear: &["CPE3", "CPE3H", "CPS3", "CAX3", "CAX3H"],
        quadratic: &["CPE6", "CPE6H", "CPE6M", "CPE6MH", "CPS6", "CAX6", "CAX6H", "CAX6M", "CAX6MH"],
    },
];

/// A file of one cell with a surface for each of its faces.
fn deck(shape: &Shape, kind: &str, middles: bool) -> String {
    let mut points = shape.corners.to_vec();
    let middle = |[a, b]: &[usize; 2]| {
        let ends = [shape.corners[*a], shape.corners[*b]];
        [0, 1, 2].map(|axis| 0.5 * (ends[0][axis] + ends[1][axis]))
    };
    points.extend(shape.edges.iter().filter(|_| middles).map(middle));
    let mut text = "*NODE\n".to_owned();
    for (node, [x, y, z]) in points.iter().enumerate() {
        text += &format!("{}, {x:?}, {y:?}, {z:?}\n", node + 1);
    }
    let nodes: Vec<String> = (1..=points.len()).map(|node| node.to_string()).collect();
    // Eight numbers a line, as programs write them.
    let lines: Vec<String> = nodes.chunks(8).map(|line| line.join(", ")).collect();
    text += &format!(
        "*ELEMENT, TYPE={kind}, ELSET=core\n7, {}\n",
        lines.join(",\n")
    );
    for face in 1..=shape.faces.len() {
        text += &format!("*SURFACE, NAME=face{face}, TYPE=ELEMENT\n7, S{face}\n");
    }
    text
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn cross(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn norm(a: Point) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Length, area or volume of a simplex.
fn size(mesh: &MeshFile, vertices: &[u32]) -> f64 {
    let point = |at: u32| mesh.coordinates[at as usize];
    let from = point(vertices[0]);
    let sides: Vec<Point> = vertices[1..]
        .iter()
        .map(|at| sub(point(*at), from))
        .collect();
    match sides[..] {
        [a] => norm(a),
        [a, b] => 0.5 * norm(cross(a, b)),
        [a, b, c] => (0..3).map(|i| cross(a, b)[i] * c[i]).sum::<f64>() / 6.0,
        _ => 0.0,
    }
}

/// What a group of cells or facets covers; none where there is no such group.
fn covered(mesh: &MeshFile, name: &str) -> Option<f64> {
    let group = mesh.groups.iter().find(|group| group.name == name)?;
    let width = group.dimension + 1;
    let all = if width == mesh.vertices_per_cell {
        &mesh.cells
    } else {
        &mesh.facets
    };
    let members = group.members.iter().map(|at| *at as usize * width);
    Some(
        members
            .map(|first| size(mesh, &all[first..first + width]))
            .sum(),
    )
}

#[test]
fn every_type_of_a_cell_has_its_volume_and_its_faces_their_areas() {
    for shape in &SHAPES {
        let linear = shape.linear.iter().map(|kind| (kind, false));
        for (kind, middles) in linear.chain(shape.quadratic.iter().map(|kind| (kind, true))) {
            let mesh = read(deck(shape, kind, middles).as_bytes());
            let mesh = mesh.unwrap_or_else(|error| panic!("{kind}: {error}"));
            let volume = covered(&mesh, "core").unwrap();
            assert!((volume - shape.measure).abs() < 1e-14, "{kind} {volume}");
            for (index, area) in shape.faces.iter().enumerate() {
                let found = covered(&mesh, &format!("face{}", index + 1)).unwrap();
                assert!(
                    (found - area).abs() < 1e-14,
                    "{kind} S{} {found}",
                    index + 1
                );
            }
            assert_eq!(mesh.curved, [], "{kind}");
        }
    }
}

#[test]
fn types_that_carry_no_solution_here_are_refused_with_their_line_and_those_that_do() {
    for kind in [
        "C3D27", "C3D10T5", "CPE5", "CGAX4", "COH3D8", "EC3D8R", "SC8R", "FC3D8", "AC3D8", "CIN3D8",
    ] {
        let error = read(deck(&SHAPES[0], kind, false).as_bytes()).unwrap_err();
        let told = error.to_string();
        assert_eq!(error.line, Some(10), "{kind}: {told}");
        assert!(told.contains(kind) && told.contains("C3D8"), "{told}");
    }
    let short = deck(&SHAPES[0], "C3D20R", false);
    let told = read(short.as_bytes()).unwrap_err().to_string();
    assert!(
        told.contains("element 7 of type C3D20R has 20 nodes"),
        "{told}"
    );
}

/// A cube with what stands in `rest`.
fn cube(rest: &str) -> MeshFile {
    let text = deck(&SHAPES[0], "C3D8R", false) + rest;
    read(text.as_bytes()).unwrap_or_else(|error| panic!("{rest}: {error}"))
}

/// Whether that is a unit of volume or area.
fn is_whole(part: Option<f64>) -> bool {
    part.is_some_and(|part| (part - 1.0).abs() < 1e-12)
}

#[test]
fn what_stands_beside_the_body_is_left_out_and_told() {
    let beside = "*NODE\n21, 3., 0., 0.\n22, 4., 0., 0.\n23, 4., 1., 0.\n24, 3., 1., 0.\n";
    for (kind, nodes) in [
        ("B31", "21, 22"),
        ("T3D2", "1, 21"),
        ("CONN3D2", "1, 21"),
        ("DASHPOTA", "1, 21"),
        ("SPRINGA", "1, 21"),
        ("MASS", "21"),
        ("ROTARYI", "21"),
    ] {
        let mesh = cube(&format!(
            "{beside}*ELEMENT, TYPE={kind}, ELSET=other\n30, {nodes}\n"
        ));
        assert!(is_whole(covered(&mesh, "core")), "{kind}");
        let told = format!("elements of type {kind} are no cells, and are left out");
        assert!(mesh.warnings.contains(&told), "{kind}: {:?}", mesh.warnings);
    }
    for (kind, nodes, facets) in [
        ("S4R", "21, 22, 23, 24", 2),
        ("R3D4", "1, 2, 22, 21", 2),
        // A half of a side along the other diagonal.
        ("M3D3", "2, 3, 4", 1),
    ] {
        let mesh = cube(&format!(
            "{beside}*ELEMENT, TYPE={kind}, ELSET=other\n30, {nodes}\n*SURFACE, NAME=tool\nother, SPOS\n"
        ));
        assert!(is_whole(covered(&mesh, "core")), "{kind}");
        assert!(
            covered(&mesh, "other").is_none_or(|part| part <= 0.0),
            "{kind}"
        );
        assert_eq!(mesh.facet_count(), 12, "{kind}");
        let told = format!("{facets} facets of surface elements ({kind}) are no faces of cells");
        let mut warnings = mesh.warnings.iter();
        assert!(
            warnings.any(|one| one.starts_with(&told)),
            "{:?}",
            mesh.warnings
        );
    }
    let skin = cube("*ELEMENT, TYPE=S4, ELSET=skin\n30, 5, 6, 7, 8\n");
    assert!(is_whole(covered(&skin, "skin")));
    assert!(skin.warnings.iter().all(|one| !one.contains("no faces")));
}

#[test]
fn constraints_and_ties_are_told_and_leave_the_body_as_it_is() {
    for (text, keyword) in [
        ("*MPC\nBEAM, 1, 2\n", "*MPC"),
        ("*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n", "*EQUATION"),
        (
            "*COUPLING, CONSTRAINT NAME=c, REF NODE=1, SURFACE=face1\n*KINEMATIC\n1, 3\n",
            "*COUPLING",
        ),
        ("*TIE, NAME=t\nface1, face2\n", "(*TIE) are not solved yet"),
    ] {
        let mesh = cube(text);
        assert!(is_whole(covered(&mesh, "core")));
        let told = mesh.warnings.iter().filter(|one| one.contains(keyword));
        assert_eq!(told.count(), 1, "{keyword}: {:?}", mesh.warnings);
    }
}

#[test]
fn sets_are_read_in_every_form_of_programs() {
    for form in [
        "*NSET, NSET=floor\n1, 2, 3, 4\n",
        "*nset, nset=floor, unsorted\n 4,1 ,\n\n** comment, in the middle\n3,\n2\n",
        "*Nset, nset=\"floor\"\n1, 2, 3, 4,\n",
        "*NSET,\nNSET=floor,\nGENERATE\n4, 1, -1\n",
        "*NSET, NSET=half\n1, 2\n*NSET, NSET=FLOOR\nhalf, 3\n*NSET, NSET=floor\n4\n",
        "*SURFACE, TYPE=NODE, NAME=floor\n1, 1.\n2,\n3\n4, 0.5\n",
        "*NSET, NSET=n\n1, 2, 3, 4\n*SURFACE, TYPE=NODE, NAME=floor\nn, 1.\n",
        "*surface, type=element, name=floor\ncore, s1\n",
        "*ELSET, ELSET=\"my core\"\n7\n*SURFACE, NAME=floor\n\"my core\", S1\n",
    ] {
        let mesh = cube(form);
        let named = mesh
            .groups
            .iter()
            .find(|group| group.name.eq_ignore_ascii_case("floor"));
        let area = named.and_then(|group| covered(&mesh, &group.name));
        assert_eq!(area, Some(1.0), "{form}");
    }
    for (form, cure) in [
        (
            "*SURFACE, NAME=s, COMBINE=UNION\nface1, face2\n",
            "in one *SURFACE",
        ),
        ("*SURFACE, NAME=s, TYPE=EDGE\n1,\n", "TYPE=ELEMENT or NODE"),
        ("*NGEN\n1, 9, 1\n", "write the mesh itself"),
    ] {
        let told = read((deck(&SHAPES[0], "C3D8", false) + form).as_bytes()).unwrap_err();
        assert!(
            told.line.is_some() && told.to_string().contains(cure),
            "{told}"
        );
    }
}
