//! Offsets that put the middles of edges on a circle, a cylinder or a sphere, as meshes
//! of second order have them, and the quarter of a disc.

use std::collections::BTreeMap;

use signorini::{EdgeOffset, MeshParts};

use super::curved::{body, near, square};

/// Offsets of the edges for which `middle` knows a place, given their ends.
pub(crate) fn offsets(
    parts: &MeshParts,
    middle: impl Fn([[f64; 3]; 2]) -> Option<[f64; 3]>,
) -> Vec<EdgeOffset> {
    let mut found = BTreeMap::new();
    for cell in parts.cells.chunks(parts.cell_kind.vertices()) {
        for &(a, b) in parts.cell_kind.edges() {
            let ends = [cell[a].min(cell[b]), cell[a].max(cell[b])];
            let places = ends.map(|end| parts.coordinates[end as usize]);
            if let Some(place) = middle(places) {
                let mean = [0, 1, 2].map(|i| 0.5 * (places[0][i] + places[1][i]));
                found.insert(ends, [0, 1, 2].map(|i| place[i] - mean[i]));
            }
        }
    }
    let offsets = found.into_iter();
    offsets
        .map(|(ends, offset)| EdgeOffset { ends, offset })
        .collect()
}

/// Offsets that put edges between points at a distance of `radius` from the origin
/// there; of the first `axes` coordinates only.
pub(crate) fn round(parts: &MeshParts, radius: f64, axes: usize) -> Vec<EdgeOffset> {
    let size = |x: [f64; 3]| x[..axes].iter().map(|x| x * x).sum::<f64>().sqrt();
    offsets(parts, |ends| {
        let mut place = [0, 1, 2].map(|i| 0.5 * (ends[0][i] + ends[1][i]));
        let factor = radius / size(place);
        place[..axes].iter_mut().for_each(|x| *x *= factor);
        ends.iter()
            .all(|&end| near(size(end), radius))
            .then_some(place)
    })
}

/// Both lists as one.
pub(crate) fn together(mut first: Vec<EdgeOffset>, second: Vec<EdgeOffset>) -> Vec<EdgeOffset> {
    first.extend(second);
    first.sort_by_key(|one| one.ends);
    first
}

/// A quarter of the unit disc with 2 `count` facets, groups rim, x0, y0.
pub(crate) fn quarter_disc(count: usize) -> MeshParts {
    let sheet = square(count, count);
    let place = |&[x, y]: &[f64; 2]| {
        let (x, y) = (
            (0.25 * std::f64::consts::PI * x).tan(),
            (0.25 * std::f64::consts::PI * y).tan(),
        );
        let size = x.max(y) / x.hypot(y).max(1e-300);
        let blend = x.max(y);
        // Rings of squares within, of circles at the rim.
        let factor = 1.0 - blend + blend * size;
        [x * factor, y * factor, 0.0]
    };
    body(
        signorini::CellKind::Triangle,
        sheet.points.iter().map(place).collect(),
        sheet.triangles.iter().flatten().copied().collect(),
        &[
            ("x0", &|x| near(x[0], 0.0)),
            ("y0", &|x| near(x[1], 0.0)),
            ("rim", &|x| near(x[0].hypot(x[1]), 1.0)),
        ],
    )
}

/// A ring of radii 1 and 2, its ends joined, groups inner, outer.
pub(crate) fn whole_ring(along: usize, across: usize) -> MeshParts {
    let number = |i: usize, j: usize| ((i % along) * (across + 1) + j) as u32;
    let mut points = Vec::new();
    let mut cells = Vec::new();
    for i in 0..along {
        let angle = std::f64::consts::TAU * i as f64 / along as f64;
        for j in 0..=across {
            let radius = 1.0 + j as f64 / across as f64;
            points.push([radius * angle.cos(), radius * angle.sin(), 0.0]);
            if j < across {
                let (low, far) = (number(i, j), number(i + 1, j + 1));
                cells.extend([low, number(i, j + 1), far, low, far, number(i + 1, j)]);
            }
        }
    }
    body(
        signorini::CellKind::Triangle,
        points,
        cells,
        &[
            ("inner", &|x| near(x[0].hypot(x[1]), 1.0)),
            ("outer", &|x| near(x[0].hypot(x[1]), 2.0)),
        ],
    )
}
