//! Meshes of the stories: structured ones by rule, irregular ones by moving
//! their vertices by a fixed pattern, and Gmsh files from `tests/meshes`.

use std::path::Path;
use std::sync::Arc;

use signorini::{CellKind, Group, GroupKind, Mesh, MeshParts};

/// Paths of the six Kuhn tetrahedra of a cube: axes to step along.
const PATHS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// Largest move of a vertex of an irregular mesh, in cell sizes.
const MOVE: f64 = 0.12;

/// A mesh of arrays that are known to be valid.
pub(crate) fn mesh(parts: MeshParts) -> Arc<Mesh> {
    Arc::new(Mesh::new(parts).expect("a valid mesh"))
}

/// The unit cube of `count`^3 cubes of six tetrahedra, groups x0 .. z1, body.
pub(crate) fn cube(count: usize) -> MeshParts {
    unit_box([count; 3])
}

/// The unit cube of `counts` boxes of six tetrahedra along its axes, groups x0 .. z1, body.
pub(crate) fn unit_box(counts: [usize; 3]) -> MeshParts {
    let sides = counts.map(|count| count + 1);
    let number = |[x, y, z]: [usize; 3]| ((z * sides[1] + y) * sides[0] + x) as u32;
    let mut cells = Vec::new();
    for corner in lattice(counts) {
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
    let place = |point: [usize; 3]| [0, 1, 2].map(|i| point[i] as f64 / counts[i] as f64);
    let points = lattice(sides).map(place).collect();
    with_sides(CellKind::Tetrahedron, points, cells)
}

/// The plane ring from radius `inner` to one, two triangles for each of `around` by `layers`
/// cells, groups rim and tread.
pub(crate) fn ring(around: usize, layers: usize, inner: f64) -> MeshParts {
    let number = |step: usize, layer: usize| (layer * around + step % around) as u32;
    let mut cells = Vec::new();
    for [step, layer, _] in lattice([around, layers, 1]) {
        let [near, beside] = [step, step + 1].map(|step| number(step, layer));
        let [above, far] = [step, step + 1].map(|step| number(step, layer + 1));
        cells.extend([near, far, beside, near, above, far]);
    }
    let place = |[step, layer, _]: [usize; 3]| {
        let angle = std::f64::consts::TAU * step as f64 / around as f64;
        let radius = inner + (1.0 - inner) * layer as f64 / layers as f64;
        [radius * angle.sin(), -radius * angle.cos(), 0.0]
    };
    let coordinates = lattice([around, layers + 1, 1]).map(place).collect();
    let side = |layer: usize| (0..around).map(move |step| [step, step + 1].map(|s| (s, layer)));
    let facets = [side(0), side(layers)].into_iter().flatten().flatten();
    let facets = facets.map(|(step, layer)| number(step, layer)).collect();
    let group = |name: &str, kind, members: std::ops::Range<usize>| Group {
        name: name.to_owned(),
        kind,
        members: members.map(|member| member as u32).collect(),
    };
    MeshParts {
        cell_kind: CellKind::Triangle,
        coordinates,
        groups: vec![
            group("body", GroupKind::Cells, 0..cells.len() / 3),
            group("rim", GroupKind::Facets, 0..around),
            group("tread", GroupKind::Facets, around..2 * around),
        ],
        cells,
        facets,
    }
}

/// `parts` with the facets of `on` whose vertices are all `inside` in a group of their own.
pub(crate) fn with_pad(
    mut parts: MeshParts,
    (name, on): (&str, &str),
    inside: impl Fn([f64; 3]) -> bool,
) -> MeshParts {
    let width = parts.cell_kind.facet_vertices();
    let side = parts.groups.iter().find(|group| group.name == on);
    let members = side.expect("a side").members.iter().copied();
    let is_inside = |facet: &u32| {
        let first = width * *facet as usize;
        let mut vertices = parts.facets[first..first + width].iter();
        vertices.all(|&v| inside(parts.coordinates[v as usize]))
    };
    let members = members.filter(is_inside).collect();
    parts.groups.push(Group {
        name: name.to_owned(),
        kind: GroupKind::Facets,
        members,
    });
    parts
}

/// What stands for the half-space below the last axis: `count` cells from the origin to each
/// side (to one side only along the axes of `half`) and down, a body of half width one whose cells
/// shrink towards the origin by the hyperbolic sine of `grading` times the largest coordinate.
pub(crate) fn half_space(
    dimension: usize,
    count: usize,
    grading: f64,
    half: &[usize],
) -> MeshParts {
    let is_half = |axis: usize| axis + 1 == dimension || half.contains(&axis);
    let counts = [0, 1, 2].map(|axis| match is_half(axis) {
        true => count,
        false => 2 * count,
    });
    let unit = match dimension {
        2 => unit_grid(counts[0], counts[1]),
        _ => unit_box(counts),
    };
    moved(unit, |point| {
        let mut place = [0.0; 3];
        for axis in 0..dimension {
            place[axis] = match is_half(axis) {
                _ if axis + 1 == dimension => point[axis] - 1.0,
                true => point[axis],
                false => 2.0 * point[axis] - 1.0,
            };
        }
        let far = place.iter().fold(0.0, |far: f64, x| far.max(x.abs()));
        let size = match far > 0.0 {
            true => (grading * far).sinh() / grading.sinh() / far,
            false => 0.0,
        };
        place.map(|x| size * x)
    })
}

/// The unit square of 2 `count`^2 triangles, groups x0 x1 y0 y1, body.
pub(crate) fn square(count: usize) -> MeshParts {
    unit_grid(count, count)
}

/// The unit square of 2 `across` * `up` triangles, groups x0 x1 y0 y1, body.
pub(crate) fn unit_grid(across: usize, up: usize) -> MeshParts {
    let number = |x: usize, y: usize| (y * (across + 1) + x) as u32;
    let mut cells = Vec::new();
    for [x, y, _] in lattice([across, up, 1]) {
        let (low, right) = (number(x, y), number(x + 1, y));
        let (top, far) = (number(x, y + 1), number(x + 1, y + 1));
        cells.extend([low, right, far, low, far, top]);
    }
    let place = |[x, y, _]: [usize; 3]| [x as f64 / across as f64, y as f64 / up as f64, 0.0];
    let points = lattice([across + 1, up + 1, 1]).map(place).collect();
    with_sides(CellKind::Triangle, points, cells)
}

/// The unit square of `count`^2 squares with both diagonals, groups x0 x1 y0 y1, body.
pub(crate) fn crossed(count: usize) -> MeshParts {
    let number = |x: usize, y: usize| (y * (count + 1) + x) as u32;
    let place = |x: f64, y: f64| [x / count as f64, y / count as f64, 0.0];
    let corners = lattice([count + 1, count + 1, 1]);
    let mut points: Vec<_> = corners.map(|[x, y, _]| place(x as f64, y as f64)).collect();
    let mut cells = Vec::new();
    for [x, y, _] in lattice([count, count, 1]) {
        let middle = points.len() as u32;
        points.push(place(x as f64 + 0.5, y as f64 + 0.5));
        let around = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)];
        let around = around.map(|(right, up)| number(x + right, y + up));
        for side in around.windows(2) {
            cells.extend([side[0], side[1], middle]);
        }
    }
    with_sides(CellKind::Triangle, points, cells)
}

