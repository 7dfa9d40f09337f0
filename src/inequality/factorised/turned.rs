//! Motions that lower the energy, and a factor on which they raise it by as much:
//!
//! ```text
//! P K^-1 P^T v = t v,  t < 0        K' = K + sum 2 / |t| v v^T
//! K'^-1 = K^-1 - X T^-1 X^T,        X = K^-1 V,   T = V^T X + diag |t| / 2
//! ```
//!
//! P takes the displacement, scaled so that its diagonal is one. K' has the eigenvalue 1 / |t|
//! where K has 1 / t and is K elsewhere: a factor of a stable body that differs from the body by
//! as many columns as there are such motions, so that a Krylov method needs that many iterations
//! more. V by Lanczos, orthogonalised twice: the wanted end of the spectrum has no other values.
//! (By blocks, whose solutions are cheaper, it takes twice as many vectors and more time.)
//! Inertia tells how many there are. References: B. Parlett, The Symmetric Eigenvalue Problem,
//! chapter 13; J. Nocedal and S. Wright, Numerical Optimization, 3.4. Cost: one solution with the
//! factor for each step, some four for each motion.

use crate::linalg::eigen::symmetric;
use crate::linalg::indefinite::SparseIndefinite;
use crate::linalg::vector::{add_scaled, dot, norm, reproducible_noise, scale};
use crate::linalg::{DenseLu, DenseMatrix, Workspace};

/// Steps of Lanczos at most: an X-ring takes 13 in the mean, a belt 34, a breast 37.
const MOST_STEPS: usize = 120;
/// Steps from one look at the values to the next.
const LOOK: usize = 6;
/// Residual of a vector over its value with which it serves: what is missed is another column.
const SHARP: f64 = 0.1;
/// Length of what is left of a vector, over its length before, that is rounding in 64 bits.
const NOTHING: f64 = 1e-12;

/// What makes K' of K.
#[derive(Debug)]
pub(super) struct Turned {
    /// V `[motions][displacement]`, scaled.
    motions: Vec<Vec<f64>>,
    /// X `[motions][size]`, scaled.
    moved: Vec<Vec<f64>>,
    /// T.
    small: DenseLu,
}

impl Turned {
    /// For the `count` motions of a factor of `size` unknowns, the first ones displacements
    /// `[displacements]`; none where they are not found.
    pub(super) fn new(
        factor: &SparseIndefinite,
        [displacements, size]: [usize; 2],
        count: usize,
        work: &mut Workspace,
    ) -> Option<Self> {
        let motions = Lanczos::new([displacements, size]).negative(factor, count, work)?;
        let solved = |motion: &Vec<f64>| solution(factor, motion, size, work);
        let moved: Vec<Vec<f64>> = motions.iter().map(solved).collect();
        let mut small = DenseMatrix::zeros(count, count);
        for (j, moved) in moved.iter().enumerate() {
            for (i, motion) in motions.iter().enumerate() {
                let value = dot(motion, &moved[..displacements]);
                *small.at_mut(i, j) = if i == j { 0.5 * value } else { value };
            }
        }
        Some(Self {
            small: DenseLu::new(&small).ok()?,
            motions,
            moved,
        })
    }

