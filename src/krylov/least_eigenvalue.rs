//! The least eigenvalue of a symmetric operator beside its preconditioner,
//!
//! ```text
//! K x = l M x,   M^-1 the preconditioner
//! ```
//!
//! by the Lanczos process that preconditioned conjugate gradients carry out (Golub and Van
//! Loan, Matrix Computations, 10.1 to 10.3). A Ritz value is never below the least
//! eigenvalue, so that a negative one proves that this is negative; how likely a lower one has not
//! shown yet is bounded by Kuczynski and Wozniakowski (SIAM J. Matrix Anal. Appl. 13, 1992). Cost: a product and an application a step, a vector kept for each.

use crate::linalg::eigen::least_of_tridiagonal;
use crate::linalg::vector::{add_scaled, dot, scale, scale_and_add};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};

/// Steps before a Ritz value is believed: fewer see the motions of short waves only.
const FIRST_STEPS: usize = 8;
/// Probability that a lower eigenvalue has not shown, at most.
const MISSED: f64 = 1e-3;
/// Residual of the least Ritz pair over its value at which it is found.
const RESIDUAL: f64 = 0.25;

/// What the process says.
#[derive(Clone, Debug, PartialEq)]
pub enum Least {
    /// All eigenvalues are positive, but for a probability of a thousandth; the vector of the least
    /// one, of unit length in M, and its value.
    Positive(Vec<f64>, f64),
    /// A vector along which the operator is negative, the least one where the steps sufficed.
    Negative(Vec<f64>),
    /// No eigenvalue has been found within the steps; the vector of the least Ritz value.
    NotFound(Vec<f64>),
    /// Stopped, or a number was not finite.
    Nothing,
}

/// The process for one operator.
pub struct LeastEigenvalue<'a> {
    /// K, symmetric.
    pub operator: &'a dyn LinearOperator,
    /// M^-1, symmetric, positive definite and fixed.
    pub preconditioner: &'a dyn Preconditioner,
    /// Steps at most.
    pub steps: usize,
}

/// An eigenpair of T.
struct Ritz {
    value: f64,
    /// Its vector of unit length in the basis.
    shares: Vec<f64>,
    /// Whether an eigenvalue of K is near.
    is_found: bool,
}

/// What the steps leave: T, and the vectors in which it stands for K.
#[derive(Default)]
struct Basis {
    /// Diagonal of T.
    diagonal: Vec<f64>,
    /// Entries beside it, the last one to the vector that comes next.
    beside: Vec<f64>,
    /// Vectors of unit length in M.
    vectors: Vec<Vec<f64>>,
}

impl Basis {
    /// The least Ritz pair.
    fn least(&self) -> Option<Ritz> {
        let (extremes, shares) = least_of_tridiagonal(&self.diagonal, &self.beside)?;
        let value = extremes[0];
        let residual = (self.beside.last()? * shares.last()?).abs();
        let is_certain = value < 0.0 || self.is_unlikely_missed(extremes);
        Some(Ritz {
            is_found: is_certain && residual <= RESIDUAL * value.abs(),
            value,
            shares,
        })
    }

    /// Whether the least Ritz value is known well enough.
    fn is_settled(&self) -> bool {
        let has_begun = self.vectors.len() >= FIRST_STEPS;
        has_begun && self.least().is_some_and(|least| least.is_found)
    }

    /// Whether a lower eigenvalue than the positive Ritz value `least` below `largest` would have
    /// shown: the bound of the cited paper for starts without preference.
    fn is_unlikely_missed(&self, [least, largest]: [f64; 2]) -> bool {
        let (Some(first), steps) = (self.vectors.first(), self.vectors.len()) else {
            return false;
        };
        let rate = (least / largest).sqrt() * (2 * steps - 1) as f64;
        1.648 * (first.len() as f64).sqrt() * (-rate).exp() <= MISSED
    }

    /// What the steps say in all.
    fn verdict(&self, work: &mut Workspace) -> Least {
        let (Some(least), Some(first)) = (self.least(), self.vectors.first()) else {
            return Least::Nothing;
        };
        let mut sum = work.zeros(first.len());
        for (share, vector) in least.shares.iter().zip(&self.vectors) {
            add_scaled(&mut sum, *share, vector);
        }
        if least.value <= 0.0 || least.value.is_nan() {
            Least::Negative(sum)
        } else if least.is_found {
            Least::Positive(sum, least.value)
        } else {
            Least::NotFound(sum)
        }
    }
}

/// Conjugate gradients from the force r.
struct Process {
    /// r.
    residual: Vec<f64>,
    /// M^-1 r.
    residual_motion: Vec<f64>,
    /// Where the next step goes.
    direction: Vec<f64>,
    /// K times the direction.
    product: Vec<f64>,
    /// r . M^-1 r.
    square: f64,
    /// 1 / alpha and beta of the step before.
    before: (f64, f64),
}

