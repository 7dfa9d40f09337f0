//! Flexible generalised conjugate residuals, truncated to the last directions.
//!
//! Minimises the weighted norm of the residual over the kept directions;
//! Eisenstat, Elman and Schultz, SIAM J. Numer. Anal. 20, 1983. The
//! preconditioner may change from call to call. Per iteration: one product,
//! one preconditioner application, at most `kept + 2` reductions. A step that
//! changes next to nothing is detected: from some residuals a block-triangular
//! preconditioner produces a direction orthogonal to the residual. The residual
//! then stays, and so would the direction; the next one is made from the last
//! product instead (Orthodir; D. Young and K. Jea, Linear Algebra Appl. 34, 1980).

use super::sweeps::{Combination, GROUP, Overlaps, Step};
use super::{Monitor, Outcome, Verdict};
use crate::linalg::vector::{add_scaled, dot, dots, norm, scale, subtract_combination};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// Directions kept for orthogonalisation where nothing else is said, and what those of earlier
/// solves may add to them within a solve.
pub(crate) const KEPT: usize = 10;
/// A relative reduction below this counts as none.
const LEAST_REDUCTION: f64 = 1e-13;
/// A reduction of the squared residual below this takes the last product as the
/// source of the next direction, once: between 0.02 and 0.2 the counts are the
/// same, but many such steps in a row let the residual drift.
const STALL: f64 = 5e-2;
/// Iterations of a system that few directions serve; others take more of both.
const USUAL: usize = 24;
/// Successive iterations without reduction before giving up.
const PATIENCE: usize = 4;
/// A product that keeps less of its length is made orthogonal once more.
const MOST_LOST: f64 = 0.5;
/// A product this much shorter after orthogonalisation is rounding.
const SPENT: f64 = 1e-10;
/// A product this much shorter after orthogonalisation is dependent.
const DEPENDENT: f64 = 1e-8;

/// Directions and their products, kept between calls that continue the same
/// system.
#[derive(Clone, Debug)]
pub struct Directions {
    pairs: std::collections::VecDeque<(Vec<f64>, Vec<f64>)>,
    most: usize,
    /// What `most` grows to in a solve that takes more than [`USUAL`] iterations.
    ceiling: usize,
    /// Directions of earlier solves that stay until the present one ends, at most.
    most_pinned: usize,
    /// How many of the first do in the present one.
    pinned: usize,
}

impl Default for Directions {
    fn default() -> Self {
        Self::keeping(KEPT)
    }
}

impl Directions {
    /// None yet, and at most `most`: a system with a few eigenvalues far from the
    /// others takes as many more as there are of those.
    pub fn keeping(most: usize) -> Self {
        Self {
            pairs: std::collections::VecDeque::new(),
            most,
            ceiling: most,
            most_pinned: most,
            pinned: 0,
        }
    }

    /// The same for a system without symmetry, where those of earlier solves go first: there
    /// is no short recurrence that they would spoil.
    pub fn sliding(most: usize) -> Self {
        Self {
            most_pinned: 0,
            ..Self::keeping(most)
        }
    }

    /// At most `most`, but ten where a solve turns out a long one.
    pub fn starting_with(most: usize) -> Self {
        Self {
            ceiling: KEPT,
            ..Self::keeping(most)
        }
    }

    /// Keeps one more after a late iteration.
    fn grow(&mut self, iteration: usize) {
        if iteration >= USUAL && self.most < self.ceiling {
            self.most += 1;
        }
    }

    /// Forgets all directions, for a new system.
    pub fn clear(&mut self, work: &mut Workspace) {
        for (direction, product) in self.pairs.drain(..) {
            work.give(direction);
            work.give(product);
        }
        self.pinned = 0;
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.pairs
            .iter()
            .map(|(direction, _)| 16 * direction.len() as u64)
            .sum()
    }

