//! Pressures and tractions of friction together, by a semismooth Newton method:
//!
//! ```text
//! s = q + K x
//! n >= 0, s_n >= 0, n s_n = 0;   |t| <= r(n);   s_t = 0 in the disc, t = -r(n) s_t / |s_t| on its edge
//! ```
//!
//! With d = t - rho s_t and b = r(n - rho s_n) a point sticks where |d| < b, where s_t = 0 is
//! solved, and slips elsewhere, where |d| t = b d is. The derivative of the latter is the one
//! that S. Hueber, G. Stadler and B. Wohlmuth (SIAM J. Sci. Comput. 30, 2008) keep positive far
//! from the solution:
//!
//! ```text
//! (I - M) t' + rho M s_t(x') - mu n' e = -M d + r_0 e,   M = b / |d| (I - beta t e^T / max(b, |t|)),  e = d / |d|
//! ```
//!
//! Where r is min(b, k n) with a steep k the gap at n <= b / k moves with the traction, and the
//! prediction is (k n - rho s_n) / k. What no steps between open and pressed end is sought with
//! all of what is between: up to b the traction changes, from there the pressure.
//!
//! It starts from the present multipliers, then from all that is closed sticking. Usually 4 to
//! 8 steps, each one LU factor of the closed part or, on many points, some Krylov iterations
//! (`system`).

mod slip;
mod system;

use slip::SlipRow;

use super::pivot::Pivots;
use super::{DenseConeError, DenseProblem, DenseSolution};
use crate::linalg::vector::{largest, norm};
use crate::linalg::{DenseLu, FactoriseError, SymmetricMatrix};
use crate::saddle::{
    Admissible, AdmissibleSet, Cones, FrictionBound, Kind, ProductSet, SetPart, Status,
};

/// Newton steps in a row; what takes more cycles.
const MOST_STEPS: u32 = 40;
/// Change of the multipliers, over the largest, after which the next step, whose error is
/// the square, is of rounding: a metric on a thousand points has no more digits, and what is
/// sought is a face.
const CLOSE: f64 = 1e-6;
/// The same on many points, where a step costs more than what it could still turn.
const CLOSE_ON_MANY: f64 = 1e-4;
/// Unknowns up to which a factor costs less than iterations.
const FEW: usize = 200;

/// The cones of a product and the first of their multipliers; none where it has none.
pub fn cones<'a>(set: &ProductSet<'a>) -> Option<(Cones<'a>, usize)> {
    let mut first = 0;
    for part in set.parts() {
        if let AdmissibleSet::Cones(cones) = part.set {
            return Some((cones, first));
        }
        first += part.size;
    }
    None
}

