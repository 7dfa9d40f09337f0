//! The nearest point of a surface F = 0: Newton's method for
//!
//! ```text
//! F(y) = 0,   T^T (x - y) = 0
//! ```
//!
//! along the normal and the tangents T at y, with the unit matrix in place of I + d B where
//! that is not positive: on the hollow side, beyond a centre of curvature.

use super::spline::Jet;
use crate::geometry::Matrix3;
use crate::geometry::vector3::{add, cross, dot, max_norm, norm, scale, sub};
use crate::obstacle::{Contact, orthogonal};

/// Steps at most.
const STEPS: usize = 40;
/// Step, in cells, at which a search has ended; the distance has the square of it as error.
const END: f64 = 1e-11;
/// The same over the size of the coordinates.
const ROUNDING: f64 = 1e-14;
/// Least eigenvalue of I + d B that counts as positive.
const POSITIVE: f64 = 1e-3;
/// Least slope that has a direction.
const LEVEL: f64 = 1e-6;

/// A surface F = 0, F above zero on the free side.
pub(super) trait Level {
    /// F and its derivatives at a place `[3]`.
    fn jet(&self, place: [f64; 3]) -> Jet<3>;

    /// The shortest length in which F may change its form.
    fn cell(&self) -> f64;
}

/// The frame of a level of F at a place.
pub(super) struct Frame {
    pub(super) slope: f64,
    pub(super) normal: [f64; 3],
    tangents: [[f64; 3]; 2],
    /// B: xx, xy, yy.
    bent: [f64; 3],
    /// T^T hess F n / |grad F|.
    turn: [f64; 2],
}

impl Frame {
    /// None where F is level.
    pub(super) fn new(jet: &Jet<3>) -> Option<Self> {
        let slope = norm(jet.gradient);
        if !slope.is_finite() || slope < LEVEL {
            return None;
        }
        let normal = scale(1.0 / slope, jet.gradient);
        let first = orthogonal(normal);
        let tangents = [first, cross(normal, first)];
        let second = |a: [f64; 3], b: [f64; 3]| dot(a, jet.hessian.map(|row| dot(row, b))) / slope;
        let [s, t] = tangents;
        Some(Self {
            slope,
            normal,
            tangents,
            bent: [second(s, s), second(s, t), second(t, t)],
            turn: tangents.map(|tangent| second(tangent, normal)),
        })
    }

    /// Principal curvatures of the level, one over length, the smaller first.
    pub(super) fn curvatures(&self) -> [f64; 2] {
        eigenvalues(self.bent)
    }

    /// B (I + d B)^-1 in space, zero where that has no inverse.
    fn curvature(&self, distance: f64) -> Matrix3 {
        let moved = shifted(self.bent, distance);
        if !is_positive(moved) {
            return [[0.0; 3]; 3];
        }
        let [a, b, c] = self.bent;
        let inverse = inverse(moved);
        let middle = [
            a * inverse[0] + b * inverse[1],
            // Both products are the same: B commutes with I + d B.
            0.5 * (a * inverse[1] + b * inverse[2] + b * inverse[0] + c * inverse[1]),
            b * inverse[1] + c * inverse[2],
        ];
        let [s, t] = self.tangents;
        let entry = |i: usize, j: usize| {
            middle[0] * s[i] * s[j]
                + middle[1] * (s[i] * t[j] + t[i] * s[j])
                + middle[2] * t[i] * t[j]
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

/// One step of the search: along the normal and the tangents.
struct Step {
    rise: f64,
    along: [f64; 2],
    /// Whether the distance is least at the foot, or a saddle.
    is_least: bool,
}

impl Step {
    /// From a place with value F towards the foot of a point `offset` away.
    fn new(frame: &Frame, value: f64, offset: [f64; 3]) -> Self {
        let distance = dot(offset, frame.normal);
        let rise = -value / frame.slope;
        let sideways: [f64; 2] = std::array::from_fn(|i| {
            dot(offset, frame.tangents[i]) - distance * frame.turn[i] * rise
        });
        let moved = shifted(frame.bent, distance);
        let is_least = is_positive(moved);
        let [a, b, c] = if is_least {
            inverse(moved)
        } else {
            [1.0, 0.0, 1.0]
        };
        let [s, t] = sideways;
        Self {
            rise,
            along: [a * s + b * t, b * s + c * t],
            is_least,
        }
    }

    fn size(&self) -> f64 {
        self.rise.hypot(self.along[0]).hypot(self.along[1])
    }

    fn vector(&self, frame: &Frame) -> [f64; 3] {
        let [s, t] = frame.tangents;
        let along = add(scale(self.along[0], s), scale(self.along[1], t));
        add(scale(self.rise, frame.normal), along)
    }
}

/// The contact of `x` with the level at its nearest point, and that point, sought from
/// `start`; none where the search does not end at a nearest point.
pub(super) fn nearest(
    level: &impl Level,
    x: [f64; 3],
    start: [f64; 3],
) -> Option<(Contact, [f64; 3])> {
    let cell = level.cell();
    let mut y = start;
    for _ in 0..STEPS {
        let jet = level.jet(y);
        let frame = Frame::new(&jet)?;
        let offset = sub(x, y);
        let distance = dot(offset, frame.normal);
        let step = Step::new(&frame, jet.value, offset);
        let size = step.size();
        if size <= END * cell + ROUNDING * (max_norm(x) + distance.abs()) {
            let contact = Contact {
                distance: distance - step.rise,
                normal: frame.normal,
                curvature: frame.curvature(distance),
            };
            return step.is_least.then_some((contact, y));
        }
        y = add(y, scale((cell / size).min(1.0), step.vector(&frame)));
    }
    None
}

/// I + d B.
fn shifted(bent: [f64; 3], distance: f64) -> [f64; 3] {
    let [a, b, c] = bent.map(|entry| distance * entry);
    [1.0 + a, b, 1.0 + c]
}

fn is_positive(m: [f64; 3]) -> bool {
    eigenvalues(m)[0] > POSITIVE
}

/// Eigenvalues of a symmetric matrix xx, xy, yy, the smaller first.
fn eigenvalues([a, b, c]: [f64; 3]) -> [f64; 2] {
    let middle = 0.5 * (a + c);
    let half = (0.5 * (a - c)).hypot(b);
    [middle - half, middle + half]
}

fn inverse([a, b, c]: [f64; 3]) -> [f64; 3] {
    let determinant = a * c - b * b;
    [c / determinant, -b / determinant, a / determinant]
}
