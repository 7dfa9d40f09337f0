//! Bodies of hexahedra and quadrangles, as most decks have them, against their twins of tetrahedra
//! and triangles.
#![cfg(feature = "embedded")]

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;

use crate::common::{folder, run};

/// Corners of a hexahedron, the first four those of a quadrangle.
const HEXAHEDRON: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];
/// Edges of cells in the order of their middles.
const OF_HEXAHEDRON: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];
const OF_TETRAHEDRON: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
/// Axes in the order in which the corners of six tetrahedra take them.
const WAYS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

/// A part of the section in the unit square of its two coordinates.
type Block = fn([f64; 2]) -> [f64; 2];

/// The nodes of a file, equal places once, and its elements.
#[derive(Default)]
struct Deck {
    nodes: BTreeMap<[i64; 3], usize>,
    places: Vec<[f64; 3]>,
    elements: Vec<(String, Vec<usize>)>,
}

fn mean<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
}

impl Deck {
    fn node(&mut self, place: [f64; 3]) -> usize {
        let next = self.places.len();
        let key = place.map(|x| (1e7 * x).round() as i64);
        let at = *self.nodes.entry(key).or_insert(next);
        if at == next {
            self.places.push(place);
        }
        at + 1
    }

    /// A cell by its corners in the coordinates of a block, with the middles of `edges`.
    fn add(
        &mut self,
        kind: &str,
        place: &dyn Fn([f64; 3]) -> [f64; 3],
        (corners, edges): (&[[f64; 3]], &[[usize; 2]]),
    ) {
        let middles = edges.iter().map(|[a, b]| mean(corners[*a], corners[*b]));
        let all: Vec<[f64; 3]> = corners.iter().copied().chain(middles).collect();
        let nodes = all.into_iter().map(|at| self.node(place(at))).collect();
        self.elements.push((kind.to_owned(), nodes));
    }

    /// The file; `up` is the axis from `floor` to `top`.
    fn text(&self, up: usize) -> String {
        let mut text = "*NODE\n".to_owned();
        for (index, [x, y, z]) in self.places.iter().enumerate() {
            let _infallible = writeln!(text, "{}, {x:?}, {y:?}, {z:?}", index + 1);
        }
        for (number, (kind, nodes)) in (1..).zip(&self.elements) {
            let words: Vec<String> = nodes.iter().map(usize::to_string).collect();
            let lines: Vec<String> = words.chunks(10).map(|line| line.join(", ")).collect();
            let lines = lines.join(",\n");
            let _infallible =
                writeln!(text, "*ELEMENT, TYPE={kind}, ELSET=body\n{number}, {lines}");
        }
        for (name, axis, at) in [
            ("floor", up, 0.0),
            ("top", up, 1.0),
            ("x0", 0, 0.0),
            ("y0", 1, 0.0),
        ] {
            let on = |place: &[f64; 3]| (place[axis] - at).abs() < 1e-9;
            let _infallible = writeln!(text, "*NSET, NSET={name}");
            for (index, _) in self
                .places
                .iter()
                .enumerate()
                .filter(|(_, place)| on(place))
            {
                let _infallible = writeln!(text, "{},", index + 1);
            }
        }
        text
    }
}

/// What a body is made of.
#[derive(Clone, Copy, PartialEq)]
enum Made {
    Cells,
    Simplices,
}