/// Solves the problem from `near`, where there is pressure, or from the solution without
/// friction; where that leads nowhere, from all that `guess` closes sticking.
///
/// # Errors
/// [`DenseConeError`] where K is not positive definite or no try converges.
pub(super) fn solve(
    problem: &DenseProblem<'_>,
    (cones, first): (Cones<'_>, usize),
    (guess, near): (&[Status], &[f64]),
) -> Result<DenseSolution, DenseConeError> {
    let mut newton = Newton::new(problem, cones, first);
    let start = if newton.is_pressed(near) {
        near.to_vec()
    } else {
        newton.without_friction(guess)?
    };
    if let Run::Solved(solution) = newton.run(start.clone(), MOST_STEPS)? {
        return Ok(solution);
    }
    if newton.given.iter().any(Option::is_some) {
        newton.search = Search::Between;
        if let Some(solution) = newton.solved(start, MOST_STEPS) {
            return Ok(DenseSolution {
                steps: solution.steps + MOST_STEPS,
                ..solution
            });
        }
        newton.search = Search::Sides;
    }
    match newton.run(newton.first_step(guess)?, MOST_STEPS)? {
        Run::Solved(solution) => Ok(DenseSolution {
            steps: solution.steps + MOST_STEPS,
            ..solution
        }),
        Run::Lost => Err(DenseConeError::NewtonLimit),
    }
}

/// The face that Newton's method goes on to from multipliers and residuals `at` of the true
/// problem, with the metric's diagonal in the place of its own: what sticks is unknown, what
/// slips has the direction of d.
pub(in crate::inequality) fn newton_face(
    matrix: &dyn SymmetricMatrix,
    set: ProductSet<'_>,
    (cones, first): (Cones<'_>, usize),
    at: (&[f64], &[f64]),
) -> DenseSolution {
    let problem = DenseProblem {
        matrix,
        linear: at.1,
        set,
    };
    let newton = Newton::new(&problem, cones, first);
    let sides = newton.sides(at.0, at.1);
    let mut next = DenseSolution {
        status: sides.iter().map(Side::status).collect(),
        values: vec![0.0; sides.len()],
        slip: vec![0.0; sides.len()],
        steps: 0,
    };
    for index in 0..sides.len() {
        if sides[index] == Side::On {
            next.values[index] = newton.predicted(index, at);
        }
    }
    for (number, point) in newton.points().enumerate() {
        if sides[point.first] != Side::Slips(number) {
            continue;
        }
        let pulled = newton.pulled(point, at);
        let bound = point.bound.radius(newton.predicted(point.partner, at));
        let length = norm(&pulled);
        let slip = (length - bound) / newton.point_step(point);
        for i in 0..newton.width() {
            next.values[point.first + i] = bound * pulled[i] / length;
            next.slip[point.first + i] = -slip * pulled[i] / length;
        }
    }
    next
}

/// How a row of Newton steps ended.
enum Run {
    /// At the solution.
    Solved(DenseSolution),
    /// Nowhere.
    Lost,
}

/// What a multiplier is in a Newton step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    /// Zero.
    Off,
    /// Unknown, its residual zero.
    On,
    /// Unknown, part of the point of that number, which slips.
    Slips(usize),
}

impl Side {
    fn status(&self) -> Status {
        match self {
            Side::Off => Status::Open,
            Side::On => Status::Stick,
            Side::Slips(_) => Status::Slip,
        }
    }
}

/// Change of the multipliers, over the largest, that ends Newton's method on such sides.
fn close_for(sides: &[Side]) -> f64 {
    if sides.iter().filter(|&&side| side != Side::Off).count() > FEW {
        CLOSE_ON_MANY
    } else {
        CLOSE
    }
}

/// Newton's method on one problem.
pub(super) struct Newton<'p> {
    problem: &'p DenseProblem<'p>,
    cones: Cones<'p>,
    /// First multiplier of the cones.
    first: usize,
    /// Diagonal of K `[multipliers]`.
    diagonal: Vec<f64>,
    /// Which multipliers any value is admissible for `[multipliers]`.
    is_free: Vec<bool>,
    /// The first point of each pressure whose bound is given `[multipliers]`.
    given: Vec<Option<Point>>,
    /// Where such points may end.
    search: Search,
}

/// Where points of a given bound may end.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Search {
    /// Open or pressed, and between where they begin there.
    Sides,
    /// Between, too.
    Between,
}

/// A point of friction at an iterate.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Its pressure among the multipliers.
    partner: usize,
    /// How far its traction may go.
    bound: FrictionBound,
    /// First of its tractions among the multipliers.
    first: usize,
}

impl<'p> Newton<'p> {
    pub(super) fn new(problem: &'p DenseProblem<'p>, cones: Cones<'p>, first: usize) -> Self {
        let size = problem.linear.len();
        let mut is_free = vec![false; size];
        for (set, range) in problem.set.ranges() {
            if let Kind::Line = set.kind() {
                is_free[range].fill(true);
            }
        }
        let mut newton = Self {
            diagonal: problem.matrix.diagonal(),
            problem,
            cones,
            first,
            is_free,
            given: vec![None; size],
            search: Search::Sides,
        };
        newton.given = newton.given_bounds();
        newton
    }