    /// Lets `change` adapt every direction and its product to another
    /// operator, then makes the products orthonormal again. Directions that
    /// become dependent are dropped.
    pub fn adapt(&mut self, work: &mut Workspace, mut change: impl FnMut(&mut [f64], &mut [f64])) {
        for (mut direction, mut product) in std::mem::take(&mut self.pairs) {
            change(&mut direction, &mut product);
            let before = norm(&product);
            let length = orthogonalise(self, &mut direction, &mut product);
            if length > DEPENDENT * before {
                self.pairs.push_back((direction, product));
            } else {
                work.give(direction);
                work.give(product);
            }
        }
    }

    /// Forgets all but the last `most` directions.
    pub fn keep_last(&mut self, most: usize, work: &mut Workspace) {
        let spare = self.pairs.len().saturating_sub(most);
        for (direction, product) in self.pairs.drain(..spare) {
            work.give(direction);
            work.give(product);
        }
    }

    /// Takes off `r`, and adds to `x`, what the kept directions can.
    pub fn project(&self, x: &mut [f64], r: &mut [f64]) {
        for (direction, product) in &self.pairs {
            let step = dot(r, product);
            add_scaled(x, step, direction);
            add_scaled(r, -step, product);
        }
    }

    /// Directions and products of the group that begins at `first`, empty after the last.
    fn group(&self, first: usize) -> ([&[f64]; GROUP], [&[f64]; GROUP]) {
        let pair = |k: usize| self.pairs.get(first + k);
        (
            std::array::from_fn(|k| pair(k).map_or(&[][..], |pair| &pair.0)),
            std::array::from_fn(|k| pair(k).map_or(&[][..], |pair| &pair.1)),
        )
    }

    /// Adds a direction of the present solve in the place of its oldest.
    fn push(&mut self, direction: Vec<f64>, product: Vec<f64>, work: &mut Workspace) {
        if self.pairs.len() >= self.most + self.pinned.min(KEPT)
            && let Some((oldest, its_product)) = self.pairs.remove(self.pinned)
        {
            work.give(oldest);
            work.give(its_product);
        }
        self.pairs.push_back((direction, product));
    }
}

/// The method for one system.
pub struct Gcr<'a> {
    /// A.
    pub operator: &'a dyn LinearOperator,
    /// Its approximate inverse, which may change from call to call.
    pub preconditioner: &'a dyn Preconditioner,
    /// Those of the same A kept from earlier calls, and those kept from now on.
    pub directions: &'a mut Directions,
    /// Most iterations.
    pub iterations: usize,
}

impl Gcr<'_> {
    /// Improves `x` until the monitor stops; `r = b - A x` on entry and exit. Starts
    /// with the best combination of the directions kept from earlier calls, which stay to
    /// the end: a truncated method that drops them has not begun with its residual and
    /// converges by steps of no memory (M. Powell, Math. Programming 11, 1976).
    pub fn solve(
        mut self,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        self.directions.project(x, r);
        self.directions.pinned = self.directions.pairs.len().min(self.directions.most_pinned);
        let outcome = self.iterate((x, r), monitor, work);
        self.directions.pinned = 0;
        self.directions.keep_last(self.directions.most, work);
        outcome
    }

    /// Adds one direction after the other.
    fn iterate(
        &mut self,
        (x, r): (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let mut idle = 0;
        let mut stalled = false;
        let mut square = dot(r, r);
        for iteration in 0..self.iterations {
            let mut direction = self.direction(r, stalled, work);
            let mut product = work.scratch(r.len());
            self.operator.apply(&direction, &mut product, work);
            let taken = advance(self.directions, (&mut direction, &mut product), (x, r));
            if !(taken.length.is_finite() && square.is_finite()) {
                return Outcome::NotFinite;
            }
            if taken.is_spent {
                // The kept directions span the space: what is left is rounding.
                self.directions.clear(work);
                match monitor.judge(r) {
                    Verdict::Stop => return Outcome::Stopped,
                    Verdict::Continue => continue,
                }
            }
            if taken.length == 0.0 {
                return Outcome::Stagnation;
            }
            self.directions.grow(iteration);
            self.directions.push(direction, product, work);
            if monitor.judge(r) == Verdict::Stop {
                return Outcome::Stopped;
            }
            let next = taken.square;
            stalled = !stalled && next > square * (1.0 - STALL);
            idle = if next < square * (1.0 - LEAST_REDUCTION) {
                0
            } else {
                idle + 1
            };
            if idle == PATIENCE {
                return Outcome::Stagnation;
            }
            square = next;
        }
        Outcome::IterationLimit
    }

    /// The next direction, from the residual or, where that changes nothing, from the
    /// last product.
    fn direction(&self, r: &[f64], stalled: bool, work: &mut Workspace) -> Vec<f64> {
        let mut direction = work.scratch(r.len());
        let source = match self.directions.pairs.back() {
            Some((_, product)) if stalled => product,
            _ => r,
        };
        self.preconditioner.apply(source, &mut direction, work);
        direction
    }
}

