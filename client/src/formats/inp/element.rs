//! Element types by the names of Abaqus.
//!
//! Suffixes (hybrid H, modified M, reduced R, thermal T ...) say how a cell is solved,
//! which is not read: the scene says it. Types of surfaces and lines are taken as facets.

use crate::formats::mesh::raw::ElementKind;

/// Dimension and nodes.
type Form = (usize, usize);

const LINE_2: Form = (1, 2);
const LINE_3: Form = (1, 3);
const TRIANGLE_3: Form = (2, 3);
const TRIANGLE_6: Form = (2, 6);
const QUADRANGLE_4: Form = (2, 4);
const QUADRANGLE_8: Form = (2, 8);
const TETRAHEDRON_4: Form = (3, 4);
const TETRAHEDRON_10: Form = (3, 10);

/// Beginnings of names; what may follow is letters.
const TYPES: &[(&str, Form)] = &[
    ("C3D4", TETRAHEDRON_4),
    ("C3D10", TETRAHEDRON_10),
    ("C3D5", (3, 5)),
    ("C3D13", (3, 13)),
    ("C3D6", (3, 6)),
    ("C3D15", (3, 15)),
    ("C3D8", (3, 8)),
    ("C3D20", (3, 20)),
    ("CPE3", TRIANGLE_3),
    ("CPE4", QUADRANGLE_4),
    ("CPE6", TRIANGLE_6),
    ("CPE8", QUADRANGLE_8),
    ("CPS3", TRIANGLE_3),
    ("CPS4", QUADRANGLE_4),
    ("CPS6", TRIANGLE_6),
    ("CPS8", QUADRANGLE_8),
    ("CAX3", TRIANGLE_3),
    ("CAX4", QUADRANGLE_4),
    ("CAX6", TRIANGLE_6),
    ("CAX8", QUADRANGLE_8),
    ("S3", TRIANGLE_3),
    ("S4", QUADRANGLE_4),
    ("S6", TRIANGLE_6),
    ("S8", QUADRANGLE_8),
    ("S8R5", QUADRANGLE_8),
    ("STRI3", TRIANGLE_3),
    ("STRI65", TRIANGLE_6),
    ("M3D3", TRIANGLE_3),
    ("M3D4", QUADRANGLE_4),
    ("M3D6", TRIANGLE_6),
    ("M3D8", QUADRANGLE_8),
    ("SFM3D3", TRIANGLE_3),
    ("SFM3D4", QUADRANGLE_4),
    ("SFM3D6", TRIANGLE_6),
    ("SFM3D8", QUADRANGLE_8),
    ("R3D3", TRIANGLE_3),
    ("R3D4", QUADRANGLE_4),
    ("T2D2", LINE_2),
    ("T2D3", LINE_3),
    ("T3D2", LINE_2),
    ("T3D3", LINE_3),
    ("B21", LINE_2),
    ("B22", LINE_3),
    ("B31", LINE_2),
    ("B32", LINE_3),
    // As meshio writes lines of three nodes; of Abaqus, which gives it two, no facet is made.
    ("B33H", LINE_3),
    ("R2D2", LINE_2),
    ("RAX2", LINE_2),
    ("SAX1", LINE_2),
    ("SAX2", LINE_3),
    ("MAX1", LINE_2),
    ("MAX2", LINE_3),
    ("SFMAX1", LINE_2),
    ("SFMAX2", LINE_3),
];

/// Beginnings of the names of what joins bodies or carries mass, and is no part of a mesh.
const NO_CELLS: [&str; 13] = [
    "CONN2D2", "CONN3D2", "DASHPOT", "DCOUP", "GAP", "HEATCAP", "ITS", "ITT", "JOINTC", "MASS",
    "ROTARYI", "SPRING", "DRAG",
];

/// Whether a type, in capitals, is a spring, a mass, a connector or the like.
pub(super) fn is_no_cell(name: &str) -> bool {
    NO_CELLS.iter().any(|start| name.starts_with(start))
}

/// The kind of a type, in capitals; none of one that no mesh can be made of.
pub(super) fn kind(name: &str) -> Option<ElementKind> {
    let letters = |rest: &str| rest.bytes().all(|byte| byte.is_ascii_uppercase());
    let found = TYPES
        .iter()
        .find(|(start, _)| name.strip_prefix(start).is_some_and(letters));
    found.map(|&(_, (dimension, nodes))| ElementKind { dimension, nodes })
}

/// Local vertices of the face `S{number}` of a cell.
pub(super) fn face(kind: ElementKind, number: usize) -> Option<&'static [usize]> {
    kind.faces().get(number.checked_sub(1)?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffixes_are_letters_and_digits_make_another_type() {
        for name in ["C3D10", "C3D10M", "C3D10MH", "C3D10HS"] {
            assert_eq!(kind(name).map(|kind| kind.nodes), Some(10), "{name}");
        }
        assert_eq!(kind("CAX6MH").map(|kind| kind.dimension), Some(2));
        for (name, nodes) in [
            ("C3D8R", 8),
            ("C3D8IH", 8),
            ("C3D20R", 20),
            ("CPE4RH", 4),
            ("S4R", 4),
            ("S8R5", 8),
        ] {
            assert_eq!(kind(name).map(|kind| kind.nodes), Some(nodes), "{name}");
        }
        for name in ["C3D27", "C3D40", "", "MASS", "CPE5H", "COH3D8"] {
            assert_eq!(kind(name), None, "{name}");
        }
    }
}
