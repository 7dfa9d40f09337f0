//! |x_i| <= r_i point by point: tractions of friction whose thresholds are given
//! (Tresca); in the plane discs are intervals.

use super::{Admissible, Kind, PairProblem, PointSet, SetPoint, Status};
use crate::linalg::vector::dot;

/// A traction this near to the edge, over the radius, is on it.
const EDGE: f64 = 1e-12;
/// Steps of Newton's method on the multiplier of a disc; five are usual.
const MOST_STEPS: usize = 60;
/// Relative accuracy of that multiplier's disc.
const ACCURACY: f64 = 1e-15;

/// Numbers of a point's traction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Components {
    /// One number a point: in the plane there is one tangent.
    One,
    /// Two numbers a point: in space there are two tangents.
    Two,
}

impl Components {
    /// As a number.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }
}

/// Discs of given radii; the numbers of a point stand side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discs<'a> {
    /// r `[points]`; what is negative counts as zero.
    pub radii: &'a [f64],
    /// Numbers of a point, which stand side by side in the vector.
    pub components: Components,
}

impl Discs<'_> {
    /// Radius of the disc at a point; a negative one counts as zero, one that is not a
    /// number stays so.
    fn radius(&self, point: usize) -> f64 {
        let radius = self.radii[point];
        if radius < 0.0 { 0.0 } else { radius }
    }

    /// Points of `x`, each with its radius.
    fn points<'x>(&self, x: &'x [f64]) -> impl Iterator<Item = (f64, &'x [f64])> {
        let points = x.chunks_exact(self.components.count()).enumerate();
        points.map(|(index, point)| (self.radius(index), point))
    }
}

impl Admissible for Discs<'_> {
    fn project(&self, x: &mut [f64]) {
        let points = x.chunks_exact_mut(self.components.count()).enumerate();
        for (index, point) in points {
            let (radius, length) = (self.radius(index), length(point));
            if length > radius {
                // Divided first, an interval's end is met exactly.
                point.iter_mut().for_each(|v| *v = *v / length * radius);
            }
        }
    }

    fn status(&self, x: &[f64], status: &mut [Status]) {
        let statuses = status.chunks_exact_mut(self.components.count());
        for ((radius, point), status) in self.points(x).zip(statuses) {
            status.fill(match length(point) >= radius * (1.0 - EDGE) {
                _ if radius == 0.0 => Status::Open,
                true => Status::Slip,
                false => Status::Stick,
            });
        }
    }

    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]) {
        let width = self.components.count();
        misfit.copy_from_slice(at.residual);
        let points = misfit.chunks_exact_mut(width).enumerate();
        for (index, misfit) in points {
            match at.status[index * width] {
                Status::Open => misfit.fill(0.0),
                Status::Stick => (),
                Status::Slip => {
                    let traction = &at.multiplier[index * width..(index + 1) * width];
                    take_opposite_part(traction, misfit);
                }
            }
        }
    }

    fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        let width = self.components.count();
        let points = self.points(x).zip(direction.chunks_exact(width));
        points
            .map(|((radius, x), d)| step_to_edge(radius, x, d))
            .fold(f64::INFINITY, f64::min)
    }

    fn kind(&self) -> Kind<'_> {
        Kind::Points(self)
    }
}

impl PointSet for Discs<'_> {
    fn width(&self) -> usize {
        self.components.count()
    }

    fn minimise(&self, point: usize, problem: &PairProblem) -> [f64; 2] {
        let radius = self.radius(point);
        match self.components {
            Components::One => {
                let inside = -problem.linear[0] / problem.matrix[0][0];
                if inside.abs() > radius {
                    [radius.copysign(inside), 0.0]
                } else {
                    [inside, 0.0]
                }
            }
            Components::Two => on_disc(problem, radius),
        }
    }
}

/// Euclidean length of the numbers of a point, without overflow.
fn length(point: &[f64]) -> f64 {
    point.iter().fold(0.0, |length: f64, v| length.hypot(*v))
}

/// Takes off `residual` what points against `traction`: slip may.
fn take_opposite_part(traction: &[f64], residual: &mut [f64]) {
    let length = length(traction);
    let along = dot(traction, residual) / length;
    if along < 0.0 {
        for (residual, traction) in residual.iter_mut().zip(traction) {
            *residual -= along * (traction / length);
        }
    }
}

/// t >= 0 with |x + t d| = radius, of x in the disc.
fn step_to_edge(radius: f64, x: &[f64], d: &[f64]) -> f64 {
    let (square, product) = (dot(d, d), dot(x, d));
    if square == 0.0 {
        return f64::INFINITY;
    }
    let room = (radius * radius - dot(x, x)).max(0.0);
    let root = (product * product + square * room).sqrt();
    // Of the two forms of the root the one without cancellation.
    if product > 0.0 {
        room / (product + root)
    } else {
        (root - product) / square
    }
}

/// (K + m I) t = -b with m >= 0 and |t| <= radius, m zero within: Newton's method on
/// 1 / |t(m)| - 1 / radius, which is concave in m and so never steps too far
/// (J. More and D. Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983).
fn on_disc(problem: &PairProblem, radius: f64) -> [f64; 2] {
    if radius == 0.0 {
        return [0.0; 2];
    }
    let mut shift = 0.0;
    let mut traction = shifted(problem, shift, problem.linear.map(|b| -b));
    for _ in 0..MOST_STEPS {
        let length = length(&traction);
        if length.is_nan() || length <= radius * (1.0 + ACCURACY) {
            break;
        }
        let slope = dot(&traction, &shifted(problem, shift, traction));
        shift += (length / radius - 1.0) * length * length / slope;
        traction = shifted(problem, shift, problem.linear.map(|b| -b));
    }
    let length = length(&traction);
    if shift > 0.0 || length > radius {
        traction.map(|t| t / length * radius)
    } else {
        traction
    }
}

/// (K + m I)^-1 b.
fn shifted(problem: &PairProblem, shift: f64, right: [f64; 2]) -> [f64; 2] {
    let [[a, b], [c, d]] = problem.matrix;
    let (a, d) = (a + shift, d + shift);
    let determinant = a * d - b * c;
    [
        (d * right[0] - b * right[1]) / determinant,
        (a * right[1] - c * right[0]) / determinant,
    ]
}
