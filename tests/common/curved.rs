//! Meshes of round and of thin bodies: a triangulated surface in layers, each prism split
//! into three tetrahedra by the numbers of its vertices, so that neighbours fit.
//! All cells are straight-sided: the geometry itself converges with order two.

use std::collections::BTreeMap;

use signorini::{CellKind, Group, GroupKind, MeshParts};

/// A triangulated parameter plane.
pub(super) struct Sheet {
    pub(super) points: Vec<[f64; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The unit square of 2 `across` x `up` triangles.
pub(super) fn square(across: usize, up: usize) -> Sheet {
    let number = |i: usize, j: usize| (j * (across + 1) + i) as u32;
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for j in 0..=up {
        for i in 0..=across {
            points.push([i as f64 / across as f64, j as f64 / up as f64]);
            if i < across && j < up {
                let (low, far) = (number(i, j), number(i + 1, j + 1));
                triangles.push([low, number(i + 1, j), far]);
                triangles.push([low, far, number(i, j + 1)]);
            }
        }
    }
    Sheet { points, triangles }
}

/// The triangle a, b >= 0, a + b <= 1, each side in `count` parts.
fn triangle(count: usize) -> Sheet {
    let start = |row: usize| row * (count + 1) - row * row.saturating_sub(1) / 2;
    let number = |i: usize, row: usize| (start(row) + i) as u32;
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for row in 0..=count {
        for i in 0..=count - row {
            points.push([i as f64 / count as f64, row as f64 / count as f64]);
            if i + row < count {
                triangles.push([number(i, row), number(i + 1, row), number(i, row + 1)]);
            }
            if i + row + 1 < count {
                triangles.push([
                    number(i + 1, row),
                    number(i + 1, row + 1),
                    number(i, row + 1),
                ]);
            }
        }
    }
    Sheet { points, triangles }
}

/// The unit disc: ring k of `rings` has 6 k points.
fn disc(rings: usize) -> Sheet {
    let start = |ring: usize| {
        if ring == 0 {
            0
        } else {
            1 + 3 * ring * (ring - 1)
        }
    };
    let number = |ring: usize, i: usize| (start(ring) + i % (6 * ring).max(1)) as u32;
    let mut points = vec![[0.0; 2]];
    let mut triangles = Vec::new();
    for ring in 1..=rings {
        for i in 0..6 * ring {
            let angle = std::f64::consts::TAU * i as f64 / (6 * ring) as f64;
            let radius = ring as f64 / rings as f64;
            points.push([radius * angle.cos(), radius * angle.sin()]);
        }
        for sector in 0..6 {
            for i in 0..ring {
                let (outer, inner) = (sector * ring + i, sector * (ring - 1) + i);
                let [a, b] = [number(ring, outer), number(ring, outer + 1)];
                triangles.push([a, b, number(ring - 1, inner)]);
                if i + 1 < ring {
                    triangles.push([number(ring - 1, inner), b, number(ring - 1, inner + 1)]);
                }
            }
        }
    }
    Sheet { points, triangles }
}

/// `sheet` in `count` layers; `place` takes a point of the sheet and a height
/// from 0 to 1.
fn layered(
    sheet: &Sheet,
    count: usize,
    place: impl Fn([f64; 2], f64) -> [f64; 3],
) -> (Vec<[f64; 3]>, Vec<u32>) {
    let width = sheet.points.len() as u32;
    let height = |layer: usize| layer as f64 / count as f64;
    let points: Vec<[f64; 3]> = (0..=count)
        .flat_map(|layer| sheet.points.iter().map(move |&point| (point, layer)))
        .map(|(point, layer)| place(point, height(layer)))
        .collect();
    let mut cells = Vec::new();
    for layer in 0..count as u32 {
        for corners in &sheet.triangles {
            let mut low = corners.map(|v| v + layer * width);
            low.sort_unstable();
            let [a, b, c] = low;
            let [up_a, up_b, up_c] = low.map(|v| v + width);
            for mut cell in [[a, b, c, up_c], [a, b, up_b, up_c], [a, up_a, up_b, up_c]] {
                if volume(cell.map(|v| points[v as usize])) < 0.0 {
                    cell.swap(2, 3);
                }
                cells.extend(cell);
            }
        }
    }
    (points, cells)
}

fn volume([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    let [u, v, w] = [b, c, d].map(|end| [0, 1, 2].map(|i| end[i] - a[i]));
    let minor = |i: usize, j: usize| v[i] * w[j] - v[j] * w[i];
    u[0] * minor(1, 2) - u[1] * minor(0, 2) + u[2] * minor(0, 1)
}

/// A surface: its name and which points lie on it.
pub(super) type Surface<'a> = (&'a str, &'a dyn Fn([f64; 3]) -> bool);

/// The body of `cells`, with the boundary facets whose vertices all lie on a
/// surface in the group of that name; the first that fits takes a facet.
pub(super) fn body(
    cell_kind: CellKind,
    coordinates: Vec<[f64; 3]>,
    cells: Vec<u32>,
    surfaces: &[Surface<'_>],
) -> MeshParts {
    let mut seen: BTreeMap<Vec<u32>, (Vec<u32>, u32)> = BTreeMap::new();
    for cell in cells.chunks(cell_kind.vertices()) {
        for facet in cell_kind.facets() {
            let vertices: Vec<u32> = facet.iter().map(|&local| cell[local]).collect();
            let mut key = vertices.clone();
            key.sort_unstable();
            seen.entry(key).or_insert((vertices, 0)).1 += 1;
        }
    }
    let mut groups: Vec<Group> = surfaces
        .iter()
        .map(|(name, _)| group(name, GroupKind::Facets, Vec::new()))
        .collect();
    let mut facets = Vec::new();
    for (vertices, count) in seen.into_values() {
        let on = |surface: &Surface<'_>| {
            let mut all = vertices.iter();
            count == 1 && all.all(|&v| surface.1(coordinates[v as usize]))
        };
        if let Some(index) = surfaces.iter().position(on) {
            let number = (facets.len() / cell_kind.facet_vertices()) as u32;
            groups[index].members.push(number);
            facets.extend(vertices);
        }
    }
    let all = (0..(cells.len() / cell_kind.vertices()) as u32).collect();
    groups.push(group("body", GroupKind::Cells, all));
    MeshParts {
        cell_kind,
        coordinates,
        cells,
        facets,
        groups,
    }
}

fn group(name: &str, kind: GroupKind, members: Vec<u32>) -> Group {
    Group {
        name: name.to_owned(),
        kind,
        members,
    }
}

pub(super) fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 1e-9
}

/// A cylinder of radius one about the z axis, groups z0, z1, side.
pub(crate) fn cylinder(rings: usize, layers: usize, height: f64) -> MeshParts {
    let (points, cells) = layered(&disc(rings), layers, |[x, y], z| [x, y, height * z]);
    body(
        CellKind::Tetrahedron,
        points,
        cells,
        &[
            ("z0", &|x| near(x[2], 0.0)),
            ("z1", &|x| near(x[2], height)),
            ("side", &|_| true),
        ],
    )
}

/// An eighth of a thick sphere of radii 1 and 2, groups inner, outer, x0, y0, z0.
pub(crate) fn thick_sphere(count: usize, layers: usize) -> MeshParts {
    let size = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let place = |[a, b]: [f64; 2], height: f64| {
        let direction = [a, b, 1.0 - a - b].map(|x| (0.5 * std::f64::consts::PI * x).sin());
        direction.map(|x| (1.0 + height) * x / size(direction))
    };
    let (points, cells) = layered(&triangle(count), layers, place);
    body(
        CellKind::Tetrahedron,
        points,
        cells,
        &[
            ("inner", &|x| near(size(x), 1.0)),
            ("outer", &|x| near(size(x), 2.0)),
            ("x0", &|x| near(x[0], 0.0)),
            ("y0", &|x| near(x[1], 0.0)),
            ("z0", &|x| near(x[2], 0.0)),
        ],
    )
}

/// A slab over the z plane in equal boxes, groups x0 .. z1.
pub(crate) fn slab([across, deep, high]: [usize; 3], size: [f64; 3]) -> MeshParts {
    let place = |[x, y]: [f64; 2], z: f64| [size[0] * x, size[1] * y, size[2] * z];
    let (points, cells) = layered(&square(across, deep), high, place);
    body(
        CellKind::Tetrahedron,
        points,
        cells,
        &[
            ("x0", &|x| near(x[0], 0.0)),
            ("x1", &|x| near(x[0], size[0])),
            ("y0", &|x| near(x[1], 0.0)),
            ("y1", &|x| near(x[1], size[1])),
            ("z0", &|x| near(x[2], 0.0)),
            ("z1", &|x| near(x[2], size[2])),
        ],
    )
}

/// Point of a quarter ring of radii 1 and 2.
fn on_ring([along, across]: [f64; 2]) -> [f64; 2] {
    let (angle, radius) = (0.5 * std::f64::consts::PI * along, 1.0 + across);
    [radius * angle.cos(), radius * angle.sin()]
}

/// A quarter of a thick cylinder of radii 1 and 2, groups inner, outer, x0, y0,
/// z0, z1.
pub(crate) fn thick_cylinder(along: usize, across: usize, height: f64) -> MeshParts {
    let place = |point: [f64; 2], z: f64| {
        let [x, y] = on_ring(point);
        [x, y, height * z]
    };
    let (points, cells) = layered(&square(along, across), 1, place);
    body(
        CellKind::Tetrahedron,
        points,
        cells,
        &[
            ("z0", &|x| near(x[2], 0.0)),
            ("z1", &|x| near(x[2], height)),
            ("inner", &|x| near(x[0].hypot(x[1]), 1.0)),
            ("outer", &|x| near(x[0].hypot(x[1]), 2.0)),
            ("x0", &|x| near(x[0], 0.0)),
            ("y0", &|x| near(x[1], 0.0)),
        ],
    )
}

/// The section of [`thick_cylinder`], groups inner, outer, x0, y0.
pub(crate) fn quarter_ring(along: usize, across: usize) -> MeshParts {
    let sheet = square(along, across);
    let place = |&point: &[f64; 2]| {
        let [x, y] = on_ring(point);
        [x, y, 0.0]
    };
    // Seen from the other side: the angle runs against the radius.
    let turned = sheet.triangles.iter().flat_map(|&[a, b, c]| [a, c, b]);
    body(
        CellKind::Triangle,
        sheet.points.iter().map(place).collect(),
        turned.collect(),
        &[
            ("inner", &|x| near(x[0].hypot(x[1]), 1.0)),
            ("outer", &|x| near(x[0].hypot(x[1]), 2.0)),
            ("x0", &|x| near(x[0], 0.0)),
            ("y0", &|x| near(x[1], 0.0)),
        ],
    )
}
