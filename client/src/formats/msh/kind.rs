//! Element types by the numbers of Gmsh.

use super::error::Fault;
use crate::formats::mesh::raw::ElementKind;

/// The kind of a Gmsh type number.
pub(super) fn kind(number: i64) -> Result<ElementKind, Fault> {
    let (dimension, nodes) = match number {
        15 => (0, 1),
        1 => (1, 2),
        8 => (1, 3),
        2 => (2, 3),
        9 => (2, 6),
        4 => (3, 4),
        11 => (3, 10),
        other => return Err(Fault::UnsupportedElement(describe(other))),
    };
    Ok(ElementKind { dimension, nodes })
}

fn describe(number: i64) -> String {
    let name = match number {
        3 | 10 | 16 => "quadrangles",
        5 | 12 | 17 | 92 | 93 => "hexahedra",
        6 | 13 | 18 => "prisms",
        7 | 14 | 19 => "pyramids",
        20..=25 => "triangles of order three or more",
        26..=28 => "lines of order three or more",
        29..=31 => "tetrahedra of order three or more",
        _ => return format!("Gmsh element type {number}"),
    };
    format!("{name} (Gmsh element type {number})")
}