/// Cook's membrane: the square on the corners (0,0) (48,44) (48,60) (0,44).
pub(crate) fn cook(count: usize) -> MeshParts {
    tapered(square(count))
}

/// [`cook`] with the other diagonals: the square is seen from behind.
pub(crate) fn cook_turned(count: usize) -> MeshParts {
    let mut behind = moved(square(count), |[x, y, z]| [1.0 - x, y, z]);
    behind.cells.chunks_mut(3).for_each(|cell| cell.swap(1, 2));
    for group in &mut behind.groups {
        group.name = match group.name.as_str() {
            "x0" => "x1".to_owned(),
            "x1" => "x0".to_owned(),
            other => other.to_owned(),
        };
    }
    tapered(behind)
}

fn tapered(unit_square: MeshParts) -> MeshParts {
    moved(unit_square, |[x, y, _]| {
        let (bottom, height) = (44.0 * x, 44.0 - 28.0 * x);
        [48.0 * x, bottom + y * height, 0.0]
    })
}

/// `parts` with its inner vertices, and those of its plane sides within their
/// planes, moved by a fixed pattern.
pub(crate) fn irregular(mut parts: MeshParts, count: usize) -> MeshParts {
    let dimension = parts.cell_kind.dimension();
    let mut state = 1_u64;
    for point in &mut parts.coordinates {
        for component in &mut point[..dimension] {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let noise = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
            if *component > 1e-9 && *component < 1.0 - 1e-9 {
                *component += MOVE * noise / count as f64;
            }
        }
    }
    parts
}

