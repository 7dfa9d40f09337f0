//! Two-level preconditioner of an assembled stiffness whose first unknowns are
//! P1 and the others bubbles: block Gauss-Seidel on the bubbles, the P1 solver,
//! block Gauss-Seidel on the bubbles in reverse.
//!
//! Symmetric and positive definite when the P1 solver is. One application costs
//! two passes over the rows of the bubbles and one P1 solve; it is sequential
//! but for that, and its bits do not depend on the number of threads. Rows of
//! held bubbles are the identity.

use std::sync::Arc;

use crate::linalg::{Preconditioner, SparseRows, Workspace};

/// See the module.
pub(crate) struct BubblesAndP1 {
    /// A with nothing eliminated `[unknowns, unknowns]`.
    stiffness: Arc<SparseRows>,
    /// Number of P1 unknowns, which stand before those of the bubbles.
    first: usize,
    /// Number of bubbles of one diagonal block: the components of a cell bubble, or one
    /// facet bubble.
    block: usize,
    /// Inverted diagonal blocks of the bubbles, row-major `[blocks][block, block]`.
    inverse: Vec<f64>,
    /// Whether supports hold an unknown `[unknowns]`; held ones are copied through.
    is_held: Vec<bool>,
    /// Approximate inverse of the P1 block.
    p1: Arc<dyn Preconditioner>,
}

impl BubblesAndP1 {
    /// `first` unknowns are P1, `block` bubbles (at most three) are eliminated at once;
    /// `is_held` has a flag for every unknown.
    pub(crate) fn new(
        stiffness: Arc<SparseRows>,
        first: usize,
        block: usize,
        is_held: Vec<bool>,
        p1: Arc<dyn Preconditioner>,
    ) -> Self {
        let mut made = Self {
            stiffness,
            first,
            block,
            inverse: Vec::new(),
            is_held,
            p1,
        };
        let starts = (first..made.is_held.len()).step_by(block);
        made.inverse = starts.flat_map(|start| made.inverse_block(start)).collect();
        made
    }

    /// Bytes held beside the stiffness and the P1 solver.
    pub(crate) fn bytes(&self) -> u64 {
        (8 * self.inverse.len() + self.is_held.len()) as u64
    }

    /// Inverse of the diagonal block that begins at unknown `start` `[block, block]`,
    /// row-major; the identity in held components.
    fn inverse_block(&self, start: usize) -> Vec<f64> {
        let size = self.block;
        let mut matrix = vec![0.0; size * size];
        for i in 0..size {
            let (columns, values) = self.stiffness.row(start + i);
            for (&column, value) in columns.iter().zip(values) {
                let j = (column as usize).wrapping_sub(start);
                if j < size {
                    matrix[i * size + j] = *value;
                }
            }
        }
        invert(&mut matrix, size);
        matrix
    }

    /// z += D^-1 (r - A z) on one block of bubbles.
    fn relax(&self, start: usize, r: &[f64], z: &mut [f64]) {
        let size = self.block;
        let mut residual = [0.0; 3];
        for (i, value) in residual[..size].iter_mut().enumerate() {
            let (columns, entries) = self.stiffness.row(start + i);
            let products = columns.iter().zip(entries).map(|(&k, a)| a * z[k as usize]);
            *value = r[start + i] - products.sum::<f64>();
        }
        let first = (start - self.first) * size;
        let inverse = &self.inverse[first..first + size * size];
        for (i, row) in inverse.chunks_exact(size).enumerate() {
            let step: f64 = row.iter().zip(&residual).map(|(a, b)| a * b).sum();
            z[start + i] = match self.is_held[start + i] {
                true => r[start + i],
                false => z[start + i] + step,
            };
        }
    }

    /// Takes what the bubbles do off the force on P1.
    fn subtract_bubbles(&self, z: &[f64], force: &mut [f64]) {
        for (bubble, value) in z.iter().enumerate().skip(self.first) {
            if *value == 0.0 {
                continue;
            }
            let (columns, entries) = self.stiffness.row(bubble);
            for (&column, entry) in columns.iter().zip(entries) {
                let Some(slot) = force.get_mut(column as usize) else {
                    break;
                };
                *slot -= entry * value;
            }
        }
    }
}

