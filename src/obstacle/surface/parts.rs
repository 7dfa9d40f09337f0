//! Parts of a surface that are not joined by an edge, and the solid that they bound together: what
//! lies in any of them, whether they cross, nest or touch.
//!
//! ```text
//! d(x) = min over the solids of d_k(x)
//! ```
//!
//! A part that is seen from inside is a hole of the least part around it, found by its winding
//! number; both are one solid. Where x lies outside of all solids its nearest point is one of their union; inside it
//! the zero set is that of the union, and the depth is exact to where another solid ends.
//! Solids whose boxes lie apart share one search. Cost: a union of neighbours; the winding
//! number of each hole in each part around it.

use std::f64::consts::TAU;

use super::topology::Facets;
use super::{SurfaceError, bounds};
use crate::geometry::vector3::{cross, dot, norm, sub};

/// A part: its facets, ascending, six times its volume, and its box.
struct Part {
    facets: Vec<u32>,
    volume: f64,
    low: [f64; 3],
    high: [f64; 3],
}

impl Part {
    fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }
}

/// The facets of each layer, ascending: solids of one layer lie apart.
///
/// # Errors
/// A part that is seen from inside, and lies in no other.
pub(super) fn layers(
    vertices: &[[f64; 3]],
    linked: &Facets,
) -> Result<Vec<Vec<u32>>, SurfaceError> {
    let parts = parts(vertices, linked);
    let (mut solids, holes): (Vec<Part>, Vec<Part>) =
        parts.into_iter().partition(|part| part.volume > 0.0);
    if let [_] = solids[..] {
        return Ok(vec![(0..linked.corners.len() as u32).collect()]);
    }
    for hole in holes {
        let first = hole.facets[0];
        let at = vertices[linked.corners[first as usize][0] as usize];
        let around = solids
            .iter_mut()
            .filter(|solid| solid.meets(&hole) && winding(vertices, (linked, solid), at) > 0.5);
        match around.min_by(|a, b| a.volume.total_cmp(&b.volume)) {
            Some(solid) => solid.facets.extend(hole.facets),
            None => {
                return Err(SurfaceError::InsideOutPart {
                    facet: first as usize,
                });
            }
        }
    }
    let mut layers: Vec<Vec<Part>> = Vec::new();
    for solid in solids {
        let is_apart = |layer: &&mut Vec<Part>| layer.iter().all(|other| !other.meets(&solid));
        match layers.iter_mut().find(is_apart) {
            Some(layer) => layer.push(solid),
            None => layers.push(vec![solid]),
        }
    }
    let in_order = |layer: Vec<Part>| {
        let mut facets: Vec<u32> = layer.into_iter().flat_map(|part| part.facets).collect();
        facets.sort_unstable();
        facets
    };
    Ok(layers.into_iter().map(in_order).collect())
}

/// All parts, in the order of their first facets.
fn parts(vertices: &[[f64; 3]], linked: &Facets) -> Vec<Part> {
    let mut is_seen = vec![false; linked.corners.len()];
    let mut all = Vec::new();
    for first in 0..linked.corners.len() {
        if is_seen[first] {
            continue;
        }
        is_seen[first] = true;
        let mut facets = vec![first as u32];
        let mut next = 0;
        while let Some(&facet) = facets.get(next) {
            next += 1;
            for other in linked.across[facet as usize] {
                if !std::mem::replace(&mut is_seen[other as usize], true) {
                    facets.push(other);
                }
            }
        }
        facets.sort_unstable();
        all.push(part(vertices, linked, facets));
    }
    all
}

fn part(vertices: &[[f64; 3]], linked: &Facets, facets: Vec<u32>) -> Part {
    let corners = |facet: &u32| {
        let corners = linked.corners[*facet as usize];
        corners.map(|vertex| vertices[vertex as usize])
    };
    let (low, high) = bounds(facets.iter().flat_map(corners));
    let volume = |[a, b, c]: [[f64; 3]; 3]| {
        let [a, b, c] = [a, b, c].map(|place| sub(place, low));
        dot(a, cross(b, c))
    };
    Part {
        volume: facets.iter().map(corners).map(volume).sum(),
        facets,
        low,
        high,
    }
}

/// How often a part goes around a point, its winding number: solid angles over 4 pi.
fn winding(vertices: &[[f64; 3]], (linked, part): (&Facets, &Part), at: [f64; 3]) -> f64 {
    let angle = |facet: &u32| {
        let corners = linked.corners[*facet as usize];
        let [a, b, c] = corners.map(|vertex| sub(vertices[vertex as usize], at));
        let [x, y, z] = [a, b, c].map(norm);
        let over = dot(a, cross(b, c));
        let under = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
        over.atan2(under)
    };
    part.facets.iter().map(angle).sum::<f64>() / TAU
}
