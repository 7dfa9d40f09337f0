//! The pressure along the surface of a plane body or a section, point by point:
//!
//! ```text
//! s = int |dx/dt| dt from the start of the surface,   lambda(s) at both ends and the middle of faces
//! ```
//!
//! x: the surface over which the pressure is, deformed for bodies of finite strain, undeformed for
//! linear ones, so that int lambda ds is the normal force per thickness, and int 2 pi r lambda ds
//! that of the full turn. Faces follow each other, the body on the left; a curve that closes begins
//! with its first face, beyond which s goes on, and what is not joined follows without a gap in s.
//! Lengths are those of the scaled body. Cost: the rule on the halves of all faces.

use super::deformed::{Deformed, Measure};
use super::portion::{Measured, Point};
use super::stretches::{Order, polygon};
use super::surface::{ContactSurface, face_rule};

/// Degree of the rule for the length of half a face: exact where it is straight; chosen.
const HALF_DEGREE: u32 = 4;

/// Ends of the halves of a face.
const NODES: [Point; 3] = [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]];

/// A point of the surface under pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathPoint {
    /// Its stretch of faces under pressure, numbered as the intervals of contact.
    pub interval: usize,
    /// Way along the surface from its start, in units of the scaled body.
    pub arc_length: f64,
    /// Contact pressure, in units of the smallest shear modulus.
    pub pressure: f64,
    /// Place in the deformed body `[3]`, in units of the scaled body.
    pub place: [f64; 3],
}

/// Ways to the start, the middle and the end of each face `[faces]`, in units of the scaled body.
fn ways(body: &Deformed<'_>, surface: &ContactSurface, order: &[usize]) -> Vec<[f64; 3]> {
    let rest = vec![0.0; body.displacement.len()];
    let own = match body.measure {
        Measure::Deformed => *body,
        Measure::Undeformed => Deformed {
            displacement: &rest,
            ..*body
        },
    };
    let rule = face_rule(2, HALF_DEGREE);
    let mut way = 0.0;
    let mut ways = vec![[0.0; 3]; surface.faces.len()];
    for &face in order {
        let measured = Measured::of(&own, &surface.faces[face]);
        let halves = [[0.0, 0.5], [0.5, 1.0]];
        let [near, far] = halves.map(|half| measured.length(&polygon(half), &rule));
        ways[face] = [way, way + near, way + near + far];
        way += near + far;
    }
    ways
}

/// Points of the runs of `pressed` faces `[faces]` under the pressure with these coefficients
/// `[functions]`: both ends of a face and its middle, the common ends of two faces once where the
/// pressure goes on. Empty in space.
pub fn path(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    (coefficients, pressed): (&[f64], &[bool]),
) -> Vec<PathPoint> {
    let corners = body.space.components;
    if corners != 2 || !pressed.contains(&true) {
        return Vec::new();
    }
    let order = Order::of(surface);
    let ways = ways(body, surface, &order.faces());
    let mut values = vec![0.0; surface.basis.functions(corners)];
    let mut points = Vec::new();
    for (interval, run) in order.runs(pressed).iter().enumerate() {
        let mut reached = run.first().map_or(0.0, |&first| ways[first][0]);
        for (place, &number) in run.iter().enumerate() {
            // Where a closed curve is pressed beyond its first face, its length goes on.
            let shift = reached - ways[number][0];
            reached = ways[number][2] + shift;
            let face = &surface.faces[number];
            let measured = Measured::of(body, face);
            let next = run.get(place + 1).map(|&next| &surface.faces[next]);
            let goes_on = next.is_some_and(|next| next.functions[0] == face.functions[1]);
            let own = NODES.iter().zip(ways[number]);
            for (node, way) in own.take(if goes_on { 2 } else { 3 }) {
                surface.basis.values(&node[..corners], &mut values);
                let terms = face.functions.iter().zip(&values);
                points.push(PathPoint {
                    interval,
                    arc_length: way + shift,
                    pressure: terms
                        .map(|(&k, value)| coefficients[k as usize] * value)
                        .sum(),
                    place: measured.at(node),
                });
            }
        }
    }
    points
}
