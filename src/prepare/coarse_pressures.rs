//! The pressures that the metric of contact knows apart: one of each connected part, and in
//! a thin body hats on a coarse grid,
//!
//! ```text
//! z_k(x) = prod_i max(0, 1 - |x_i - k_i d| / d)   over the long axes,   d = 2 t
//! ```
//!
//! t the thickness. Shapes `[pressures]`. What a thin bonded layer does under contact is to
//! press its volume sideways, with a pressure that varies along it on the scale of its
//! thickness: a constant knows nothing of it. Cost: 64 vectors at most.

use std::collections::BTreeMap;

use crate::mesh::Mesh;

/// Length over thickness from which on a body is thin: below, one pressure does.
const THIN: f64 = 6.0;
/// Spacing of the grid over the thickness.
const SPACING: f64 = 2.0;
/// Hats at most.
const MOST: usize = 64;
/// Growth of the spacing where there would be more.
const GROWTH: f64 = 1.2;

/// The coarse pressures of a body.
#[derive(Debug)]
pub(crate) struct CoarsePressures {
    /// z `[modes][pressures]`.
    pub(crate) pressures: Vec<Vec<f64>>,
    /// Whether there are hats among them.
    pub(crate) is_thin: bool,
}

impl CoarsePressures {
    /// Of `mesh`, whose vertices belong to `parts`, empty for one part.
    pub(super) fn new(mesh: &Mesh, parts: &[u32]) -> Self {
        let mut pressures = of_parts(mesh.coordinates().len(), parts);
        let hats = stretches(mesh);
        let is_thin = !hats.is_empty();
        pressures.extend(hats);
        Self { pressures, is_thin }
    }
}

/// One for each part.
fn of_parts(vertices: usize, parts: &[u32]) -> Vec<Vec<f64>> {
    let last = parts.iter().max().map_or(0, |&last| last);
    let of_part = |part: u32| {
        let is_own = |vertex: usize| parts.get(vertex).is_none_or(|&own| own == part);
        let ones = (0..vertices).map(|vertex| f64::from(u8::from(is_own(vertex))));
        ones.collect()
    };
    (0..=last).map(of_part).collect()
}

/// The hats along a thin body; none for another.
fn stretches(mesh: &Mesh) -> Vec<Vec<f64>> {
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
        let hats = hats(mesh.coordinates(), (least, extents), spacing);
        if hats.len() <= MOST {
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
    spacing: f64,
) -> Vec<Vec<f64>> {
    // Whole cells along every long axis; across a short one nothing changes.
    let cells = extents.map(|extent| match extent >= 2.0 * spacing {
        true => (extent / spacing).round(),
        false => 0.0,
    });
    let mut hats: BTreeMap<[u32; 3], Vec<f64>> = BTreeMap::new();
    for (vertex, x) in coordinates.iter().enumerate() {
        let along = [0, 1, 2].map(|i| match cells[i] > 0.0 {
            true => cells[i] * (x[i] - least[i]) / extents[i],
            false => 0.0,
        });
        for corner in 0..8_u32 {
            let ends = [0, 1, 2].map(|i| along[i].floor() + f64::from(corner >> i & 1));
            let values = [0, 1, 2].map(|i| (1.0 - (along[i] - ends[i]).abs()).max(0.0));
            let value: f64 = values.iter().product();
            if value > 0.0 {
                let place = ends.map(|end| end as u32);
                let hat = hats
                    .entry(place)
                    .or_insert_with(|| vec![0.0; coordinates.len()]);
                hat[vertex] = value;
            }
        }
        if hats.len() > MOST {
            break; // Too many whatever follows.
        }
    }
    hats.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
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
        assert_eq!(CoarsePressures::new(&strip(2), &[]).pressures.len(), 1);
        let all = CoarsePressures::new(&strip(32), &[]).pressures;
        assert_eq!(all.len(), 1 + 17);
        for (vertex, one) in all[0].iter().enumerate() {
            let sum: f64 = all[1..].iter().map(|hat| hat[vertex]).sum();
            assert!((sum - one).abs() < 1e-14);
        }
    }
}