/// Some bodies as one mesh; the groups of each have their names with its prefix.
pub(crate) fn joined(bodies: &[(&str, MeshParts)]) -> MeshParts {
    let mut all = MeshParts {
        coordinates: Vec::new(),
        cells: Vec::new(),
        facets: Vec::new(),
        groups: Vec::new(),
        ..bodies[0].1.clone()
    };
    for (prefix, own) in bodies {
        let first = all.coordinates.len() as u32;
        let kind = own.cell_kind;
        let cells = (all.cells.len() / kind.vertices()) as u32;
        let facets = (all.facets.len() / kind.facet_vertices()) as u32;
        all.coordinates.extend(&own.coordinates);
        all.cells.extend(own.cells.iter().map(|v| v + first));
        all.facets.extend(own.facets.iter().map(|v| v + first));
        let named = |group: &Group| {
            let by = match group.kind {
                GroupKind::Cells => cells,
                GroupKind::Facets => facets,
            };
            Group {
                name: format!("{prefix}{}", group.name),
                kind: group.kind,
                members: group.members.iter().map(|member| member + by).collect(),
            }
        };
        all.groups.extend(own.groups.iter().map(named));
    }
    all
}

/// `parts` with every vertex moved by `motion`.
pub(crate) fn moved(mut parts: MeshParts, motion: impl Fn([f64; 3]) -> [f64; 3]) -> MeshParts {
    for point in &mut parts.coordinates {
        *point = motion(*point);
    }
    parts
}

/// The unit cube with its inner vertices moved at random by up to 0.6 cell
/// sizes, less where a cell would turn over: slivers of mean ratio 1e-2.
pub(crate) fn slivers(count: usize) -> MeshParts {
    let straight = cube(count);
    let size = 1.0 / count as f64;
    let mut moves = irregular(straight.clone(), count).coordinates;
    for (moved, point) in moves.iter_mut().zip(&straight.coordinates) {
        let is_inner = point.iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9);
        let factor = if is_inner { 0.6 / MOVE } else { 0.0 };
        *moved = std::array::from_fn(|i| factor * (moved[i] - point[i]));
    }
    loop {
        let mut parts = straight.clone();
        for (point, by) in parts.coordinates.iter_mut().zip(&moves) {
            *point = std::array::from_fn(|i| point[i] + by[i]);
        }
        let is_thin = |cell: &&[u32]| volume(&parts, cell) <= 3e-5 / 6.0 * size.powi(3);
        let thin: Vec<u32> = parts
            .cells
            .chunks(4)
            .filter(is_thin)
            .flatten()
            .copied()
            .collect();
        if thin.is_empty() {
            return parts;
        }
        for vertex in thin {
            moves[vertex as usize] = moves[vertex as usize].map(|by| 0.7 * by);
        }
    }
}

fn volume(parts: &MeshParts, cell: &[u32]) -> f64 {
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| parts.coordinates[cell[k] as usize]);
    let edge = |point: [f64; 3]| [0, 1, 2].map(|i| point[i] - a[i]);
    let (u, v, w) = (edge(b), edge(c), edge(d));
    let minor = |i: usize, j: usize| v[i] * w[j] - v[j] * w[i];
    (u[0] * minor(1, 2) - u[1] * minor(0, 2) + u[2] * minor(0, 1)) / 6.0
}

/// `parts` with the cells whose centre is `inside` in a group of their own.
pub(crate) fn with_inclusion(
    mut parts: MeshParts,
    name: &str,
    inside: impl Fn([f64; 3]) -> bool,
) -> MeshParts {
    let centre = |&cell: &u32| -> [f64; 3] {
        let corners = &parts.cells[4 * cell as usize..4 * cell as usize + 4];
        let sum = |i: usize| {
            corners
                .iter()
                .map(|&v| parts.coordinates[v as usize][i])
                .sum::<f64>()
        };
        [0, 1, 2].map(|i| sum(i) / 4.0)
    };
    let all = std::mem::take(&mut parts.groups[0].members);
    let (members, rest) = all.into_iter().partition(|cell| inside(centre(cell)));
    parts.groups[0].members = rest;
    parts.groups.push(Group {
        name: name.to_owned(),
        kind: GroupKind::Cells,
        members,
    });
    parts
}

/// A Gmsh file of `tests/meshes`.
pub(crate) fn file(name: &str) -> Arc<Mesh> {
    mesh(file_parts(name))
}

/// Arrays of [`file`].
pub(crate) fn file_parts(name: &str) -> MeshParts {
    // Stories of other crates read the same files.
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut meshes = folders.map(|folder| folder.join("tests/meshes"));
    let folder = meshes.find(|folder| folder.is_dir());
    let folder = folder.expect("the meshes of the repository");
    parts_of(&format!("{}/{name}.msh", folder.display()))
}