/// Six times the volume of a corner: its sign says whether the block is seen from behind.
fn handed([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    let [u, v, w] = [b, c, d].map(|to| [0, 1, 2].map(|i| to[i] - a[i]));
    let cross =
        [0, 1, 2].map(|i| u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    (0..3).map(|i| cross[i] * w[i]).sum()
}

/// A prism of height one over the blocks, each of `counts` cells along its coordinates and up, of
/// first order or second.
fn prism(blocks: &[Block], counts: [usize; 3], (made, order): (Made, usize)) -> String {
    let mut deck = Deck::default();
    for block in blocks {
        let place = |[u, v, w]: [f64; 3]| {
            let [x, y] = block([u, v]);
            [x, y, w]
        };
        for cell in 0..counts.iter().product() {
            let first = [
                cell % counts[0],
                cell / counts[0] % counts[1],
                cell / counts[0] / counts[1],
            ];
            let at = |local: [usize; 3]| -> [f64; 3] {
                std::array::from_fn(|i| (first[i] + local[i]) as f64 / counts[i] as f64)
            };
            if made == Made::Cells {
                let mut corners = HEXAHEDRON.map(at);
                if handed([0, 1, 3, 4].map(|i| place(corners[i]))) < 0.0 {
                    corners = [0, 3, 2, 1, 4, 7, 6, 5].map(|i| corners[i]);
                }
                let edges = if order == 2 { &OF_HEXAHEDRON[..] } else { &[] };
                deck.add(
                    if order == 2 { "C3D20R" } else { "C3D8H" },
                    &place,
                    (&corners, edges),
                );
                continue;
            }
            for way in WAYS {
                let mut corners = [[0; 3]; 4];
                for (step, axis) in way.iter().enumerate() {
                    corners[step + 1] = corners[step];
                    corners[step + 1][*axis] = 1;
                }
                let mut corners = corners.map(at);
                if handed(corners.map(place)) < 0.0 {
                    corners.swap(1, 2);
                }
                let edges = if order == 2 { &OF_TETRAHEDRON[..] } else { &[] };
                deck.add(
                    if order == 2 { "C3D10M" } else { "C3D4H" },
                    &place,
                    (&corners, edges),
                );
            }
        }
    }
    deck.text(2)
}

/// The section between two radii about the axis, of quadrangles or triangles of second order.
fn section([inner, outer]: [f64; 2], count: usize, made: Made) -> String {
    let mut deck = Deck::default();
    let place = |[u, v, _]: [f64; 3]| [inner + (outer - inner) * u, v, 0.0];
    for cell in 0..count * count {
        let first = [cell % count, cell / count];
        let corners: [[f64; 3]; 4] = std::array::from_fn(|corner| {
            let [a, b, _] = HEXAHEDRON[corner];
            [(first[0] + a) as f64, (first[1] + b) as f64, 0.0].map(|x| x / count as f64)
        });
        if made == Made::Cells {
            deck.add("CAX8RH", &place, (&corners, &OF_HEXAHEDRON[..4]));
            continue;
        }
        for part in [[0, 1, 2], [0, 2, 3]] {
            let corners = part.map(|i| corners[i]);
            deck.add("CAX6MH", &place, (&corners, &OF_TETRAHEDRON[..3]));
        }
    }
    deck.text(1)
}

/// The force of a plate that presses a body bonded to its floor by a twentieth.
fn force(name: &str, mesh: &str, is_section: bool) -> f64 {
    let folder = folder(&format!("hexahedra_{name}"));
    std::fs::write(folder.join("body.inp"), mesh).unwrap();
    let (kind, up) = if is_section {
        ("axisymmetric", 1)
    } else {
        ("solid", 2)
    };
    let vector = |size: f64| {
        let vector: [f64; 3] = std::array::from_fn(|i| if i == up { size } else { 0.0 });
        format!("{vector:?}")
    };
    let (hold, sides) = if is_section {
        ("{ x = 0.0, y = 0.0 }", String::new())
    } else {
        let sides = "[[support]]\nname = \"sides\"\non = [\"x0\", \"y0\"]\nnormal = 0.0\n";
        ("{ x = 0.0, y = 0.0, z = 0.0 }", sides.to_owned())
    };
    let [point, normal, way] = [1.0, -1.0, -0.05].map(vector);
    let scene = format!(
        "mesh = \"body.inp\"\nkind = \"{kind}\"\n[material.body]\nmodel = \"linear-elastic\"\n\
         shear_modulus = 1.0\npoisson_ratio = 0.5\n[[support]]\nname = \"floor\"\non = \"floor\"\n\
         displacement = {hold}\n{sides}[[obstacle]]\nname = \"plate\"\non = \"top\"\n\
         shape = {{ kind = \"half-space\", point = {point}, normal = {normal} }}\n\
         [[step]]\nobstacle.plate = {{ translation = {way} }}\n"
    );
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    let solved = run(["solve", path.to_str().unwrap(), "--json", "--quiet"]);
    assert_eq!(solved.code, Some(0), "{name}: {}", solved.stderr);
    let step = solved.events("step").pop().unwrap();
    step["obstacles"]["plate"]["force"][up].as_f64().unwrap()
}

/// Fails unless all forces are the first within one per cent.
fn assert_equal(forces: &[(&str, f64)]) {
    let (_, first) = forces[0];
    for (name, force) in forces {
        assert!((force / first - 1.0).abs() < 0.01, "{name}: {forces:?}");
    }
}

#[test]
fn a_cube_of_hexahedra_is_that_of_tetrahedra() {
    let square: Block = |at| at;
    let body = |made| prism(&[square], [5, 5, 5], (made, 1));
    let mesh = body(Made::Cells);
    let forces = [
        ("hexahedra", force("cube_hex", &mesh, false)),
        (
            "tetrahedra",
            force("cube_tet", &body(Made::Simplices), false),
        ),
    ];
    assert!(forces[0].1 < 0.0);
    assert_equal(&forces);
}

/// Corners of the square inside a disc: on an axis, and on the diagonal.
const INSIDE: [f64; 2] = [0.5, 0.42];

/// From the inner square to the circle; `end` is the corner on the axis.
fn outwards([u, v]: [f64; 2], end: [f64; 2], angle: f64) -> [f64; 2] {
    let from = mix(end, [INSIDE[1]; 2], u);
    mix(from, [angle.cos(), angle.sin()], v)
}

fn mix(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|i| a[i] + share * (b[i] - a[i]))
}

#[test]
fn a_cylinder_of_hexahedra_is_that_of_tetrahedra_and_its_sections() {
    let [axis, diagonal] = INSIDE;
    assert!(axis < 1.0 && diagonal < axis);
    let blocks: [Block; 3] = [
        |[u, v]| {
            let low = mix([0.0; 2], [INSIDE[0], 0.0], u);
            let high = mix([0.0, INSIDE[0]], [INSIDE[1]; 2], u);
            mix(low, high, v)
        },
        |at| outwards(at, [INSIDE[0], 0.0], FRAC_PI_4 * at[0]),
        |at| outwards(at, [0.0, INSIDE[0]], FRAC_PI_4 * (2.0 - at[0])),
    ];
    let body = |made| prism(&blocks, [2, 2, 4], (made, 2));
    let plane = |made| section([0.0, 1.0], 6, made);
    let forces = [
        ("quadrangles", force("disc_quad", &plane(Made::Cells), true)),
        (
            "triangles",
            force("disc_tri", &plane(Made::Simplices), true),
        ),
        (
            "hexahedra",
            4.0 * force("disc_hex", &body(Made::Cells), false),
        ),
        (
            "tetrahedra",
            4.0 * force("disc_tet", &body(Made::Simplices), false),
        ),
    ];
    assert_equal(&forces);
}

#[test]
fn a_ring_of_hexahedra_is_that_of_tetrahedra_and_its_sections() {
    let ring: Block = |[u, v]| {
        let (radius, angle) = (1.0 + v, 2.0 * FRAC_PI_4 * u);
        [radius * angle.cos(), radius * angle.sin()]
    };
    let body = |made| prism(&[ring], [4, 4, 4], (made, 2));
    let plane = |made| section([1.0, 2.0], 6, made);
    let forces = [
        ("quadrangles", force("ring_quad", &plane(Made::Cells), true)),
        (
            "triangles",
            force("ring_tri", &plane(Made::Simplices), true),
        ),
        (
            "hexahedra",
            4.0 * force("ring_hex", &body(Made::Cells), false),
        ),
        (
            "tetrahedra",
            4.0 * force("ring_tet", &body(Made::Simplices), false),
        ),
    ];
    assert_equal(&forces);
}
