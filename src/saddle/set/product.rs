//! The product of sets along one vector of multipliers.
//!
//! One dense metric couples all multipliers of contact; their sets differ part by
//! part: obstacles, tangential tractions, bilateral supports.

use super::{Admissible, AdmissibleSet, Kind, SetPoint, Status};
use std::ops::Range;

/// A run of multipliers and their set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetPart<'a> {
    /// Number of multipliers in the run.
    pub size: usize,
    /// The set in which they lie.
    pub set: AdmissibleSet<'a>,
}

/// Parts one after the other; their sizes add up to the vector's.
#[derive(Clone, Copy, Debug)]
pub enum ProductSet<'a> {
    /// One set for all multipliers.
    Uniform(SetPart<'a>),
    /// Several sets one after the other, in the order of the multipliers.
    Parts(&'a [SetPart<'a>]),
    /// Two sets one after the other.
    Pair([SetPart<'a>; 2]),
}

impl<'a> ProductSet<'a> {
    /// The parts in order.
    pub fn parts(&self) -> &[SetPart<'a>] {
        match self {
            Self::Uniform(part) => std::slice::from_ref(part),
            Self::Parts(parts) => parts,
            Self::Pair(parts) => parts,
        }
    }

    /// The parts with the multipliers that they hold.
    pub fn ranges(&self) -> impl Iterator<Item = (&AdmissibleSet<'a>, Range<usize>)> {
        let mut end = 0;
        self.parts().iter().map(move |part| {
            let start = end;
            end += part.size;
            (&part.set, start..end)
        })
    }

    /// Number of multipliers.
    pub fn size(&self) -> usize {
        self.parts().iter().map(|part| part.size).sum()
    }

    /// Whether all values are admissible.
    pub fn is_free(&self) -> bool {
        let mut parts = self.parts().iter();
        parts.all(|part| part.set == AdmissibleSet::Free)
    }

    /// Moves x to the nearest admissible point.
    pub fn project(&self, x: &mut [f64]) {
        for (set, range) in self.ranges() {
            set.project(&mut x[range]);
        }
    }

    /// x less its projection.
    pub fn violation(&self, x: &[f64]) -> Vec<f64> {
        let mut violation = vec![0.0; x.len()];
        for (set, range) in self.ranges() {
            set.violation(&x[range.clone()], &mut violation[range]);
        }
        violation
    }

    /// What each multiplier of an admissible x does.
    pub fn status(&self, x: &[f64]) -> Vec<Status> {
        let mut status = vec![Status::Open; x.len()];
        for (set, range) in self.ranges() {
            set.status(&x[range.clone()], &mut status[range]);
        }
        status
    }

    /// What of the residual contradicts the statuses.
    pub fn misfit(&self, at: SetPoint<'_>) -> Vec<f64> {
        let mut misfit = vec![0.0; at.residual.len()];
        for (set, range) in self.ranges() {
            set.misfit(at.part(range.clone()), &mut misfit[range]);
        }
        misfit
    }

    /// The longest step along `direction` that stays admissible, from within.
    pub fn longest_step(&self, x: &[f64], direction: &[f64]) -> f64 {
        self.ranges()
            .map(|(set, range)| set.longest_step(&x[range.clone()], &direction[range]))
            .fold(f64::INFINITY, f64::min)
    }

    /// Takes from x what rounding left of a multiplier that `change` brought to the
    /// edge of its set.
    pub fn drop_rounding(&self, x: &mut [f64], change: &[f64]) {
        for (set, range) in self.ranges() {
            set.drop_rounding(&mut x[range.clone()], &change[range]);
        }
    }

    /// The least admissible values, where nothing else bounds the set: zero or minus
    /// infinity. None for a set that has another shape.
    pub fn lower_bounds(&self) -> Option<Vec<f64>> {
        let mut bounds = Vec::with_capacity(self.size());
        for part in self.parts() {
            let bound = match part.set.kind() {
                Kind::Line => f64::NEG_INFINITY,
                Kind::HalfLine => 0.0,
                Kind::Points(_) | Kind::Cones(_) => return None,
            };
            bounds.resize(bounds.len() + part.size, bound);
        }
        Some(bounds)
    }
}

impl SetPoint<'_> {
    /// The first `count` multipliers, and the others.
    pub(super) fn split(&self, count: usize) -> (SetPoint<'_>, SetPoint<'_>) {
        let all = self.multiplier.len();
        (self.part(0..count), self.part(count..all))
    }

    /// The part of a point that belongs to a range of multipliers.
    fn part(&self, range: Range<usize>) -> SetPoint<'_> {
        SetPoint {
            multiplier: &self.multiplier[range.clone()],
            residual: &self.residual[range.clone()],
            status: &self.status[range],
        }
    }
}