/// A mesh of second order in the folder of the stories' meshes.
pub(crate) fn curved_file(name: &str) -> Arc<Mesh> {
    curved_file_placed(name, |parts| parts)
}

/// The same with its vertices moved; edges keep what they are off the means of their ends.
pub(crate) fn curved_file_placed(name: &str, place: impl Fn(MeshParts) -> MeshParts) -> Arc<Mesh> {
    let folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut meshes = folders.map(|folder| folder.join("tests/meshes"));
    let folder = meshes.find(|folder| folder.is_dir()).expect("meshes");
    let path = folder.join(format!("{name}.msh"));
    let bytes = std::fs::read(&path).expect("a mesh file of the repository");
    let file = signorini_client::formats::msh::read(&bytes).expect("a valid mesh file");
    let offsets = file.curved.iter().map(|edge| signorini::EdgeOffset {
        ends: edge.ends,
        offset: edge.offset,
    });
    let offsets = offsets.collect();
    let path = path.to_str().expect("a path of plain letters");
    Arc::new(Mesh::second_order(place(parts_of(path)), offsets).expect("a valid mesh"))
}

/// Arrays of the Gmsh file at `path`.
pub(crate) fn parts_of(path: &str) -> MeshParts {
    let bytes = std::fs::read(path).expect("a mesh file of the repository");
    let file = signorini_client::formats::msh::read(&bytes).expect("a valid mesh file");
    let cell_kind = match file.vertices_per_cell {
        3 => CellKind::Triangle,
        _ => CellKind::Tetrahedron,
    };
    let group = |group: signorini_client::formats::msh::MeshGroup| Group {
        name: group.name,
        kind: match group.dimension == cell_kind.dimension() {
            true => GroupKind::Cells,
            false => GroupKind::Facets,
        },
        members: group.members,
    };
    MeshParts {
        cell_kind,
        coordinates: file.coordinates,
        cells: file.cells,
        facets: file.facets,
        groups: file.groups.into_iter().map(group).collect(),
    }
}

fn lattice(shape: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [across, up, deep] = shape;
    (0..across * up * deep).map(move |i| [i % across, i / across % up, i / (across * up)])
}

fn with_sides(cell_kind: CellKind, coordinates: Vec<[f64; 3]>, cells: Vec<u32>) -> MeshParts {
    let body = (0..(cells.len() / cell_kind.vertices()) as u32).collect();
    let mut parts = MeshParts {
        cell_kind,
        coordinates,
        cells,
        facets: Vec::new(),
        groups: vec![Group {
            name: "body".to_owned(),
            kind: GroupKind::Cells,
            members: body,
        }],
    };
    for axis in 0..cell_kind.dimension() {
        for end in [0_u8, 1] {
            add_side(&mut parts, axis, end);
        }
    }
    parts
}

fn add_side(parts: &mut MeshParts, axis: usize, end: u8) {
    let width = parts.cell_kind.facet_vertices();
    let first = parts.facets.len() / width;
    for cell in parts.cells.chunks(parts.cell_kind.vertices()) {
        for facet in parts.cell_kind.facets() {
            let vertices = facet.iter().map(|&local| cell[local]);
            let on_side =
                |v: u32| (parts.coordinates[v as usize][axis] - f64::from(end)).abs() < 1e-12;
            if vertices.clone().all(on_side) {
                parts.facets.extend(vertices);
            }
        }
    }
    parts.groups.push(Group {
        name: format!("{}{end}", ["x", "y", "z"][axis]),
        kind: GroupKind::Facets,
        members: (first as u32..(parts.facets.len() / width) as u32).collect(),
    });
}

/// The same mesh with a group of the facets of `on` whose middles `is_in`.
pub(crate) fn with_group(
    mut parts: MeshParts,
    on: &str,
    name: &str,
    is_in: impl Fn([f64; 3]) -> bool,
) -> MeshParts {
    let width = parts.cell_kind.facet_vertices();
    let members = parts.groups.iter().find(|group| group.name == on);
    let members = members.expect("a group").members.iter().copied();
    let middle = |facet: u32| {
        let corners = &parts.facets[facet as usize * width..][..width];
        let sum = corners.iter().fold([0.0; 3], |sum, &v| {
            let x = parts.coordinates[v as usize];
            [0, 1, 2].map(|i| sum[i] + x[i] / width as f64)
        });
        is_in(sum)
    };
    let members = members.filter(|&facet| middle(facet)).collect();
    parts.groups.push(Group {
        name: name.to_owned(),
        kind: GroupKind::Facets,
        members,
    });
    parts
}
