//! Which parts of a face meet which faces of the other surface: its pieces.
//!
//! A partner counts where its middle is met from outside by a cosine of at least `GRAZING`, within the
//! reach and before half of the way to where neighbouring rays of a hollow face meet. Where two have a part in common, as two layers have or what goes on beyond a corner, the one
//! that is nearer at its middle has it; faces that share a normal have none in common. The choice is
//! by values alone. Cost: one outline a partner.

use super::outline::{LEAST, Partner, Polygon, middle, on_face, whole, without};
use super::patch::At;
use super::rays::{Rayed, hit};
use crate::geometry::vector3::{cross, dot, norm};
use crate::pairs::choice::{GRAZING, SIDE_BY_SIDE, WIDE};

/// A face of the other surface near a face.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Its number.
    pub number: usize,
    /// Where it is.
    pub partner: Partner,
    /// Numbers of its normals.
    pub normals: [u32; 3],
}

/// A part of a face with its partner.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Number of the face of the other surface.
    pub other: usize,
    /// Corners on the face, counterclockwise.
    pub polygon: Polygon,
}

/// A piece, and its gap in the middle.
struct Found {
    place: usize,
    polygon: Polygon,
    gap: f64,
}

/// The pieces of a face among `candidates`, in their order.
pub(super) fn pieces(face: &Rayed, candidates: &[Candidate], reach: f64) -> Vec<Piece> {
    let all = candidates.iter().enumerate();
    let mut found: Vec<Found> = all
        .filter_map(|(place, own)| {
            let polygon = seen(face, &own.partner)?;
            let gap = gap_to(face, middle(&polygon), &own.partner)?;
            let is_near = gap <= WIDE * reach && -gap <= reach;
            let is_open = || gap > 0.0 && !is_before_focus(face, middle(&polygon), gap);
            let is_met = is_near && !is_open();
            is_met.then_some(Found {
                place,
                polygon,
                gap,
            })
        })
        .collect();
    if !found.iter().any(|own| own.gap <= reach) {
        return Vec::new();
    }
    found.sort_by(|a, b| {
        a.gap
            .abs()
            .total_cmp(&b.gap.abs())
            .then(a.place.cmp(&b.place))
    });
    let mut pieces: Vec<(usize, Polygon)> = Vec::new();
    for own in found {
        let mut parts = vec![own.polygon];
        for (taken, polygon) in &pieces {
            if are_apart(candidates, [*taken, own.place]) {
                let left = parts.into_iter();
                parts = left.flat_map(|part| left_of(part, polygon)).collect();
            }
        }
        pieces.extend(parts.into_iter().map(|part| (own.place, part)));
    }
    pieces.sort_by_key(|(place, _)| *place);
    let piece = |(place, polygon): (usize, Polygon)| Piece {
        other: candidates[place].number,
        polygon,
    };
    pieces.into_iter().map(piece).collect()
}

/// Whether two candidates share no normal.
fn are_apart(candidates: &[Candidate], [a, b]: [usize; 2]) -> bool {
    let [a, b] = [a, b].map(|place| candidates[place].normals);
    !a.iter().any(|normal| b.contains(normal))
}

/// What `taken` leaves of a part.
fn left_of(part: Polygon, taken: &Polygon) -> Vec<Polygon> {
    let bounds = |polygon: &Polygon, i: usize| {
        let values = polygon.iter().map(|corner| corner.at[i]);
        let least = values.clone().fold(f64::INFINITY, f64::min);
        [least, values.fold(f64::NEG_INFINITY, f64::max)]
    };
    let is_clear = (0..2).any(|i| {
        let [own, other] = [bounds(&part, i), bounds(taken, i)];
        own[0] >= other[1] || other[0] >= own[1]
    });
    if is_clear {
        return vec![part];
    }
    without(part, taken)
}

/// The part of a face that a partner is opposite to; none where they turn their backs on each other.
fn seen(face: &Rayed, partner: &Partner) -> Option<Polygon> {
    let centre = [1.0 / 3.0; 2];
    let facing = dot(face.normal(centre), partner.patch.area_vector(centre));
    if facing >= 0.0 {
        return None;
    }
    let polygon = on_face(partner.outline(face));
    (whole(&polygon) > LEAST).then_some(polygon)
}

/// Whether the rays around a point of the face still go their way side by side at a distance `gap`, along
/// both principal directions: beyond where those of a hollow face meet, what they sweep is negative in one,
///
/// ```text
/// n . (x_,1 + r n_,1) x (x_,2 + r n_,2) = a + b r + c r^2,  a (1 + r k_1) (1 + r k_2)
/// ```
fn is_before_focus(face: &Rayed, at: At, gap: f64) -> bool {
    let n = face.normal(at);
    let [first, second] = face.patch.tangents(at);
    let [turn, other] = face.turns();
    let size = norm(n);
    let r = gap / (size * SIDE_BY_SIDE);
    let a = dot(n, cross(first, second));
    let b = dot(n, cross(turn, second)) + dot(n, cross(first, other));
    let c = dot(n, cross(turn, other));
    a + r * (b + r * c) > 0.0 && 2.0 * a + r * b > 0.0
}

/// Distance from a point of the face to a partner along the ray there, negative inside; none where the
/// ray misses it, grazes it or meets it from behind.
fn gap_to(face: &Rayed, at: At, partner: &Partner) -> Option<f64> {
    let ray = face.ray(at);
    let met = hit(&partner.patch, ray)?;
    let other = partner.patch.area_vector(met.at);
    let size = norm(ray.along);
    let cosine = dot(ray.along, other) / (size * norm(other));
    (cosine <= -GRAZING).then_some(met.gap * size)
}
