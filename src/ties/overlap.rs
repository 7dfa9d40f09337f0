//! The parts of a facet that have a partner on another one: both projected along the normal of the
//! first,
//!
//! ```text
//! plane:  s_k = (Y_k - X_0).t / t.t,   the part of [0, 1] between them
//! space:  barycentric coordinates of the projections of Y_k, that triangle clipped by the first
//! ```
//!
//! Facets that turn their backs on each other's body have no part in common. Straight facets are
//! meant: curved edges shift the borders of the parts, not what is compared there. Cost: some 200
//! flops a pair in space.

use crate::geometry::vector3::{cross, dot, norm, scale, sub};

/// Least cosine between the normals of facets that face each other.
const FACING: f64 = 0.5;
/// Parts of a facet below this share of it are none.
const LEAST: f64 = 1e-12;

/// Barycentric coordinates on a facet, the third zero in the plane.
pub type Place = [f64; 3];

/// A segment or a triangle of a facet, with its share of the facet.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Its two or three corners.
    pub corners: [Place; 3],
    /// Length or area over that of the facet.
    pub share: f64,
}

/// Normal of a straight facet by the order of its corners, as long as the facet is large.
pub fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
    match corners {
        [a, b, c] => scale(0.5, cross(sub(*b, *a), sub(*c, *a))),
        [a, b] => {
            let [x, y, _] = sub(*b, *a);
            [y, -x, 0.0]
        }
        _ => [0.0; 3],
    }
}

/// The parts of the facet `own` that `other` is opposite to.
pub fn parts(own: &[[f64; 3]], other: &[[f64; 3]]) -> Vec<Part> {
    let [first, second] = [normal(own), normal(other)];
    if dot(first, second) > -FACING * norm(first) * norm(second) {
        return Vec::new();
    }
    match (own, other) {
        ([a, b], [c, d]) => segment([*a, *b], [*c, *d]),
        ([a, b, c], [d, e, f]) => triangles([*a, *b, *c], [*d, *e, *f]),
        _ => Vec::new(),
    }
}

fn segment([a, b]: [[f64; 3]; 2], other: [[f64; 3]; 2]) -> Vec<Part> {
    let t = sub(b, a);
    let [c, d] = other.map(|y| dot(sub(y, a), t) / dot(t, t));
    let (from, to) = (c.min(d).max(0.0), c.max(d).min(1.0));
    let place = |s: f64| [1.0 - s, s, 0.0];
    let part = Part {
        corners: [place(from), place(to), [0.0; 3]],
        share: to - from,
    };
    Vec::from_iter((part.share > LEAST).then_some(part))
}

fn triangles([a, b, c]: [[f64; 3]; 3], other: [[f64; 3]; 3]) -> Vec<Part> {
    let [along, across] = [sub(b, a), sub(c, a)];
    let [aa, ac, cc] = [dot(along, along), dot(along, across), dot(across, across)];
    let determinant = aa * cc - ac * ac;
    let project = |y: [f64; 3]| {
        let y = sub(y, a);
        let [s, t] = [dot(along, y), dot(across, y)];
        let [s, t] = [
            (cc * s - ac * t) / determinant,
            (aa * t - ac * s) / determinant,
        ];
        [1.0 - s - t, s, t]
    };
    let mut polygon: Vec<Place> = other.map(project).to_vec();
    for side in 0..3 {
        polygon = clipped(&polygon, side);
    }
    fan(&polygon)
}

/// The part of a polygon where that coordinate is positive (I. Sutherland and G. Hodgman, 1974).
fn clipped(polygon: &[Place], side: usize) -> Vec<Place> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    let after = polygon.iter().cycle().skip(1);
    for (from, to) in polygon.iter().zip(after) {
        let [here, there] = [from[side], to[side]];
        if here >= 0.0 {
            kept.push(*from);
        }
        if (here >= 0.0) != (there >= 0.0) {
            let s = here / (here - there);
            kept.push(std::array::from_fn(|i| from[i] + s * (to[i] - from[i])));
        }
    }
    kept
}

/// The triangles between the first corner of a polygon and its sides.
fn fan(polygon: &[Place]) -> Vec<Part> {
    let Some((&first, rest)) = polygon.split_first() else {
        return Vec::new();
    };
    let part = |pair: &[Place]| {
        let corners = [first, pair[0], pair[1]];
        let [u, v] = [1, 2].map(|k| [1, 2].map(|i| corners[k][i] - first[i]));
        Part {
            corners,
            share: (u[0] * v[1] - u[1] * v[0]).abs(),
        }
    };
    let all = rest.windows(2).map(part);
    all.filter(|part| part.share > LEAST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(parts: &[Part]) -> f64 {
        parts.iter().map(|part| part.share).sum()
    }

    #[test]
    fn partners_share_a_facet_among_them() {
        let own = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        // The square [-0.5, 1.5]^2 above it in two triangles, looking down, which lacks two corners of the
        // facet of area 1/8 each.
        let low = [[-0.5, -0.5, 0.1], [1.5, 1.5, 0.1], [1.5, -0.5, 0.1]];
        let far = [[-0.5, -0.5, 0.1], [-0.5, 1.5, 0.1], [1.5, 1.5, 0.1]];
        let both = [low, far].map(|other| sum(&parts(&own, &other)));
        assert!(
            both.iter().all(|share| (share - 0.4375).abs() < 1e-14),
            "{both:?}"
        );
        let turned = [low[0], low[2], low[1]];
        assert!(parts(&own, &turned).is_empty(), "its back");
    }

    #[test]
    fn a_part_of_an_edge_is_between_the_ends_of_its_partner() {
        let own = [[0.0; 3], [2.0, 0.0, 0.0]];
        let other = [[1.5, -0.1, 0.0], [0.5, -0.1, 0.0]];
        let found = parts(&own, &other);
        assert_eq!(found.len(), 1);
        assert!((found[0].share - 0.5).abs() < 1e-15);
        let apart = sub(found[0].corners[0], [0.75, 0.25, 0.0]);
        assert!(norm(apart) < 1e-15);
        assert!(parts(&own, &[other[1], other[0]]).is_empty(), "its back");
    }

    #[test]
    fn triangles_that_cover_a_facet_have_all_of_it() {
        let own = [[0.1, 0.2, 0.0], [0.9, 0.1, 0.0], [0.4, 0.8, 0.0]];
        // A grid of the unit square with its triangles looking down.
        let mut share = 0.0;
        for (i, j) in (0..7).flat_map(|i| (0..5).map(move |j| (i, j))) {
            let at = |i: i32, j: i32| [f64::from(i) / 7.0, f64::from(j) / 5.0, 0.0];
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            share += sum(&parts(&own, &[a, c, b])) + sum(&parts(&own, &[a, d, c]));
        }
        assert!((share - 1.0).abs() < 1e-13, "{share}");
    }
}
