//! The part of a face that is in contact, a convex polygon of barycentric coordinates, and what
//! is measured on it:
//!
//! ```text
//! A = int da over the part,   corners p_j of its simplices: l = sum m_j p_j,   da by the rule in m
//! ```
//!
//! Areas are those of the deformed, scaled body, of the full turn about an axis. Cost: some 100
//! flops a point of the rule.

use super::area_element::{AreaElement, Extent, NODES};
use super::deformed::{Deformed, node_positions};
use super::face::ContactFace;
use crate::assembly::follower::shape_slopes;
use crate::assembly::load::push_shape_values;
use crate::element::quadrature::Rule;
use crate::geometry::vector3::{add, cross, dot, scale, sub};

/// Barycentric coordinates on a face; the third is zero in the plane.
pub(super) type Point = [f64; 3];

/// A deformed face of which a part is measured.
pub(super) struct Measured {
    /// Hierarchical coefficients of the deformed position.
    place: [[f64; 3]; NODES],
    corners: usize,
    is_turned: bool,
}

impl Measured {
    /// `face` of `body`.
    pub(super) fn of(body: &Deformed<'_>, face: &ContactFace) -> Self {
        Self {
            place: node_positions(body, face),
            corners: face.corners.len(),
            is_turned: face.radii.is_some(),
        }
    }

    /// Deformed position of a point.
    pub(super) fn at(&self, point: &Point) -> [f64; 3] {
        let mut shapes = Vec::with_capacity(NODES);
        push_shape_values(&point[..self.corners], &mut shapes);
        let terms = self.place.iter().zip(shapes);
        terms.fold([0.0; 3], |sum, (place, shape)| {
            add(sum, scale(shape, *place))
        })
    }

    /// Area of the part that is `polygon`, of its full turn about an axis.
    pub(super) fn area(&self, polygon: &[Point], rule: &Rule) -> f64 {
        self.integral(
            polygon,
            rule,
            match (self.corners, self.is_turned) {
                (2, false) => Extent::Segment,
                (2, true) => Extent::Ring,
                _ => Extent::Triangle,
            },
        )
    }

    /// Length of the part of a segment, without any turn.
    pub(super) fn length(&self, polygon: &[Point], rule: &Rule) -> f64 {
        self.integral(polygon, rule, Extent::Segment)
    }

    fn integral(&self, polygon: &[Point], rule: &Rule, extent: Extent) -> f64 {
        let simplices = simplices(polygon, self.corners);
        let parts = simplices.map(|simplex| share(&simplex) * self.mean(&simplex, rule, extent));
        parts.sum()
    }

    /// Mean of the element of area over a simplex by the rule.
    fn mean(&self, simplex: &[Point], rule: &Rule, extent: Extent) -> f64 {
        let points = rule.points.iter().zip(&rule.weights);
        let terms = points.map(|(l, weight)| {
            let mixed = simplex.iter().zip(l);
            let point = mixed.fold([0.0; 3], |sum, (corner, l)| add(sum, scale(*l, *corner)));
            let point = &point[..self.corners];
            let mut shapes = Vec::with_capacity(NODES);
            push_shape_values(point, &mut shapes);
            let slopes = shape_slopes(point);
            weight * AreaElement::new(extent, &self.place, (&shapes, &slopes)).size()
        });
        terms.sum()
    }
}

/// The whole of a face with that many corners.
pub(super) fn whole(corners: usize) -> Vec<Point> {
    let corner = |own: usize| std::array::from_fn(|i| if i == own { 1.0 } else { 0.0 });
    (0..corners).map(corner).collect()
}

/// The part of a triangle where what has these values at its corners and is linear is below zero.
pub(super) fn below_zero(values: [f64; 3]) -> Vec<Point> {
    let corners = whole(3);
    let mut polygon = Vec::with_capacity(4);
    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
        if values[a] < 0.0 {
            polygon.push(corners[a]);
        }
        if (values[a] < 0.0) != (values[b] < 0.0) {
            let along = values[a] / (values[a] - values[b]);
            let step = scale(along, sub(corners[b], corners[a]));
            polygon.push(add(corners[a], step));
        }
    }
    polygon
}

/// The polygon as segments, or as triangles about its first point.
fn simplices(polygon: &[Point], corners: usize) -> impl Iterator<Item = Vec<Point>> + '_ {
    let rest = polygon.get(1..).unwrap_or_default();
    let others = rest.windows(corners - 1);
    others.map(move |others| [&polygon[..1], others].concat())
}

/// Measure of a simplex over that of its face.
fn share(simplex: &[Point]) -> f64 {
    match simplex {
        [a, b] => (b[1] - a[1]).abs(),
        [a, b, c] => dot(*a, cross(*b, *c)).abs(),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Share of a triangle where the linear function is below zero, by a fine lattice.
    fn sampled(values: [f64; 3], count: u32) -> f64 {
        let lattice = (0..count).flat_map(|i| (0..count - i).map(move |j| [i, j]));
        let (mut below, mut all) = (0.0, 0.0);
        for [i, j] in lattice {
            let [a, b] = [i, j].map(|x| (f64::from(x) + 1.0 / 3.0) / f64::from(count));
            let value = values[0] * a + values[1] * b + values[2] * (1.0 - a - b);
            below += f64::from(u8::from(value < 0.0));
            all += 1.0;
        }
        below / all
    }

    proptest! {
        #[test]
        fn a_cut_triangle_has_the_area_that_fine_sampling_finds(
            values in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let polygon = below_zero(values);
            let parts = simplices(&polygon, 3);
            let area: f64 = parts.map(|simplex| share(&simplex)).sum();
            prop_assert!((area - sampled(values, 300)).abs() < 0.01, "{area}");
        }
    }

    #[test]
    fn a_triangle_above_zero_has_no_part_and_one_below_is_whole() {
        assert!(below_zero([1.0, 0.0, 2.0]).is_empty());
        assert_eq!(below_zero([-1.0, -0.5, -2.0]), whole(3));
    }
}
