//! Whether friction leaves a dense problem one solution. With K of the pressures n and the
//! tractions t, and m the coefficients,
//!
//! ```text
//! k = max over v >= 0 of  sum_i m_i v_i |(K_tn v)_i| / (v . K_nn v)
//! ```
//!
//! Below one K_nn + K_nt M S is positive for all directions S in which points may slip, and
//! pressures that wedge each other have none to hold. Ascent from an even v finds a k that is
//! the largest nearby, an estimate and no proof. From one on other starts of Newton's
//! method say whether there is another solution. References: A. Klarbring, Ingenieur-Archiv 60,
//! 1990; P. Ballard, J. Elasticity 56, 1999. Cost: a Cholesky factor of K_nn; where k is above
//! one some runs of Newton's method.

use super::friction::Newton;
use super::pivot::Pivots;
use super::{DenseProblem, DenseSolution};
use crate::linalg::vector::{dot, largest, norm};
use crate::linalg::{DenseCholesky, SymmetricMatrix};
use crate::saddle::{Cones, ProductSet, Status};

/// Steps towards the largest quotient, which is compared with one only.
const STEPS: usize = 30;
/// Steps of Newton's method from one start: a solution near it takes 4 to 8.
const MOST_STEPS: u32 = 8;
/// Difference of two solutions, over the larger, that is none.
const SAME: f64 = 1e-4;

/// How many solutions a problem may have.
#[derive(Clone, Debug, PartialEq)]
pub struct Uniqueness {
    /// k, as ascent finds it: below one another solution is not expected.
    pub indicator: f64,
    /// Another solution; none where none was found.
    pub other: Option<DenseSolution>,
}

/// How many solutions the problem has beside `known`; none where the set has no friction or
/// `matrix` is not positive definite.
pub fn uniqueness(
    matrix: &dyn SymmetricMatrix,
    linear: &[f64],
    set: ProductSet<'_>,
    known: &DenseSolution,
) -> Option<Uniqueness> {
    let (cones, first) = super::cones(&set)?;
    let problem = DenseProblem {
        matrix,
        linear,
        set,
    };
    let indicator = indicator(matrix, (cones, first))?;
    let other = if indicator >= 1.0 {
        other(&problem, (cones, first), known)
    } else {
        None
    };
    Some(Uniqueness { indicator, other })
}