    /// The first point of each pressure whose bound is given `[multipliers]`.
    fn given_bounds(&self) -> Vec<Option<Point>> {
        let mut given = vec![None; self.is_free.len()];
        let has_given = |point: &Point| matches!(point.bound, FrictionBound::Tresca(_));
        for point in self.points().filter(has_given) {
            given[point.partner].get_or_insert(point);
        }
        given
    }

    /// The points with their places among all multipliers.
    fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.cones.points().map(|(partner, bound, first)| Point {
            partner: self.first + partner,
            bound,
            first: self.first + first,
        })
    }

    fn width(&self) -> usize {
        self.cones.components.count()
    }

    /// s = q + K x.
    fn residual(&self, x: &[f64]) -> Vec<f64> {
        let mut residual = vec![0.0; x.len()];
        self.problem.matrix.product(x, &mut residual);
        let linear = self.problem.linear.iter();
        residual.iter_mut().zip(linear).for_each(|(s, q)| *s += q);
        residual
    }

    /// Whether there is any pressure.
    pub(super) fn is_pressed(&self, x: &[f64]) -> bool {
        let pressures = &x[self.first..self.first + self.cones.normals];
        pressures.iter().any(|&pressure| pressure > 0.0)
    }

    /// The multipliers without tractions: from gaps alone far too many points would close.
    fn without_friction(&self, guess: &[Status]) -> Result<Vec<f64>, DenseConeError> {
        let radii = vec![0.0; self.cones.bounds.len()];
        let others = self.problem.set.parts().iter();
        let is_other = |part: &&SetPart<'_>| !matches!(part.set, AdmissibleSet::Cones(_));
        let mut parts: Vec<SetPart<'_>> = others.filter(is_other).copied().collect();
        // The cones come first.
        parts.splice(0..0, self.cones.with_given(&radii));
        let mut pivots = Pivots::new(ProductSet::Parts(&parts), guess);
        pivots.solve(self.problem.matrix, self.problem.linear)
    }

    /// The multipliers where all that `guess` closes sticks.
    pub(super) fn first_step(&self, guess: &[Status]) -> Result<Vec<f64>, DenseConeError> {
        let mut sides: Vec<Side> = guess
            .iter()
            .zip(&self.is_free)
            .map(|(status, &free)| {
                if free || status.is_closed() {
                    Side::On
                } else {
                    Side::Off
                }
            })
            .collect();
        for point in self.points() {
            let side = sides[point.partner];
            sides[point.first..point.first + self.width()].fill(side);
        }
        let zero = vec![0.0; guess.len()];
        Ok(self.step(&sides, (&zero, self.problem.linear))?)
    }

    /// Where up to `most` Newton steps from `x` lead; none where nowhere.
    pub(super) fn solved(&self, x: Vec<f64>, most: u32) -> Option<DenseSolution> {
        match self.run(x, most) {
            Ok(Run::Solved(solution)) => Some(solution),
            Ok(Run::Lost) | Err(_) => None,
        }
    }

    /// Newton steps from `x`, up to `most`.
    fn run(&self, mut x: Vec<f64>, most: u32) -> Result<Run, DenseConeError> {
        let mut last: Option<Vec<Side>> = None;
        for steps in 1..=most {
            let residual = self.residual(&x);
            let sides = self.sides(&x, &residual);
            let next = self.step(&sides, (&x, &residual))?;
            let change = x.iter().zip(&next).map(|(a, b)| (a - b).abs());
            let change = change.fold(0.0, f64::max);
            let is_same = last.as_ref() == Some(&sides);
            x = next;
            if is_same && change <= close_for(&sides) * largest(&x) {
                return Ok(Run::Solved(self.solution(x, &sides, steps)));
            }
            if !change.is_finite() {
                return Ok(Run::Lost);
            }
            last = Some(sides);
        }
        Ok(Run::Lost)
    }

    /// n - rho s_n of a pressure, or of its largest traction where there is next to none.
    fn predicted(&self, index: usize, (x, residual): (&[f64], &[f64])) -> f64 {
        let change = -residual[index] / self.diagonal[index];
        match self.given[index] {
            Some(point) if self.search == Search::Between || point.bound.is_between(x[index]) => {
                let traction = norm(&x[point.first..point.first + self.width()]);
                point.bound.moved((x[index], traction), change)
            }
            _ => x[index] + change,
        }
    }

    /// rho of a point.
    fn point_step(&self, point: Point) -> f64 {
        let own = self.diagonal[point.first..point.first + self.width()].iter();
        self.width() as f64 / own.sum::<f64>()
    }

    /// d = t - rho s_t of a point.
    fn pulled(&self, point: Point, (x, residual): (&[f64], &[f64])) -> [f64; 2] {
        let step = self.point_step(point);
        let mut pulled = [0.0; 2];
        for (i, value) in pulled.iter_mut().take(self.width()).enumerate() {
            *value = x[point.first + i] - step * residual[point.first + i];
        }
        pulled
    }

    /// What each multiplier is in the next step.
    fn sides(&self, x: &[f64], residual: &[f64]) -> Vec<Side> {
        let at = (x, residual);
        let mut sides = vec![Side::Off; x.len()];
        let normals = self.first..self.first + self.cones.normals;
        for (index, side) in sides.iter_mut().enumerate() {
            let is_on = self.is_free[index]
                || (normals.contains(&index) && self.predicted(index, at) > 0.0);
            if is_on {
                *side = Side::On;
            }
        }
        for (number, point) in self.points().enumerate() {
            let bound = point.bound.radius(self.predicted(point.partner, at));
            let is_off = sides[point.partner] == Side::Off || bound == 0.0;
            let side = match norm(&self.pulled(point, at)) < bound {
                _ if is_off => Side::Off,
                true => Side::On,
                false => Side::Slips(number),
            };
            sides[point.first..point.first + self.width()].fill(side);
        }
        sides
    }

    /// The multipliers after a step on given sides.
    fn step(&self, sides: &[Side], at: (&[f64], &[f64])) -> Result<Vec<f64>, FactoriseError> {
        let unknown = |&i: &usize| sides[i] != Side::Off;
        let selected: Vec<usize> = (0..sides.len()).filter(unknown).collect();
        let mut matrix = self.problem.matrix.part_again(&selected);
        let mut right: Vec<f64> = selected.iter().map(|&i| -self.problem.linear[i]).collect();
        let points = self.points().enumerate();
        let slips = points.filter(|(number, point)| sides[point.first] == Side::Slips(*number));
        let rows: Vec<SlipRow> = slips
            .map(|(_, point)| self.slip_row(point, &selected, at))
            .collect();
        let metric = if selected.len() > FEW {
            self.metric(&rows, (&selected, &matrix))
        } else {
            None
        };
        self.place(&rows, (&mut matrix, &mut right));
        let start: Vec<f64> = selected.iter().map(|&i| at.0[i]).collect();
        let solved = metric.and_then(|metric| metric.solve(&matrix, &right, start));
        match solved {
            Some(solution) => right = solution,
            None => DenseLu::new(&matrix)?.solve(&mut right),
        }
        let mut x = vec![0.0; sides.len()];
        for (&index, value) in selected.iter().zip(right) {
            x[index] = value;
        }
        Ok(x)
    }

    /// A solution with the statuses of its face: its values alone do not tell, a traction on
    /// the edge of its disc is inside of it by rounding.
    fn solution(&self, values: Vec<f64>, sides: &[Side], steps: u32) -> DenseSolution {
        DenseSolution {
            status: sides.iter().map(Side::status).collect(),
            slip: self.residual(&values),
            steps,
            values,
        }
    }
}
