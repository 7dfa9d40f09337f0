//! How far contact extends over the deformed surface, and where its pressure is largest:
//!
//! ```text
//! A = int da over contact,   peak = max lambda over the faces, of the quadratic on each
//! ```
//!
//! Contact ends inside faces: in space by `edge`, in the plane and about an axis by `stretches`.
//! Non-dimensional. Cost: one probe a node of each face, and the rule on those under pressure.

use super::counterpart::Counterpart;
use super::deformed::Deformed;
use super::edge::portions;
use super::intervals::{ContactInterval, interval};
use super::node_gaps::NodeGaps;
use super::portion::{Measured, whole};
use super::resultant::{Acting, face_forces};
use super::stretches::{polygon, stretches};
use super::surface::{ContactSurface, face_rule};

/// Degree of the rule on parts of faces, whose element of area bends little.
const PART_DEGREE: u32 = 4;

/// What contact covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactExtent {
    /// Deformed area, of the full turn about an axis, in units of the scaled body.
    pub area: f64,
    /// Intervals along the surface of a plane body or a section; empty in space.
    pub intervals: Vec<ContactInterval>,
    /// Largest pressure and its deformed place; none without pressure.
    pub peak: Option<(f64, [f64; 3])>,
}

/// Coefficients of the pressure of active multipliers `[functions]`, and which faces it acts on
/// `[faces]`.
pub fn pressed(surface: &ContactSurface, at: Acting<'_>) -> (Vec<f64>, Vec<bool>) {
    let pairs = at.pressure.iter().zip(at.active);
    let own = pairs.map(|(pressure, &is_active)| if is_active { pressure.max(0.0) } else { 0.0 });
    let own: Vec<f64> = own.collect();
    let coefficients = surface.shares.spread(&own).into_owned();
    let faces = surface.faces.iter();
    let acts = |k: &u32| coefficients[*k as usize] > 0.0;
    let pressed = faces.map(|face| face.functions.iter().any(acts)).collect();
    (coefficients, pressed)
}

/// What the pressure of active multipliers covers on `surface`; forces of `counterpart` on faces where they are
/// known, else those of the pressure on all of each face.
pub fn extent<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    (counterpart, on_faces): (&C, Option<&[[f64; 3]]>),
    at: Acting<'_>,
) -> ContactExtent {
    let (coefficients, pressed) = pressed(surface, at);
    if !pressed.contains(&true) {
        return ContactExtent::default();
    }
    let gaps = NodeGaps::new(body, surface, counterpart);
    let rule = face_rule(gaps.corners, PART_DEGREE);
    let mut found = ContactExtent {
        peak: peak(body, surface, &coefficients),
        ..ContactExtent::default()
    };
    let parts = if gaps.corners == 2 {
        let mut stretches = stretches(&gaps, &pressed);
        for (face, share) in stretches.iter_mut().flatten() {
            let [from, to] = counterpart.covered(&surface.faces[*face]);
            *share = share.map(|end| end.clamp(from, to));
        }
        let forces = match on_faces {
            Some(forces) => forces.to_vec(),
            None => face_forces(body, surface, counterpart, at),
        };
        let intervals = stretches.iter();
        let intervals = intervals.map(|own| interval(body, surface, (own, &forces), &rule));
        found.intervals = intervals.collect();
        let parts = stretches.into_iter().flatten();
        parts
            .map(|(face, share)| (face, polygon(share).to_vec()))
            .collect()
    } else {
        portions(&gaps, &pressed)
    };
    for (face, part) in parts {
        let face = &surface.faces[face];
        let measured = Measured::of(body, face);
        let area = measured.area(&part, &rule);
        let share = counterpart.share(face);
        found.area += if share < 1.0 {
            area.min(share * measured.area(&whole(gaps.corners), &rule))
        } else {
            area
        };
    }
    found
}

/// The largest pressure and its deformed place, the first of equals.
fn peak(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    coefficients: &[f64],
) -> Option<(f64, [f64; 3])> {
    let corners = body.space.components;
    let mut largest: Option<(f64, usize, [f64; 3])> = None;
    let mut own = Vec::new();
    for (number, face) in surface.faces.iter().enumerate() {
        own.clear();
        own.extend(face.functions.iter().map(|&k| coefficients[k as usize]));
        let (value, point) = surface.basis.largest(corners, &own);
        if value > largest.map_or(0.0, |known| known.0) {
            largest = Some((value, number, point));
        }
    }
    largest.map(|(value, number, point)| {
        let face = Measured::of(body, &surface.faces[number]);
        (value, face.at(&point))
    })
}
