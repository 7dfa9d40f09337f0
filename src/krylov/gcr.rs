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
#[derive(Debug)]
pub struct Directions {
    pairs: std::collections::VecDeque<(Vec<f64>, Vec<f64>)>,
    most: usize,
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

    /// Directions and products of the group that begins at `first`, empty behind the last.
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
        for _ in 0..self.iterations {
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
    /// Length of its product behind the kept ones.
    length: f64,
    /// Square of the residual behind it.
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
        take_off_group(directions, first, direction, product);
    }
    let (kept, images) = directions.group(last);
    let overlaps = Overlaps::of(product, r, &images);
    let before = *before.get_or_insert(overlaps.square);
    let rest = overlaps.rest();
    if rest.is_nan() || rest <= MOST_LOST * MOST_LOST * before {
        return advance_with_care(directions, before.sqrt(), (direction, product), (x, r));
    }
    let length = rest.sqrt();
    let by = Combination {
        overlaps: &overlaps.kept,
        directions: kept,
        images,
        length,
        step: overlaps.along / length,
    };
    let step = Step {
        direction,
        product,
        x,
        r,
    };
    Taken {
        length,
        square: step.take(&by),
        is_spent: false,
    }
}

/// [`advance`] one operation after the other; `before` is the length that the product had.
fn advance_with_care(
    directions: &Directions,
    before: f64,
    (direction, product): (&mut [f64], &mut [f64]),
    (x, r): (&mut [f64], &mut [f64]),
) -> Taken {
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
            take_off_group(directions, first, direction, product);
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
fn take_off_group(
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
mod tests {
    use super::*;
    use crate::krylov::samples::Below;
    use crate::linalg::SparseRows;
    use crate::linalg::samples::{Scaled, rows};

    const PLAIN: Scaled = Scaled(1.0);

    /// Indefinite.
    fn saddle() -> SparseRows {
        rows(&[[2.0, 0.0, 1.0], [0.0, 3.0, 1.0], [1.0, 1.0, 0.0]])
    }

    #[test]
    fn an_indefinite_system_of_three_takes_three_directions() {
        let mut work = Workspace::new();
        let (mut x, mut r) = (vec![0.0; 3], vec![1.0, 2.0, 3.0]);
        let outcome = Gcr {
            operator: &saddle(),
            preconditioner: &PLAIN,
            directions: &mut Directions::default(),
            iterations: 4,
        }
        .solve((&mut x, &mut r), &mut Below::new(1e-12), &mut work);
        assert_eq!(outcome, Outcome::Stopped);
        let mut product = vec![0.0; 3];
        saddle().apply(&x, &mut product, &mut work);
        for (value, exact) in product.iter().zip([1.0, 2.0, 3.0]) {
            assert!((value - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn a_direction_that_changes_nothing_ends_as_stagnation() {
        struct Orthogonal;
        impl Preconditioner for Orthogonal {
            fn apply(&self, _r: &[f64], z: &mut [f64], _work: &mut Workspace) {
                // Its image (1, -3/2 + ..) is orthogonal to the residual below.
                z.copy_from_slice(&[0.0, 0.0, 1.0]);
            }
        }
        let (mut x, mut r) = (vec![0.0; 3], vec![0.0, 0.0, 1.0]);
        let outcome = Gcr {
            operator: &saddle(),
            preconditioner: &Orthogonal,
            directions: &mut Directions::default(),
            iterations: 50,
        }
        .solve(
            (&mut x, &mut r),
            &mut Below::new(1e-12),
            &mut Workspace::new(),
        );
        assert_eq!(outcome, Outcome::Stagnation);
    }

    #[test]
    fn a_turned_plane_is_solved_from_the_last_product() {
        // Every residual is orthogonal to its own image: no step from it helps.
        let quarter = rows(&[
            [0.0, -1.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, -2.0],
            [0.0, 0.0, 2.0, 0.0],
        ]);
        let (mut x, mut r) = (vec![0.0; 4], vec![1.0, 2.0, 3.0, -1.0]);
        let outcome = Gcr {
            operator: &quarter,
            preconditioner: &PLAIN,
            directions: &mut Directions::default(),
            iterations: 8,
        }
        .solve(
            (&mut x, &mut r),
            &mut Below::new(1e-12),
            &mut Workspace::new(),
        );
        assert_eq!(outcome, Outcome::Stopped);
        for (value, exact) in x.iter().zip([2.0, -1.0, -0.5, -1.5]) {
            assert!((value - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn kept_directions_solve_the_same_system_again_at_once() {
        let mut directions = Directions::default();
        let mut work = Workspace::new();
        let mut solve_for = |rhs: [f64; 3], most: usize, directions: &mut Directions| {
            let (mut x, mut r) = (vec![0.0; 3], rhs.to_vec());
            let stop = &mut Below::new(1e-12);
            Gcr {
                operator: &saddle(),
                preconditioner: &PLAIN,
                directions,
                iterations: most,
            }
            .solve((&mut x, &mut r), stop, &mut work);
            norm(&r)
        };
        assert!(solve_for([1.0, 2.0, 3.0], 4, &mut directions) < 1e-12);
        assert!(solve_for([-2.0, 0.5, 1.0], 0, &mut directions) < 1e-12);
    }

    /// Entries between 0.001 and one.
    struct Graded;

    impl LinearOperator for Graded {
        fn rows(&self) -> usize {
            300
        }

        fn columns(&self) -> usize {
            300
        }

        fn apply(&self, x: &[f64], y: &mut [f64], _work: &mut Workspace) {
            for (k, (y, x)) in y.iter_mut().zip(x).enumerate() {
                *y = (1.0 + k as f64) / 300.0 * x * 0.3_f64.powi((k % 3) as i32);
            }
        }

        fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
            self.apply(y, x, work);
        }
    }

    #[test]
    fn directions_of_an_earlier_load_cost_the_next_one_nothing() {
        let mut work = Workspace::new();
        let mut solve_for = |rhs: Vec<f64>, directions: &mut Directions| {
            let (mut x, mut r) = (vec![0.0; rhs.len()], rhs);
            let mut stop = Below::new(1e-9);
            Gcr {
                operator: &Graded,
                preconditioner: &PLAIN,
                directions,
                iterations: 2000,
            }
            .solve((&mut x, &mut r), &mut stop, &mut work);
            stop.iterations
        };
        let noise = crate::linalg::vector::reproducible_noise(300);
        let fresh = solve_for(noise.clone(), &mut Directions::default());
        let mut kept = Directions::default();
        solve_for(vec![1.0; 300], &mut kept);
        let warm = solve_for(noise, &mut kept);
        assert!(warm <= fresh, "{warm} against {fresh}");
    }

    #[test]
    fn adapted_directions_belong_to_the_new_operator() {
        let mut directions = Directions::default();
        let mut work = Workspace::new();
        let (mut x, mut r) = (vec![0.0; 3], vec![1.0, 2.0, 3.0]);
        let stop = &mut Below::new(1e-12);
        Gcr {
            operator: &saddle(),
            preconditioner: &PLAIN,
            directions: &mut directions,
            iterations: 4,
        }
        .solve((&mut x, &mut r), stop, &mut work);
        let kept = directions.pairs.len();
        assert_eq!(kept, 3);
        // The new operator is the old one plus e_1 e_3^T.
        directions.adapt(&mut work, |direction, product| product[0] += direction[2]);
        assert_eq!(directions.pairs.len(), kept);
        for (index, (direction, product)) in directions.pairs.iter().enumerate() {
            let mut image = vec![0.0; 3];
            saddle().apply(direction, &mut image, &mut work);
            image[0] += direction[2];
            for (a, b) in image.iter().zip(product) {
                assert!((a - b).abs() < 1e-12);
            }
            for (other, (_, its_product)) in directions.pairs.iter().enumerate() {
                let expected = f64::from(u8::from(index == other));
                assert!((dot(product, its_product) - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn directions_that_become_dependent_are_dropped() {
        let mut directions = Directions::default();
        let mut work = Workspace::new();
        let unit = |i: usize| {
            (0..3)
                .map(|j| f64::from(u8::from(i == j)))
                .collect::<Vec<_>>()
        };
        (0..3).for_each(|i| directions.push(unit(i), unit(i), &mut work));
        directions.adapt(&mut work, |_, product| {
            product[0] += product[2];
            product[2] = 0.0;
        });
        assert_eq!(directions.pairs.len(), 2);
    }

    #[test]
    fn no_more_than_ten_directions_are_kept() {
        let mut directions = Directions::default();
        let mut work = Workspace::new();
        (0..15).for_each(|_| directions.push(vec![0.0; 4], vec![0.0; 4], &mut work));
        assert_eq!(directions.pairs.len(), KEPT);
        assert_eq!(directions.bytes(), 16 * 4 * KEPT as u64);
        directions.clear(&mut work);
        assert_eq!(directions.bytes(), 0);
    }
}
