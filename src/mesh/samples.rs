//! Structured meshes for tests: the unit cube and the unit square, with their
//! sides as groups `x0`, `x1`, … and all cells as `body`.

use super::{CellKind, Group, GroupKind, Mesh, MeshParts};

/// Vertex paths of the six Kuhn tetrahedra of a cube, as axes to step along.
const PATHS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// `count`³ cubes of six tetrahedra each.
pub(crate) fn cube(count: usize) -> Mesh {
    Mesh::new(cube_parts(count)).expect("a valid sample")
}

/// Arrays of [`cube`].
pub(crate) fn cube_parts(count: usize) -> MeshParts {
    let side = count + 1;
    let number = |[x, y, z]: [usize; 3]| ((z * side + y) * side + x) as u32;
    let mut cells = Vec::new();
    for corner in lattice([count; 3]) {
        for (path, axes) in PATHS.iter().enumerate() {
            let mut place = corner;
            let mut cell = vec![number(place)];
            for &axis in axes {
                place[axis] += 1;
                cell.push(number(place));
            }
            if path >= 3 {
                // Odd paths turn the other way.
                cell.swap(2, 3);
            }
            cells.extend(cell);
        }
    }
    let points = lattice([side; 3]);
    let coordinates: Vec<_> = points
        .map(|place| place.map(|step| step as f64 / count as f64))
        .collect();
    with_sides(CellKind::Tetrahedron, coordinates, cells)
}

/// The unit square cut into `across` × `up` rectangles of two triangles.
pub(crate) fn rectangle(across: usize, up: usize) -> Mesh {
    Mesh::new(rectangle_parts(across, up)).expect("a valid sample")
}

/// Arrays of [`rectangle`].
pub(crate) fn rectangle_parts(across: usize, up: usize) -> MeshParts {
    let number = |x: usize, y: usize| (y * (across + 1) + x) as u32;
    let mut cells = Vec::new();
    for [x, y, _] in lattice([across, up, 1]) {
        let (low, right) = (number(x, y), number(x + 1, y));
        let (top, far) = (number(x, y + 1), number(x + 1, y + 1));
        cells.extend([low, right, far, low, far, top]);
    }
    let points = lattice([across + 1, up + 1, 1]);
    let place = |[x, y, _]: [usize; 3]| [x as f64 / across as f64, y as f64 / up as f64, 0.0];
    with_sides(CellKind::Triangle, points.map(place).collect(), cells)
}

fn lattice(shape: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let count = shape[0] * shape[1] * shape[2];
    (0..count).map(move |index| {
        [
            index % shape[0],
            index / shape[0] % shape[1],
            index / (shape[0] * shape[1]),
        ]
    })
}

fn with_sides(kind: CellKind, coordinates: Vec<[f64; 3]>, cells: Vec<u32>) -> MeshParts {
    let cell_count = (cells.len() / kind.vertices()) as u32;
    let mut facets = Vec::new();
    let mut groups = vec![Group {
        name: "body".to_owned(),
        kind: GroupKind::Cells,
        members: (0..cell_count).collect(),
    }];
    for axis in 0..kind.dimension() {
        for end in [0_u8, 1] {
            let first = facets.len() / kind.facet_vertices();
            let on_side =
                |vertex: u32| (coordinates[vertex as usize][axis] - f64::from(end)).abs() < 1e-12;
            for cell in cells.chunks(kind.vertices()) {
                for facet in kind.facets() {
                    if facet.iter().all(|&local| on_side(cell[local])) {
                        facets.extend(facet.iter().map(|&local| cell[local]));
                    }
                }
            }
            let last = facets.len() / kind.facet_vertices();
            groups.push(Group {
                name: format!("{}{end}", ["x", "y", "z"][axis]),
                kind: GroupKind::Facets,
                members: (first as u32..last as u32).collect(),
            });
        }
    }
    MeshParts {
        cell_kind: kind,
        coordinates,
        cells,
        facets,
        groups,
    }
}
