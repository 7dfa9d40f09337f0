//! The pressures that the metric of contact knows apart: one of each connected part, and in
//! a thin body hats on a coarse grid,
//!
//! ```text
//! z_k(x) = prod_i max(0, 1 - |x_i - k_i d| / d)   over the long axes,   d = 2 t
//! ```
//!
//! t the thickness. Shapes `[pressures]`. What a thin bonded layer does under contact is to
//! press its volume sideways, with a pressure that varies along it on the scale of its
//! thickness: a constant knows nothing of it. As many as the body is long over its thickness, up
//! to where their Gram matrix costs. Cost: 8 numbers a vertex at most.

use std::collections::BTreeMap;

use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::mesh::Mesh;

/// Length over thickness from which on a body is thin: below, one pressure does.
const THIN: f64 = 6.0;
/// Spacing of the grid over the thickness.
const SPACING: f64 = 2.0;
/// Hats at most under contact: the factor of their Gram matrix takes a third of a Gflop and 4 MB.
const UNDER_CONTACT: usize = 1024;
/// The same without: as long waves do for the internal pressure, more are not worth their solves.
const ALONE: usize = 64;
/// Growth of the spacing where there would be more.
const GROWTH: f64 = 1.2;

/// The coarse pressures of a body.
#[derive(Clone, Debug)]
pub(crate) struct CoarsePressures {
    /// z `[modes, pressures]`.
    pub(crate) pressures: SparseRows,
    /// Whether there are hats among them.
    pub(crate) is_thin: bool,
}

impl CoarsePressures {
    /// Of `mesh`, whose vertices belong to `parts`, empty for one part, under contact with so many
    /// `multipliers`.
    pub(super) fn new(mesh: &Mesh, parts: &[u32], multipliers: u64) -> Self {
        let most = match multipliers {
            0 => ALONE,
            _ => UNDER_CONTACT,
        };
        let vertices = mesh.coordinates().len();
        let mut builder = SparseRowsBuilder::new(vertices);
        for part in 0..=parts.iter().max().copied().unwrap_or(0) {
            let is_own = |vertex: usize| parts.get(vertex).is_none_or(|&own| own == part);
            let own = (0..vertices).filter(|&vertex| is_own(vertex));
            let mut row: Hat = own.map(|vertex| (vertex as u32, 1.0)).collect();
            builder.push_row(&mut row);
        }
        let hats = stretches(mesh, most);
        let is_thin = !hats.is_empty();
        for mut hat in hats {
            builder.push_row(&mut hat);
        }
        Self {
            pressures: builder.finish(),
            is_thin,
        }
    }
}

/// Vertices, ascending, with the value of a hat there.
type Hat = Vec<(u32, f64)>;

/// The hats along a thin body; none for another.
fn stretches(mesh: &Mesh, most: usize) -> Vec<Hat> {
    let kind = mesh.cell_kind();
    let cells = 0..mesh.cell_count();
    let volume: f64 = cells
        .map(|cell| kind.signed_measure(&mesh.corners(cell)).abs())
        .sum();
    let (least, extents) = extents(mesh.coordinates());
    let mut sorted = extents;
    sorted.sort_by(|a, b| b.total_cmp(a));
    let thickness = volume / sorted[..kind.dimension() - 1].iter().product::<f64>();
    if sorted[0] < THIN * thickness {
        return Vec::new();
    }
    let mut spacing = SPACING * thickness;
    loop {
        let hats = hats(mesh.coordinates(), (least, extents), (spacing, most));
        if hats.len() <= most {
            return hats;
        }
        spacing *= GROWTH;
    }
}

/// Least coordinates and lengths of the box around points.
fn extents(coordinates: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        [0, 1, 2].map(|i| coordinates.iter().map(|x| x[i]).fold(start, pick))
    };
    let (least, most) = (
        fold(f64::INFINITY, f64::min),
        fold(f64::NEG_INFINITY, f64::max),
    );
    (least, [0, 1, 2].map(|i| most[i] - least[i]))
}

/// The hats of a grid that some vertex sees, in the order of their places.
fn hats(
    coordinates: &[[f64; 3]],
    (least, extents): ([f64; 3], [f64; 3]),
    (spacing, most): (f64, usize),
) -> Vec<Hat> {
    // Whole cells along every long axis; across a short one nothing changes.
    let cells = extents.map(|extent| {
        if extent >= 2.0 * spacing {
            (extent / spacing).round()
        } else {
            0.0
        }
    });
    let mut hats: BTreeMap<[u32; 3], Hat> = BTreeMap::new();
    for (vertex, x) in coordinates.iter().enumerate() {
        let along = [0, 1, 2].map(|i| {
            if cells[i] > 0.0 {
                cells[i] * (x[i] - least[i]) / extents[i]
            } else {
                0.0
            }
        });
        for corner in 0..8_u32 {
            let ends = [0, 1, 2].map(|i| along[i].floor() + f64::from(corner >> i & 1));
            let values = [0, 1, 2].map(|i| (1.0 - (along[i] - ends[i]).abs()).max(0.0));
            let value: f64 = values.iter().product();
            if value > 0.0 {
                let place = ends.map(|end| end as u32);
                hats.entry(place).or_default().push((vertex as u32, value));
            }
        }
        if hats.len() > most {
            break; // Too many whatever follows.
        }
    }
    hats.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::LinearOperator;
    use crate::mesh::samples::rectangle_parts;

    /// A strip of that length and unit height.
    fn strip(length: usize) -> Mesh {
        let mut parts = rectangle_parts(length, 1);
        let along = parts.coordinates.iter_mut();
        along.for_each(|x| x[0] *= length as f64);
        Mesh::new(parts).expect("a good mesh")
    }

    #[test]
    fn a_thick_body_has_one_pressure_and_a_thin_one_hats_that_sum_to_it() {
        assert_eq!(CoarsePressures::new(&strip(2), &[], 1).pressures.rows(), 1);
        let all = CoarsePressures::new(&strip(32), &[], 1).pressures;
        assert_eq!(all.rows(), 1 + 17);
        let mut left = vec![0.0; all.columns()];
        (0..all.rows())
            .for_each(|row| all.add_row(row, if row == 0 { 1.0 } else { -1.0 }, &mut left));
        assert!(left.iter().all(|left| left.abs() < 1e-14));
    }
}