impl LeastEigenvalue<'_> {
    /// Starts from the force `start`, zero where the body is held.
    pub fn solve(
        &self,
        start: Vec<f64>,
        stopped: &dyn Fn() -> bool,
        work: &mut Workspace,
    ) -> Least {
        let mut motion = work.zeros(start.len());
        self.preconditioner.apply(&start, &mut motion, work);
        let mut process = Process {
            square: dot(&start, &motion),
            direction: work.copy(&motion),
            product: work.zeros(start.len()),
            residual: start,
            residual_motion: motion,
            before: (0.0, 0.0),
        };
        let mut basis = Basis::default();
        let mut end = None;
        while end.is_none() && basis.vectors.len() < self.steps && !basis.is_settled() {
            end = if stopped() {
                Some(Least::Nothing)
            } else {
                self.step(&mut process, &mut basis, work)
            };
        }
        let end = end.unwrap_or_else(|| basis.verdict(work));
        let Process {
            residual_motion,
            direction,
            product,
            ..
        } = process;
        // The basis is dropped: a pool would keep its memory for good.
        let used = [residual_motion, direction, product].into_iter();
        used.for_each(|vector| work.give(vector));
        end
    }

    /// One step of the process; what it says at once, if anything.
    fn step(&self, at: &mut Process, basis: &mut Basis, work: &mut Workspace) -> Option<Least> {
        self.operator.apply(&at.direction, &mut at.product, work);
        let curvature = dot(&at.direction, &at.product);
        let is_finite = curvature.is_finite() && at.square.is_finite();
        if !is_finite || curvature == 0.0 || at.square <= 0.0 {
            return Some(Least::Nothing);
        }
        // With alternating signs of the vectors alpha alone gives its sign to the entries.
        let sign = if basis.vectors.len().is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let mut vector = at.residual_motion.clone();
        scale(&mut vector, sign / at.square.sqrt());
        basis.vectors.push(vector);
        let alpha = at.square / curvature;
        basis
            .diagonal
            .push(alpha.recip() + at.before.0 * at.before.1);
        add_scaled(&mut at.residual, -alpha, &at.product);
        self.preconditioner
            .apply(&at.residual, &mut at.residual_motion, work);
        let square = dot(&at.residual, &at.residual_motion);
        let beta = square / at.square;
        basis.beside.push(beta.max(0.0).sqrt() / alpha);
        scale_and_add(&mut at.direction, beta, &at.residual_motion);
        (at.square, at.before) = (square, (alpha.recip(), beta));
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::samples::Scaled;
    use crate::linalg::vector::reproducible_noise;
    use crate::linalg::{SparseRows, SparseRowsBuilder};

    fn diagonal(entries: &[f64]) -> SparseRows {
        let mut builder = SparseRowsBuilder::new(entries.len());
        for (row, &value) in entries.iter().enumerate() {
            builder.push_row(&mut [(row as u32, value)]);
        }
        builder.finish()
    }

    /// Of 200 eigenvalues between 1 and 3 and `least`.
    fn of(least: f64, steps: usize) -> (Least, Vec<f64>) {
        let mut entries: Vec<f64> = (0..200).map(|i| 1.0 + f64::from(i) / 100.0).collect();
        entries[77] = least;
        let process = LeastEigenvalue {
            operator: &diagonal(&entries),
            preconditioner: &Scaled(1.0),
            steps,
        };
        let start = reproducible_noise(entries.len());
        let least = process.solve(start, &|| false, &mut Workspace::new());
        (least, entries)
    }

    /// x . K x over x . x.
    fn quotient(x: &[f64], entries: &[f64]) -> f64 {
        let terms = x.iter().zip(entries).map(|(x, entry)| entry * x * x);
        terms.sum::<f64>() / dot(x, x)
    }

    #[test]
    fn a_small_positive_eigenvalue_is_found_with_its_vector() {
        let (least, entries) = of(0.1, 40);
        let Least::Positive(x, _) = least else {
            panic!("{least:?}");
        };
        assert!((quotient(&x, &entries) - 0.1).abs() < 0.02);
        assert!(x[77].powi(2) > 0.95 * dot(&x, &x));
    }

    #[test]
    fn a_small_negative_eigenvalue_is_never_taken_for_positive() {
        for least in [-1.0, -0.1, -0.01] {
            let (found, entries) = of(least, 60);
            let Least::Negative(x) = found else {
                panic!("{least} {found:?}");
            };
            assert!((quotient(&x, &entries) - least).abs() < 0.3 * least.abs());
        }
    }

    #[test]
    fn too_few_steps_say_nothing() {
        assert!(matches!(of(0.001, 4).0, Least::NotFound(_)));
    }
}