/// What a step along a new direction was.
struct Taken {
    /// Length of its product after the kept ones.
    length: f64,
    /// Square of the residual after it.
    square: f64,
    /// Whether what is left of the product is rounding; then no step was made.
    is_spent: bool,
}

/// Makes a new pair orthonormal to the kept ones and takes the step along it: by two sweeps
/// where enough of its product is left, otherwise with care.
fn advance(
    directions: &Directions,
    (direction, product): (&mut [f64], &mut [f64]),
    (x, r): (&mut [f64], &mut [f64]),
) -> Taken {
    let last = directions.pairs.len().saturating_sub(1) / GROUP * GROUP;
    let mut before = (last > 0).then(|| dot(product, product));
    for first in (0..last).step_by(GROUP) {
        subtract_group(directions, first, direction, product);
    }
    let (kept, images) = directions.group(last);
    let overlaps = Overlaps::of(product, r, &images);
    let step = Step {
        direction,
        product,
        x,
        r,
    };
    let before = *before.get_or_insert(overlaps.square);
    let rest = overlaps.rest();
    if rest.is_nan() || rest <= MOST_LOST * MOST_LOST * before {
        return advance_with_care(directions, before.sqrt(), step);
    }
    let length = rest.sqrt();
    let by = Combination {
        overlaps: &overlaps.kept,
        directions: kept,
        images,
        length,
        step: overlaps.along / length,
    };
    Taken {
        length,
        square: step.take(&by),
        is_spent: false,
    }
}

/// [`advance`] one operation after the other; `before` is the length that the product had.
fn advance_with_care(directions: &Directions, before: f64, step: Step<'_>) -> Taken {
    let Step {
        direction,
        product,
        x,
        r,
    } = step;
    let length = orthogonalise(directions, direction, product);
    let is_spent = length < SPENT * before && !directions.pairs.is_empty();
    if length > 0.0 && length.is_finite() && !is_spent {
        let step = dot(r, product);
        add_scaled(x, step, direction);
        add_scaled(r, -step, product);
    }
    Taken {
        length,
        square: dot(r, r),
        is_spent,
    }
}

/// Makes `product` orthogonal to the kept products and of unit length; returns
/// its length before scaling. Classical Gram-Schmidt, which reads each kept vector
/// once, and again where little is left of the product (J. Daniel, W. Gragg, L.
/// Kaufman and G. Stewart, Math. Comp. 30, 1976).
fn orthogonalise(directions: &Directions, direction: &mut [f64], product: &mut [f64]) -> f64 {
    let mut length = norm(product);
    for _ in 0..2 {
        let before = length;
        for first in (0..directions.pairs.len()).step_by(GROUP) {
            subtract_group(directions, first, direction, product);
        }
        length = norm(product);
        if length > MOST_LOST * before || length.is_nan() {
            break;
        }
    }
    if length > 0.0 {
        scale(direction, 1.0 / length);
        scale(product, 1.0 / length);
    }
    length
}

/// Makes `product` orthogonal to the kept products of the group that begins at `first`.
fn subtract_group(
    directions: &Directions,
    first: usize,
    direction: &mut [f64],
    product: &mut [f64],
) {
    let (kept, images) = directions.group(first);
    let overlaps = dots(product, &images);
    subtract_combination(direction, &overlaps, &kept);
    subtract_combination(product, &overlaps, &images);
}

#[cfg(test)]
mod tests;
