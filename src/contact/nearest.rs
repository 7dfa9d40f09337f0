//! How near the faces of a surface are to what they meet, between the points of the contact
//! integrals as well:
//!
//! ```text
//! d_f = min over a grid of barycentric points of d(x + u)   for each face f
//! ```
//!
//! Negative inside. Lengths are those of the scaled body. A distance changes by no more than
//! the point moves: a face that can neither be the nearest one nor inside, by its distance in the
//! middle and its size, has that lower bound in place of d_f. Around the best point of a face that
//! may be touched finer grids follow, each a quarter of the last. Cost: one distance a face; of
//! those that are near, 45 in space, 17 in the plane, and as many again for each finer grid.

use rayon::prelude::*;

use super::counterpart::Counterpart;
use super::deformed::{Deformed, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::element::quadrature::Rule;
use crate::geometry::vector3::{norm, sub};
use crate::obstacle::{Contact, What};

/// Above one by more than all rounding, and by what distances to patches miss of a true distance.
const CAREFUL: f64 = 1.01;
/// What a finer grid may find nearer than the first one, over the size of a face: no point of
/// a face of usual shape is farther from the first grid.
const REACH: f64 = 0.25;
/// Intervals of the grid on a face in space.
const IN_SPACE: u32 = 8;
/// Intervals on a face in the plane.
const IN_THE_PLANE: u32 = 16;

/// The least distance of each face `[faces]`, or a bound below it where it is neither the least of
/// all nor negative.
pub fn nearest<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
) -> Vec<f64> {
    let rule = grid(body.space.components);
    let sampled = Deformed {
        rule: &rule,
        ..*body
    };
    let bounds = bounds(&sampled, surface, counterpart);
    let upper = bounds.chunks_exact(2).map(|bound| bound[1]);
    let least_of_all = upper.fold(f64::INFINITY, f64::min).max(0.0);
    let lower = bounds.chunks_exact(2).map(|bound| bound[0]);
    let mut distances: Vec<f64> = lower.collect();
    let is_near = |face: &usize| distances[*face] <= least_of_all;
    let near: Vec<usize> = (0..distances.len()).filter(is_near).collect();
    let faces: Vec<ContactFace> = near
        .iter()
        .map(|&face| surface.faces[face].clone())
        .collect();
    let numbers = least(&sampled, (surface, &faces), counterpart);
    let power = 1.0 / (body.space.components as f64 - 1.0);
    let nearest = numbers.iter().step_by(2).copied();
    let nearest = nearest.fold(f64::INFINITY, f64::min).max(0.0);
    let faces = faces.par_iter().zip(numbers.par_chunks_exact(2));
    let refined = faces.map(|(face, number)| {
        let best = rule.points[number[1] as usize];
        match number[0] < nearest + REACH * face.flat_area.powf(power) {
            true => refined(body, (surface, face), counterpart, (number[0], best)),
            false => number[0],
        }
    });
    let refined: Vec<f64> = refined.collect();
    for (index, distance) in near.into_iter().zip(refined) {
        distances[index] = distance;
    }
    distances
}

/// Bounds of the least distance of each face, from below and above `[faces][2]`: by the distance
/// of the point in the middle of the grid and how far the other points are from it.
fn bounds<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    body.on_faces(&table, &surface.faces, 2, |points, face, numbers| {
        let middle = points.deformed[points.deformed.len() / 2];
        let mut contact = [Contact::default()];
        counterpart.probe_on(face, &[middle], What::Gap, &mut contact);
        let away = points
            .deformed
            .iter()
            .map(|&point| norm(sub(point, middle)));
        let farthest = away.fold(0.0, f64::max);
        numbers[0] = contact[0].distance - CAREFUL * farthest;
        numbers[1] = contact[0].distance;
    })
}

/// The least distance of each of `faces` over the points of the body's rule, and the number of
/// its point `[faces][2]`.
fn least<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    (surface, faces): (&ContactSurface, &[ContactFace]),
    counterpart: &C,
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    body.on_faces(&table, faces, 2, |points, face, numbers| {
        points.probe(counterpart, face, What::Gap);
        numbers[0] = f64::INFINITY;
        for (point, contact) in points.contacts.iter().enumerate() {
            if contact.distance < numbers[0] {
                numbers.copy_from_slice(&[contact.distance, point as f64]);
            }
        }
    })
}

/// The least distance of one face, sought around the best point so far.
fn refined<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    (surface, face): (&ContactSurface, &ContactFace),
    counterpart: &C,
    (mut distance, mut best): (f64, [f64; 4]),
) -> f64 {
    let mut size = 1.0;
    for _ in 0..ROUNDS {
        size *= 0.25;
        // The grid shrunk towards the best point stays on the face.
        let mut rule = grid(body.space.components);
        for point in &mut rule.points {
            *point = std::array::from_fn(|i| best[i] + size * (point[i] - best[i]));
        }
        let sampled = Deformed {
            rule: &rule,
            ..*body
        };
        let number = least(&sampled, (surface, std::slice::from_ref(face)), counterpart);
        if number[0] < distance {
            (distance, best) = (number[0], rule.points[number[1] as usize]);
        }
    }
    distance
}

/// Finer grids around the best point of a face.
const ROUNDS: u32 = 4;

/// Points of a face with that many corners, of equal weight.
fn grid(corners: usize) -> Rule {
    let intervals = if corners == 2 { IN_THE_PLANE } else { IN_SPACE };
    let share = |count: u32| f64::from(count) / f64::from(intervals);
    let mut points = Vec::new();
    for i in 0..=intervals {
        let others = if corners == 2 {
            0..=0
        } else {
            0..=intervals - i
        };
        for j in others {
            let [a, b] = [share(i), share(j)];
            points.push([1.0 - a - b, a, b, 0.0]);
        }
    }
    let weights = vec![1.0 / points.len() as f64; points.len()];
    Rule { points, weights }
}