/// k, from an even v.
fn indicator(matrix: &dyn SymmetricMatrix, (cones, first): (Cones<'_>, usize)) -> Option<f64> {
    let normals: Vec<usize> = (first..first + cones.normals).collect();
    let factor = DenseCholesky::new(&matrix.principal_part(&normals)).ok()?;
    let mut v = vec![1.0; normals.len()];
    let mut largest = 0.0_f64;
    for _ in 0..STEPS {
        let (quotient, mut slope) = quotient(matrix, (cones, first), &v);
        largest = largest.max(quotient);
        factor.solve(&mut slope);
        v = slope.iter().map(|value| value.max(0.0)).collect();
        let length = norm(&v);
        if length == 0.0 {
            break;
        }
        v.iter_mut().for_each(|value| *value /= length);
    }
    largest.is_finite().then_some(largest)
}

/// The quotient of k at `v` and half the slope of its numerator.
fn quotient(
    matrix: &dyn SymmetricMatrix,
    (cones, first): (Cones<'_>, usize),
    v: &[f64],
) -> (f64, Vec<f64>) {
    let normals = first..first + v.len();
    let width = cones.components.count();
    let mut x = vec![0.0; matrix.size()];
    let mut product = x.clone();
    x[normals.clone()].copy_from_slice(v);
    matrix.product(&x, &mut product);
    let resisted = dot(v, &product[normals.clone()]);
    let mut slope = vec![0.0; v.len()];
    x.fill(0.0);
    for (partner, bound, place) in cones.points() {
        let own = first + place..first + place + width;
        let size = norm(&product[own.clone()]);
        slope[partner] += 0.5 * bound.slope(f64::INFINITY) * size;
        if size > 0.0 {
            for index in own {
                x[index] = 0.5 * bound.slope(f64::INFINITY) * v[partner] * product[index] / size;
            }
        }
    }
    let wedged = 2.0 * dot(v, &slope);
    matrix.product(&x, &mut product);
    let back = slope.iter_mut().zip(&product[normals]);
    back.for_each(|(slope, value)| *slope += value);
    (wedged / resisted, slope)
}

/// A solution other than `known` that Newton's method finds from an open body, from one that
/// sticks and from ones that slip along each tangent.
fn other(
    problem: &DenseProblem<'_>,
    (cones, first): (Cones<'_>, usize),
    known: &DenseSolution,
) -> Option<DenseSolution> {
    let newton = Newton::new(problem, cones, first);
    let size = problem.linear.len();
    let all = vec![Status::Stick; size];
    let mut starts = vec![vec![0.0; size]];
    starts.extend(newton.first_step(&all));
    let mut pivots = Pivots::new(problem.set, &all);
    let pressed = pivots.solve(problem.matrix, problem.linear).ok();
    let pressed = pressed
        .filter(|x| newton.is_pressed(x))
        .or_else(|| starts.get(1).cloned());
    for axis in 0..cones.components.count() {
        for sign in [1.0, -1.0] {
            starts.extend(
                pressed
                    .as_ref()
                    .map(|x| slipping((cones, first), x, (axis, sign))),
            );
        }
    }
    let found = starts
        .into_iter()
        .filter_map(|start| newton.solved(start, MOST_STEPS));
    let scale = largest(&known.values);
    let differs = |found: &DenseSolution| {
        let pairs = found.values.iter().zip(&known.values);
        let change = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        change > SAME * scale.max(largest(&found.values))
    };
    found.into_iter().find(differs)
}

/// `pressed` with all tractions on the edge along one tangent.
fn slipping(
    (cones, first): (Cones<'_>, usize),
    pressed: &[f64],
    (axis, sign): (usize, f64),
) -> Vec<f64> {
    let mut x = pressed.to_vec();
    for (partner, bound, place) in cones.points() {
        let own = first + place..first + place + cones.components.count();
        x[own].fill(0.0);
        x[first + place + axis] = sign * bound.radius(pressed[first + partner]);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::DenseMatrix;
    use crate::saddle::{AdmissibleSet, Components, FrictionBound, SetPart};

    /// Klarbring's node: stiffness [1, 2; 2, 5] of tangent and normal, load (-0.55, -1), its
    /// compliance in the order of normal and tangent.
    fn node(coefficient: f64, test: impl Fn(&DenseMatrix, &[f64], ProductSet<'_>)) {
        let mut compliance = DenseMatrix::zeros(2, 2);
        for (row, column, value) in [(0, 0, 1.0), (0, 1, -2.0), (1, 0, -2.0), (1, 1, 5.0)] {
            *compliance.at_mut(row, column) = value;
        }
        let bounds = [FrictionBound::Coulomb(coefficient)];
        let cones = Cones {
            normals: 1,
            partners: &[0],
            bounds: &bounds,
            components: Components::One,
        };
        let part = SetPart {
            size: 2,
            set: AdmissibleSet::Cones(cones),
        };
        test(&compliance, &[0.1, -0.75], ProductSet::Uniform(part));
    }

    fn with(values: [f64; 2]) -> DenseSolution {
        DenseSolution {
            values: values.to_vec(),
            ..DenseSolution::default()
        }
    }

    #[test]
    fn a_node_that_wedges_has_other_solutions_beside_each_of_its_own() {
        node(0.6, |matrix, linear, set| {
            for known in [[0.0, 0.0], [1.0, 0.55], [0.5, 0.3]] {
                let found = uniqueness(matrix, linear, set, &with(known)).expect("friction");
                assert!((found.indicator - 1.2).abs() < 1e-12, "{}", found.indicator);
                let other = found.other.expect("another solution").values;
                let is_one = [[0.0, 0.0], [1.0, 0.55], [0.5, 0.3]]
                    .iter()
                    .any(|one| (one[0] - other[0]).hypot(one[1] - other[1]) < 1e-9);
                assert!(is_one && (other[0] - known[0]).abs() > 0.1, "{other:?}");
            }
        });
    }

    #[test]
    fn a_node_that_slips_off_has_one_solution() {
        node(0.3, |matrix, linear, set| {
            let found = uniqueness(matrix, linear, set, &with([0.0, 0.0])).expect("friction");
            assert!((found.indicator - 0.6).abs() < 1e-12);
            assert_eq!(found.other, None);
        });
    }
}