impl Preconditioner for BubblesAndP1 {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        z.fill(0.0);
        for start in (self.first..r.len()).step_by(self.block) {
            self.relax(start, r, z);
        }
        let mut force = work.copy(&r[..self.first]);
        self.subtract_bubbles(z, &mut force);
        for (index, value) in force.iter_mut().enumerate() {
            if self.is_held[index] {
                *value = r[index];
            }
        }
        self.p1.apply(&force, &mut z[..self.first], work);
        work.give(force);
        for start in (self.first..r.len()).step_by(self.block).rev() {
            self.relax(start, r, z);
        }
    }
}

/// Inverts a small positive definite matrix in place (Gauss-Jordan).
fn invert(matrix: &mut [f64], size: usize) {
    for k in 0..size {
        let pivot = 1.0 / matrix[k * size + k];
        matrix[k * size + k] = 1.0;
        for j in 0..size {
            matrix[k * size + j] *= pivot;
        }
        for i in (0..size).filter(|&i| i != k) {
            let factor = matrix[i * size + k];
            matrix[i * size + k] = 0.0;
            for j in 0..size {
                matrix[i * size + j] -= factor * matrix[k * size + j];
            }
        }
    }
}

/// Inverse of a diagonal matrix: the metric of a pressure that is constant on cells.
pub(crate) struct Diagonal {
    /// Reciprocal of each diagonal entry.
    inverse: Vec<f64>,
}

impl Diagonal {
    /// Of the given entries, none of them zero.
    pub(crate) fn new(entries: &[f64]) -> Self {
        Self {
            inverse: entries.iter().map(|entry| 1.0 / entry).collect(),
        }
    }
}

impl Preconditioner for Diagonal {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        let terms = z.iter_mut().zip(r).zip(&self.inverse);
        terms.for_each(|((z, r), inverse)| *z = inverse * r);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::{dot, reproducible_noise};
    use crate::linalg::{LinearOperator, SparseRowsBuilder};

    /// A positive definite matrix of 3 P1 unknowns and 4 bubbles.
    fn stiffness() -> SparseRows {
        let mut builder = SparseRowsBuilder::new(7);
        for i in 0..7_u32 {
            let mut row: Vec<(u32, f64)> = (0..7_u32)
                .map(|j| {
                    let far = f64::from(i.abs_diff(j));
                    (j, 1.0 / (1.0 + far) + if i == j { 1.0 } else { 0.0 })
                })
                .collect();
            builder.push_row(&mut row);
        }
        builder.finish()
    }

    /// Solves exactly with the leading block.
    struct Leading(Vec<f64>);
    impl Preconditioner for Leading {
        fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
            for (i, row) in self.0.chunks_exact(3).enumerate() {
                z[i] = row.iter().zip(r).map(|(a, b)| a * b).sum();
            }
        }
    }

    fn preconditioner(block: usize, is_held: Vec<bool>) -> BubblesAndP1 {
        let matrix = stiffness();
        let mut leading: Vec<f64> = (0..3).flat_map(|i| matrix.row(i).1[..3].to_vec()).collect();
        invert(&mut leading, 3);
        BubblesAndP1::new(
            Arc::new(matrix),
            3,
            block,
            is_held,
            Arc::new(Leading(leading)),
        )
    }

    #[test]
    fn it_is_symmetric_and_contracts() {
        let mut work = Workspace::new();
        for block in [1, 2] {
            let made = preconditioner(block, vec![false; 7]);
            let x = reproducible_noise(7);
            let y: Vec<f64> = x.iter().rev().copied().collect();
            let (mut px, mut py) = (vec![0.0; 7], vec![0.0; 7]);
            made.apply(&x, &mut px, &mut work);
            made.apply(&y, &mut py, &mut work);
            assert!((dot(&px, &y) - dot(&py, &x)).abs() < 1e-14);
            let mut ax = vec![0.0; 7];
            made.stiffness.apply(&x, &mut ax, &mut work);
            made.apply(&ax, &mut px, &mut work);
            let left: f64 = px.iter().zip(&x).map(|(p, x)| (p - x).powi(2)).sum();
            assert!(left < 0.05 * dot(&x, &x), "{left}");
        }
    }

    #[test]
    fn held_bubbles_keep_their_residual() {
        let mut is_held = vec![false; 7];
        is_held[5] = true;
        let made = preconditioner(1, is_held);
        let mut z = vec![0.0; 7];
        made.apply(&reproducible_noise(7), &mut z, &mut Workspace::new());
        assert_eq!(z[5].to_bits(), reproducible_noise(7)[5].to_bits());
    }
}
