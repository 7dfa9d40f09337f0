//! Tangents of the obstacles at points of friction, without what supports hold.

use super::points::Point;
use crate::contact::ContactSurface;
use crate::contact::gap::{Deformed, mean_normals};
use crate::geometry::vector3::{cross, dot, normalised, scale, sub};
use crate::obstacle::{Contact, Moving, Obstacle, What};

/// Component of a unit vector that counts as one.
const ALONG: f64 = 1e-9;
/// Component of a normal from which on an axis is not across it.
const PARALLEL: f64 = 0.9;

/// Tangents of a point; zero where there is none.
pub(crate) type Frame = [[f64; 3]; 2];

/// Mean unit normals of an obstacle at the points of an interface.
pub(super) fn normals(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    obstacle: &Moving,
) -> Vec<[f64; 3]> {
    if obstacle.is_flat() {
        let mut at = [Contact::default()];
        obstacle.probe(&[[0.0; 3]], What::Normal, &mut at);
        return vec![at[0].normal; surface.multipliers()];
    }
    let sums = mean_normals(body, surface, obstacle);
    let unit = |sum| normalised(sum).unwrap_or_default();
    sums.into_iter().map(unit).collect()
}

/// Tangents of a point where the obstacle has the normal `n`, without what supports hold.
pub(super) fn frame(point: &Point, n: [f64; 3], dimension: usize) -> Frame {
    let none = [0.0; 3];
    let is_held = |tangent: [f64; 3]| (0..3).any(|i| point.held[i] && tangent[i].abs() > ALONG);
    if dimension == 2 {
        let tangent = [-n[1], n[0], 0.0];
        return [if is_held(tangent) { none } else { tangent }, none];
    }
    // Components held along the normal say nothing about the tangents.
    let across = |i: usize| point.held[i] && n[i].abs() < 1.0 - ALONG;
    let unit = |i: usize| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
    let mut held = (0..3).filter(|&i| across(i));
    match (held.next(), held.next()) {
        (None, _) => {
            let is_across = dot(point.axes[0], n).abs() < PARALLEL;
            let axis = point.axes[usize::from(!is_across)];
            let first = normalised(sub(axis, scale(dot(axis, n), n))).unwrap_or_default();
            [first, cross(n, first)]
        }
        (Some(axis), None) => [normalised(cross(n, unit(axis))).unwrap_or_default(), none],
        (Some(a), Some(b)) => {
            let free: [f64; 3] = unit(3 - a - b);
            let is_tangent = dot(free, n).abs() < ALONG && !is_held(free);
            [if is_tangent { free } else { none }, none]
        }
    }
}
