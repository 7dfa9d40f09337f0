//! Which parts of a face meet which faces of the other surface: its pieces.
//!
//! A partner counts where its middle is met from outside by a cosine of at least `GRAZING`, `ASLANT` where
//! it is of the same body, within the reach and before half of the way to where neighbouring rays of a hollow
//! face meet. Where two have a part in common, as two layers have or what goes on beyond a corner, the one
//! that is nearer at its middle has it; faces that share a normal have none in common. Of the same body
//! what only stops rays, and what turns its back on the face or is met aslant before what is met there, hides
//! that. The choice is by values alone. Cost: one outline a partner.

use super::depth::Depth;
use super::outline::{LEAST, Partner, Polygon, middle, on_face, whole, without};
use super::patch::At;
use super::rays::{Rayed, hit};
use crate::geometry::vector3::{cross, dot, norm};
use crate::pairs::choice::{ASLANT, GRAZING, Role, SIDE_BY_SIDE, WIDE};

/// A face of the other surface near a face.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Its number.
    pub number: usize,
    /// Where it is.
    pub partner: Partner,
    /// Numbers of its normals.
    pub normals: [u32; 3],
    /// What it is to the face.
    pub role: Role,
    /// Whether it is of the wall behind the face, which nothing inside the face can be.
    pub is_wall: bool,
}

/// A part of a face with its partner.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Number of the face of the other surface.
    pub other: usize,
    /// Corners on the face, counterclockwise.
    pub polygon: Polygon,
}

/// How far partners are looked for along the rays of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Largest gap of a face's nearest piece; its other pieces may be `WIDE` times as far.
    pub(super) open: f64,
    /// Largest penetration.
    pub(super) inside: Depth,
}

/// How a part of a face meets a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// It may press on it.
    Met,
    /// Its rays end there.
    Stopped,
    /// Its rays enter the body there.
    FromBehind,
}

/// A part of a face, and its gap in the middle.
struct Found {
    place: usize,
    polygon: Polygon,
    gap: f64,
    far: f64,
    way: Way,
}

impl Found {
    /// Whether what is nearer hides what is `behind`.
    fn hides(&self, behind: &Self) -> bool {
        self.way != Way::FromBehind || behind.gap > 0.0
    }
}

/// The pieces of a face among `candidates`, in their order.
pub(super) fn pieces(face: &Rayed, candidates: &[Candidate], reach: Reach) -> Vec<Piece> {
    let all = candidates.iter().enumerate();
    let mut found: Vec<Found> = all.filter_map(|own| part(face, own, reach)).collect();
    let is_met = |own: &Found| own.way == Way::Met;
    if !found.iter().any(|own| is_met(own) && own.gap <= reach.open) {
        return Vec::new();
    }
    found.sort_by(|a, b| a.far.total_cmp(&b.far).then(a.place.cmp(&b.place)));
    let mut taken: Vec<(&Found, Polygon)> = Vec::new();
    for own in &found {
        let mut parts = vec![own.polygon.clone()];
        for (nearer, polygon) in &taken {
            if nearer.hides(own) && are_apart(candidates, [nearer.place, own.place]) {
                let left = parts.into_iter();
                parts = left.flat_map(|part| left_of(part, polygon)).collect();
            }
        }
        taken.extend(parts.into_iter().map(|part| (own, part)));
    }
    taken.retain(|(own, _)| is_met(own));
    taken.sort_by_key(|(own, _)| own.place);
    let piece = |(own, polygon): (&Found, Polygon)| Piece {
        other: candidates[own.place].number,
        polygon,
    };
    taken.into_iter().map(piece).collect()
}

/// The part of a face that is opposite to a candidate, and how it meets it; none where it does not.
fn part(face: &Rayed, (place, own): (usize, &Candidate), reach: Reach) -> Option<Found> {
    let (polygon, is_facing) = seen(face, own)?;
    let at = middle(&polygon);
    let least = match own.role {
        Role::Apart => GRAZING,
        Role::Meets | Role::Hides => ASLANT,
    };
    let met = gap_to(face, at, (&own.partner, least)).filter(|_| is_facing);
    let (gap, far, way) = match met {
        Some((gap, _)) if own.is_wall && gap < 0.0 => return None,
        Some((gap, on)) => {
            let way = way((face, at), gap, (own.role, reach))?;
            (gap, gap.abs() + beyond(own, on), way)
        }
        None if own.role == Role::Apart => return None,
        None => {
            let ray = face.ray(at);
            let gap = hit(&own.partner.patch, ray)?.gap * norm(ray.along);
            (gap > 0.0).then_some((gap, gap, Way::FromBehind))?
        }
    };
    Some(Found {
        place,
        polygon,
        gap,
        far,
        way,
    })
}

/// How a place of a face meets what it faces at a distance; none where that is too far.
fn way((face, at): (&Rayed, At), gap: f64, (role, reach): (Role, Reach)) -> Option<Way> {
    if gap > WIDE * reach.open || -gap > reach.inside.at(at) {
        return None;
    }
    let is_open = gap > 0.0 && !is_before_focus(face, at, gap);
    match role {
        Role::Apart if is_open => None,
        Role::Apart => Some(Way::Met),
        Role::Meets if !is_open => Some(Way::Met),
        Role::Meets | Role::Hides => Some(Way::Stopped),
    }
}

/// How far beyond its edges a face of the same body is met, so that one beside it goes before.
fn beyond(own: &Candidate, [s, t]: At) -> f64 {
    if own.role == Role::Apart {
        return 0.0;
    }
    let over = [1.0 - s - t, s, t]
        .into_iter()
        .fold(0.0, |most: f64, l| most.max(-l));
    over * norm(own.partner.patch.area_vector([1.0 / 3.0; 2])).sqrt()
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

/// The part of a face that a candidate is opposite to, and whether both look at each other; none where it
/// turns its back and is of another body.
fn seen(face: &Rayed, own: &Candidate) -> Option<(Polygon, bool)> {
    let centre = [1.0 / 3.0; 2];
    let facing = dot(face.normal(centre), own.partner.patch.area_vector(centre));
    let is_facing = facing < 0.0;
    let outline = match (is_facing, own.role) {
        (true, _) => own.partner.outline(face),
        (false, Role::Apart) => return None,
        (false, Role::Meets | Role::Hides) => own.partner.closed().outline_from_behind(face),
    };
    let polygon = on_face(outline);
    (whole(&polygon) > LEAST).then_some((polygon, is_facing))
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

/// Distance from a point of the face to a partner along the ray there, negative inside, and where on it;
/// none where the ray misses it, meets it by a smaller cosine than `least` or from behind.
fn gap_to(face: &Rayed, at: At, (partner, least): (&Partner, f64)) -> Option<(f64, At)> {
    let ray = face.ray(at);
    let met = hit(&partner.patch, ray)?;
    let other = partner.patch.area_vector(met.at);
    let size = norm(ray.along);
    let cosine = dot(ray.along, other) / (size * norm(other));
    (cosine <= -least).then_some((met.gap * size, met.at))
}
