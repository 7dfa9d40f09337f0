//! Tangents of the obstacles at points of friction, without what supports hold.

use super::points::Point;
use crate::contact::ContactSurface;
use crate::contact::gap::{Deformed, mean_normals};
use crate::geometry::vector3::{cross, dot, norm, normalised, scale, sub};
use crate::obstacle::{Contact, Derivatives, Moving, Obstacle};

/// What is left of a unit vector across others from which on it is none of their sums.
const ACROSS: f64 = 1e-5;
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
        obstacle.probe(&[[0.0; 3]], Derivatives::Normal, &mut at);
        return vec![at[0].normal; surface.multipliers()];
    }
    let sums = mean_normals(body, surface, obstacle);
    let unit = |sum| normalised(sum).unwrap_or_default();
    sums.into_iter().map(unit).collect()
}

/// Tangents of a point where the obstacle has the normal `n`, without what supports hold.
pub(super) fn frame(point: &Point, n: [f64; 3], dimension: usize) -> Frame {
    let none = [0.0; 3];
    // Directions held along the normal say nothing about the tangents.
    let mut held = held_across(&point.held, n);
    match (dimension, held.next(), held.next()) {
        (2, None, _) => [[-n[1], n[0], 0.0], none],
        (_, None, _) => {
            let is_across = dot(point.axes[0], n).abs() < PARALLEL;
            let axis = point.axes[usize::from(!is_across)];
            let first = normalised(sub(axis, scale(dot(axis, n), n))).unwrap_or_default();
            [first, cross(n, first)]
        }
        (3, Some(held), None) => [normalised(cross(n, held)).unwrap_or_default(), none],
        _ => [none, none],
    }
}

/// An orthonormal basis of what the unit vectors `held` span across `n`.
fn held_across(held: &[[f64; 3]], n: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    let mut basis = [n; 3];
    let mut size = 1;
    for &direction in held {
        let known = basis.iter().take(size);
        let rest = known.fold(direction, |rest, one| {
            sub(rest, scale(dot(rest, *one), *one))
        });
        if let (Some(next), true) = (basis.get_mut(size), norm(rest) > ACROSS) {
            *next = normalised(rest).unwrap_or_default();
            size += 1;
        }
    }
    basis.into_iter().take(size).skip(1)
}
