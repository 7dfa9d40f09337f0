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
        3 => (2, 4),
        16 => (2, 8),
        10 => (2, 9),
        7 => (3, 5),
        19 => (3, 13),
        14 => (3, 14),
        6 => (3, 6),
        18 => (3, 15),
        13 => (3, 18),
        5 => (3, 8),
        17 => (3, 20),
        12 => (3, 27),
        other => return Err(Fault::UnsupportedElement(describe(other))),
    };
    Ok(ElementKind { dimension, nodes })
}

/// Where Gmsh has the nodes of cells, in the order of [`crate::formats::mesh`].
fn order(kind: ElementKind) -> &'static [usize] {
    const PYRAMID: &[usize] = &[0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13];
    const WEDGE: &[usize] = &[0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16];
    const HEXAHEDRON: &[usize] = &[
        0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20,
        25, 26,
    ];
    match (kind.dimension, kind.nodes) {
        (3, 13 | 14) => PYRAMID,
        (3, 15 | 18) => WEDGE,
        (3, 20 | 27) => HEXAHEDRON,
        _ => &[],
    }
}

/// Brings the nodes of elements of one kind from the order of Gmsh to that of meshes here.
pub(super) fn reorder(kind: ElementKind, nodes: &mut [u64]) {
    let order = order(kind);
    if order.is_empty() {
        return;
    }
    for element in nodes.chunks_exact_mut(kind.nodes) {
        let of_gmsh = element.to_vec();
        for (slot, at) in element.iter_mut().zip(order) {
            *slot = of_gmsh.get(*at).copied().unwrap_or(*slot);
        }
    }
}

fn describe(number: i64) -> String {
    let name = match number {
        36..=41 => "quadrangles of order three or more",
        92 | 93 => "hexahedra of order three or more",
        90 | 91 => "prisms of order three or more",
        118.. => "pyramids of order three or more",
        20..=25 => "triangles of order three or more",
        26..=28 => "lines of order three or more",
        29..=31 => "tetrahedra of order three or more",
        _ => return format!("Gmsh element type {number}"),
    };
    format!("{name} (Gmsh element type {number})")
}
