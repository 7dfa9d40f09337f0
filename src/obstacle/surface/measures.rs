//! Sizes of a tool: the largest ball inside, the smallest radius of its convex parts.

use rayon::prelude::*;

use super::bending::curvature;
use super::geometry::Geometry;
use crate::obstacle::{Ball, Contact, What};

/// Points an axis of the lattice on which the inner ball is looked for.
const LATTICE: u32 = 8;

/// The deepest point of a lattice over the box of the surface.
pub(super) fn largest_ball(geometry: &Geometry) -> Option<Ball> {
    let corners = geometry.patches.iter().flat_map(|patch| patch.corners);
    let (low, high) = super::bounds(corners);
    let centre = |index: u32| -> [f64; 3] {
        let steps = [
            index % LATTICE,
            index / LATTICE % LATTICE,
            index / (LATTICE * LATTICE),
        ];
        std::array::from_fn(|i| {
            let share = (f64::from(steps[i]) + 0.5) / f64::from(LATTICE);
            low[i] + share * (high[i] - low[i])
        })
    };
    let ball = |index: u32| {
        let mut contact = Contact::default();
        let centre = centre(index);
        geometry.contact((centre, &mut None), What::Gap, &mut contact);
        let radius = -contact.distance;
        (radius > 0.0).then_some((Ball { centre, radius }, index))
    };
    let balls = (0..LATTICE.pow(3)).into_par_iter().filter_map(ball);
    let larger = |a: &(Ball, u32), b: &(Ball, u32)| {
        let by_radius = a.0.radius.total_cmp(&b.0.radius);
        by_radius.then(b.1.cmp(&a.1))
    };
    balls.max_by(larger).map(|(ball, _)| ball)
}

/// Zero where there is a convex feature, else the least of the patches' middles.
pub(super) fn smallest_radius(geometry: &Geometry) -> Option<f64> {
    let facets = (0..geometry.patches.len()).into_par_iter();
    let edges = facets
        .clone()
        .flat_map_iter(|facet| (0..3).map(move |k| (facet, k)));
    if edges.any(|(facet, opposite)| geometry.is_convex_feature(facet, opposite)) {
        return Some(0.0);
    }
    let bent = facets.map(|facet| largest_curvature(geometry, facet));
    let largest = bent.reduce(|| 0.0, f64::max);
    (largest > 0.0).then(|| 1.0 / largest)
}

/// The larger principal curvature in the middle of a patch.
fn largest_curvature(geometry: &Geometry, facet: usize) -> f64 {
    let patch = &geometry.patches[facet];
    let normal = patch.normal([1.0 / 3.0; 3]);
    let bent = curvature(patch, [1.0 / 3.0; 3], normal, 0.0);
    let trace: f64 = (0..3).map(|i| bent[i][i]).sum();
    let squares: f64 = bent.as_flattened().iter().map(|x| x * x).sum();
    let half = 0.5 * trace;
    half + (0.5 * squares - half * half).max(0.0).sqrt()
}