    /// Makes K'^-1 f of `solution` = K^-1 f `[size]`.
    pub(super) fn correct(&self, solution: &mut [f64]) {
        let part = |motion: &Vec<f64>| dot(motion, &solution[..motion.len()]);
        let mut parts: Vec<f64> = self.motions.iter().map(part).collect();
        self.small.solve(&mut parts);
        for (moved, part) in self.moved.iter().zip(parts) {
            add_scaled(solution, -part, moved);
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let vectors = self.motions.iter().chain(&self.moved);
        vectors.map(|vector| 8 * vector.len() as u64).sum()
    }
}

/// K^-1 of a displacement `[size]`.
fn solution(
    factor: &SparseIndefinite,
    motion: &[f64],
    size: usize,
    work: &mut Workspace,
) -> Vec<f64> {
    let mut x = vec![0.0; size];
    x[..motion.len()].copy_from_slice(motion);
    factor.solve(&mut x, work);
    x
}

/// Lanczos steps of P K^-1 P^T.
struct Lanczos {
    /// Orthonormal vectors `[steps + 1][displacement]`.
    basis: Vec<Vec<f64>>,
    /// The matrix in the basis: its diagonal `[steps]` and what stands beside it `[steps]`.
    projected: [Vec<f64>; 2],
    /// Unknowns of the factor.
    size: usize,
}

impl Lanczos {
    /// From a vector that excites all motions; to begin with those of an earlier factor saves no
    /// more than a tenth of the steps.
    fn new([displacements, size]: [usize; 2]) -> Self {
        let mut first = reproducible_noise(displacements);
        let length = norm(&first);
        scale(&mut first, 1.0 / length);
        Self {
            basis: vec![first],
            projected: [Vec::new(), Vec::new()],
            size,
        }
    }

    /// Vectors of the `count` negative values; none where they are not found.
    fn negative(
        mut self,
        factor: &SparseIndefinite,
        count: usize,
        work: &mut Workspace,
    ) -> Option<Vec<Vec<f64>>> {
        for step in 1..=MOST_STEPS {
            let goes_on = self.step(factor, work)?;
            let is_last = step == MOST_STEPS || !goes_on;
            if (is_last || step % LOOK == 0)
                && let Some(found) = self.found(count, is_last)
            {
                return Some(found);
            }
            if !goes_on {
                return None;
            }
        }
        None
    }

    /// Takes a step; whether there is another.
    fn step(&mut self, factor: &SparseIndefinite, work: &mut Workspace) -> Option<bool> {
        let last = self.basis.last()?;
        let mut next = solution(factor, last, self.size, work);
        next.truncate(last.len());
        let before = norm(&next);
        self.projected[0].push(dot(last, &next));
        for _ in 0..2 {
            for vector in &self.basis {
                let part = dot(vector, &next);
                add_scaled(&mut next, -part, vector);
            }
        }
        let length = norm(&next);
        self.projected[1].push(length);
        let goes_on = length > NOTHING * before && length.is_finite();
        if goes_on {
            scale(&mut next, 1.0 / length);
            self.basis.push(next);
        }
        Some(goes_on)
    }

    /// The vectors of negative values where they are `count`, and sharp enough unless it is the
    /// `last` look.
    fn found(&self, count: usize, is_last: bool) -> Option<Vec<Vec<f64>>> {
        let [diagonal, beside] = &self.projected;
        let steps = diagonal.len();
        let mut small = DenseMatrix::zeros(steps, steps);
        for (i, value) in diagonal.iter().enumerate() {
            *small.at_mut(i, i) = *value;
            if i + 1 < steps {
                (*small.at_mut(i, i + 1), *small.at_mut(i + 1, i)) = (beside[i], beside[i]);
            }
        }
        let vectors = symmetric(&small)?;
        let negative = vectors.iter().filter_map(|shares| {
            let mut product = vec![0.0; steps];
            small.multiply(shares, &mut product);
            let value = dot(shares, &product);
            (value < 0.0).then_some((shares, value))
        });
        let negative: Vec<_> = negative.collect();
        let is_sharp = |(shares, value): &(&Vec<f64>, f64)| {
            (beside[steps - 1] * shares[steps - 1]).abs() <= SHARP * value.abs()
        };
        let serves = negative.len() == count && (is_last || negative.iter().all(is_sharp));
        let vector = |(shares, _): &(&Vec<f64>, f64)| self.combined(shares);
        serves.then(|| negative.iter().map(vector).collect())
    }

    /// The basis times `shares`.
    fn combined(&self, shares: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.basis.first().map_or(0, Vec::len)];
        for (share, vector) in shares.iter().zip(&self.basis) {
            add_scaled(&mut sum, *share, vector);
        }
        sum
    }
}
