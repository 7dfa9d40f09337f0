//! Extreme eigenvalues of M^-1 A by the Lanczos process that preconditioned
//! conjugate gradients carry out, from a fixed start vector.
//!
//! Golub and Van Loan, Matrix Computations, section 10.2. Cost: one operator
//! and one preconditioner application per step. The extreme Ritz values lie
//! inside the spectrum, so the largest is a lower bound.

use crate::linalg::vector::{add_scaled, dot, reproducible_noise, scale_and_add};
use crate::linalg::{Held, LinearOperator, Preconditioner, Workspace};

/// Smallest and largest Ritz value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Smallest Ritz value, at least the smallest eigenvalue.
    pub smallest: f64,
    /// Largest Ritz value, at most the largest eigenvalue.
    pub largest: f64,
}

/// The Lanczos process for M^-1 A.
pub struct Lanczos<'a> {
    /// A.
    pub operator: &'a dyn LinearOperator,
    /// M^-1.
    pub preconditioner: &'a dyn Preconditioner,
    /// Where all vectors vanish; none where nowhere.
    pub held: Option<&'a Held>,
    /// Its steps.
    pub steps: usize,
}

impl Lanczos<'_> {
    /// Smallest and largest Ritz value.
    pub fn interval(&self, work: &mut Workspace) -> Interval {
        let Self {
            operator,
            preconditioner,
            held,
            steps,
        } = *self;
        let mut r = reproducible_noise(operator.rows());
        if let Some(held) = held {
            held.mask(&mut r);
        }
        let mut z = work.zeros(r.len());
        preconditioner.apply(&r, &mut z, work);
        let mut p = work.copy(&z);
        let mut product = work.zeros(r.len());
        let mut rz = dot(&r, &z);
        let (mut diagonal, mut off) = (Vec::new(), Vec::new());
        let mut previous: Option<(f64, f64)> = None;
        for _ in 0..steps {
            operator.apply(&p, &mut product, work);
            let curvature = dot(&p, &product);
            if !(curvature > 0.0 && rz > 0.0) {
                break;
            }
            let alpha = rz / curvature;
            diagonal.push(1.0 / alpha + previous.map_or(0.0, |(alpha, beta)| beta / alpha));
            add_scaled(&mut r, -alpha, &product);
            preconditioner.apply(&r, &mut z, work);
            let next = dot(&r, &z);
            let beta = next / rz;
            off.push(beta.max(0.0).sqrt() / alpha);
            scale_and_add(&mut p, beta, &z);
            rz = next;
            previous = Some((alpha, beta));
        }
        work.give(z);
        work.give(p);
        work.give(product);
        tridiagonal_extremes(&diagonal, &off)
    }
}

/// Smallest and largest eigenvalue of a symmetric tridiagonal matrix by
/// bisection on Sturm counts.
fn tridiagonal_extremes(diagonal: &[f64], off: &[f64]) -> Interval {
    let size = diagonal.len();
    if size == 0 {
        return Interval {
            smallest: 1.0,
            largest: 1.0,
        };
    }
    let coupling = |i: usize| if i + 1 < size { off[i].abs() } else { 0.0 };
    let bound = (0..size)
        .map(|i| diagonal[i].abs() + coupling(i) + if i > 0 { coupling(i - 1) } else { 0.0 })
        .fold(0.0, f64::max);
    let below = |x: f64| {
        let mut count = 0;
        let mut pivot = 1.0;
        for i in 0..size {
            let square = if i > 0 { coupling(i - 1).powi(2) } else { 0.0 };
            pivot = diagonal[i] - x - square / pivot;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    };
    let bisect = |target: usize| {
        let (mut low, mut high) = (-bound, bound);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) >= target {
                high = middle;
            } else {
                low = middle;
            }
        }
        0.5 * (low + high)
    };
    Interval {
        smallest: bisect(1),
        largest: bisect(size),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::SparseRows;
    use crate::linalg::samples::Scaled;

    #[test]
    fn the_ritz_interval_reaches_the_ends_of_a_known_spectrum() {
        // Second differences with Dirichlet ends: eigenvalues 2 - 2 cos(k pi / 21).
        let n = 20;
        let cells: Vec<u32> = (0..n as u32 - 1).flat_map(|i| [i, i + 1]).collect();
        let mut matrix =
            SparseRows::assemble(n, &cells, 2, |_, i, j| if i == j { 1.0 } else { -1.0 });
        for row in [0, n - 1] {
            let mut entries: Vec<(u32, f64)> = Vec::new();
            let (columns, values) = matrix.row(row);
            entries.extend(columns.iter().copied().zip(values.iter().copied()));
            entries.push((row as u32, 1.0));
            let mut builder = crate::linalg::SparseRowsBuilder::new(n);
            for other in 0..n {
                let (columns, values) = matrix.row(other);
                let mut kept: Vec<(u32, f64)> = columns
                    .iter()
                    .copied()
                    .zip(values.iter().copied())
                    .collect();
                builder.push_row(if other == row {
                    &mut entries
                } else {
                    &mut kept
                });
            }
            matrix = builder.finish();
        }
        let mut work = Workspace::new();
        let lanczos = Lanczos {
            operator: &matrix,
            preconditioner: &Scaled(1.0),
            held: None,
            steps: 20,
        };
        let interval = lanczos.interval(&mut work);
        let exact = |k: f64| 2.0 - 2.0 * (k * std::f64::consts::PI / 21.0).cos();
        assert!((interval.smallest - exact(1.0)).abs() < 1e-8);
        assert!((interval.largest - exact(20.0)).abs() < 1e-8);
    }
}
