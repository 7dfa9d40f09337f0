//! Where multipliers may be: the admissible sets, one file each, and their product.
//!
//! A multiplier x and the residual s of its constraint belong to
//!
//! ```text
//! min 1/2 x.K x + q.x,   x in the set,   s = q + K x:   -s in the normal cone at x
//! ```
//!
//! In contact x is a pressure and s a gap, in friction x is a traction and s a slip.
//!
//! | set | open | stick | slip |
//! |---|---|---|---|
//! | [`Free`](AdmissibleSet::Free) | never | always: s = 0 | never |
//! | [`NonNegative`](AdmissibleSet::NonNegative) | x = 0, s >= 0 | x > 0, s = 0 | never |
//! | [`Discs`] | the radius is zero, any s | in the disc, s = 0 | on its edge, s against x |
//! | [`Cones`] | pressures as half lines, tractions as discs whose radii follow from them |||
//!
//! A new set is a file beside these, a variant and an arm of [`AdmissibleSet`].

mod cones;
mod discs;
mod free;
mod non_negative;
mod product;
#[cfg(test)]
mod tests;

pub use cones::{Cones, FrictionBound};
pub use discs::{Components, Discs};
use free::Free;
use non_negative::NonNegative;
pub use product::{ProductSet, SetPart};

/// What a multiplier does at its place in the set. The multipliers of one disc share
/// one status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Status {
    /// The multiplier is zero: nothing acts, and the gap may be anything admissible.
    #[default]
    Open,
    /// The constraint holds as an equation: the multiplier is unknown, the residual
    /// zero. Contact without friction that is closed is this one.
    Stick,
    /// The multiplier is on the edge of its set, the residual against it.
    Slip,
}

impl Status {
    /// Whether the multiplier is at work.
    pub fn is_closed(self) -> bool {
        match self {
            Self::Open => false,
            Self::Stick | Self::Slip => true,
        }
    }

    /// Closed where `is_closed`, for a multiplier without friction.
    pub fn of_contact(is_closed: bool) -> Self {
        if is_closed { Self::Stick } else { Self::Open }
    }
}

/// An admissible set for a run of multipliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AdmissibleSet<'a> {
    /// Any value: a constraint in both directions, such as a bilateral support.
    Free,
    /// x >= 0: contact, which pushes and never pulls.
    NonNegative,
    /// |x_i| <= r_i point by point: friction with given thresholds.
    Discs(Discs<'a>),
    /// Pressures, and tractions of friction whose thresholds follow from them.
    Cones(Cones<'a>),
}

/// Multipliers, residuals and statuses of the same constraints.
#[derive(Clone, Copy, Debug)]
pub struct SetPoint<'a> {
    /// Multipliers x `[multipliers]`.
    pub multiplier: &'a [f64],
    /// Residuals s of their constraints `[multipliers]`.
    pub residual: &'a [f64],
    /// What each multiplier does `[multipliers]`.
    pub status: &'a [Status],
}

/// How a small problem over the set is solved.
pub enum Kind<'s> {
    /// Each multiplier has a line to itself: always an unknown.
    Line,
    /// Each multiplier has the half line from zero: by pivots.
    HalfLine,
    /// Point after point, each exactly, in sweeps over all points.
    Points(&'s dyn PointSet),
    /// Pressures and tractions together, by Newton's method.
    Cones(Cones<'s>),
}

/// min 1/2 t.K t + b.t of one point; of a point with one number the first ones are
/// read.
#[derive(Clone, Copy, Debug)]
pub struct PairProblem {
    /// K, symmetric and positive definite `[2, 2]`.
    pub matrix: [[f64; 2]; 2],
    /// b, the linear term `[2]`.
    pub linear: [f64; 2],
}

/// A set that is a product over points.
pub trait PointSet {
    /// Numbers of a point: one or two.
    fn width(&self) -> usize;

    /// The minimum over the set of that point.
    fn minimise(&self, point: usize, problem: &PairProblem) -> [f64; 2];
}

/// What a convex set must tell. No answer hides a value that is not a number.
pub trait Admissible {
    /// Moves x to the nearest point of the set.
    fn project(&self, x: &mut [f64]);

    /// What each multiplier that is already in the set does.
    fn status(&self, x: &[f64], status: &mut [Status]);

    /// What of the residual contradicts the status; zero at a solution.
    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]);

    /// The longest step along `direction` that stays in the set, from within.
    fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64;

    /// How a small problem over the set is solved.
    fn kind(&self) -> Kind<'_>;

    /// x less its projection: zero within the set.
    fn violation(&self, x: &[f64], violation: &mut [f64]) {
        violation.copy_from_slice(x);
        self.project(violation);
        violation.iter_mut().zip(x).for_each(|(v, x)| *v = x - *v);
    }

    /// Takes from x what rounding left of a multiplier that `change` brought to the
    /// edge of the set.
    fn drop_rounding(&self, _x: &mut [f64], _change: &[f64]) {}
}

impl AdmissibleSet<'_> {
    /// The set's rules.
    fn rules(&self) -> &dyn Admissible {
        match self {
            Self::Free => &Free,
            Self::NonNegative => &NonNegative,
            Self::Discs(discs) => discs,
            Self::Cones(cones) => cones,
        }
    }
}

impl Admissible for AdmissibleSet<'_> {
    fn project(&self, x: &mut [f64]) {
        self.rules().project(x);
    }

    fn status(&self, x: &[f64], status: &mut [Status]) {
        self.rules().status(x, status);
    }

    fn misfit(&self, at: SetPoint<'_>, misfit: &mut [f64]) {
        self.rules().misfit(at, misfit);
    }

    fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        self.rules().longest_step(x, direction)
    }

    fn kind(&self) -> Kind<'_> {
        self.rules().kind()
    }

    fn violation(&self, x: &[f64], violation: &mut [f64]) {
        self.rules().violation(x, violation);
    }

    fn drop_rounding(&self, x: &mut [f64], change: &[f64]) {
        self.rules().drop_rounding(x, change);
    }
}
