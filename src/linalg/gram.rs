//! The factor G = L L^T of a Gram matrix, positive semi-definite, row by row.
//!
//! A vector that earlier ones make up, whose pivot is next to nothing of its diagonal, is left
//! out: its unknown is zero in every solution. With orthonormal vectors `q = L^-1 z` the
//! factor is what the process of Gram and Schmidt would leave, without touching the vectors
//! themselves. Cost: n^3 / 3 flops, n^2 / 2 numbers.

use super::DenseMatrix;
use super::vector::{add_scaled, dot};

/// Share of its diagonal below which a pivot is next to nothing.
const DEPENDENT: f64 = 1e-6;

/// L by rows, and the inverse pivots.
#[derive(Clone, Debug, Default)]
pub struct GramFactor {
    /// Rows of L left of the diagonal, one after the other.
    rows: Vec<f64>,
    /// One over each pivot, zero where a vector is left out `[size]`.
    inverse: Vec<f64>,
}

impl GramFactor {
    /// Of the lower triangle of `gram`.
    pub fn new(gram: &DenseMatrix) -> Self {
        let mut factor = Self::default();
        for i in 0..gram.rows() {
            let mut row = Vec::with_capacity(i);
            for j in 0..i {
                let left = gram.at(i, j) - dot(&row, factor.row(j));
                row.push(left * factor.inverse[j]);
            }
            let pivot = gram.at(i, i) - dot(&row, &row);
            let is_new = pivot > DEPENDENT * gram.at(i, i);
            factor
                .inverse
                .push(if is_new { pivot.sqrt().recip() } else { 0.0 });
            factor.rows.extend_from_slice(&row);
        }
        factor
    }

    /// Number of vectors.
    pub fn size(&self) -> usize {
        self.inverse.len()
    }

    /// A row of L left of its diagonal.
    fn row(&self, row: usize) -> &[f64] {
        let start = row * row.saturating_sub(1) / 2;
        &self.rows[start..start + row]
    }

    /// `L^-1 x` in place.
    pub fn forward(&self, x: &mut [f64]) {
        for i in 0..self.size() {
            let (known, rest) = x.split_at_mut(i);
            rest[0] = (rest[0] - dot(self.row(i), known)) * self.inverse[i];
        }
    }

    /// `L^-T x` in place.
    pub fn backward(&self, x: &mut [f64]) {
        for i in (0..self.size()).rev() {
            let (rest, known) = x.split_at_mut(i);
            known[0] *= self.inverse[i];
            add_scaled(rest, -known[0], self.row(i));
        }
    }

    /// `G^-1 x` in place.
    pub fn solve(&self, x: &mut [f64]) {
        self.forward(x);
        self.backward(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::reproducible_noise;

    /// Gram matrix of these vectors of seven numbers.
    fn gram(vectors: &[Vec<f64>]) -> DenseMatrix {
        let mut gram = DenseMatrix::zeros(vectors.len(), vectors.len());
        for (i, a) in vectors.iter().enumerate() {
            for (j, b) in vectors.iter().enumerate() {
                *gram.at_mut(i, j) = dot(a, b);
            }
        }
        gram
    }

    fn vectors() -> Vec<Vec<f64>> {
        let noise = reproducible_noise(5 * 7);
        noise.chunks_exact(7).map(<[f64]>::to_vec).collect()
    }

    #[test]
    fn a_solution_is_found_again() {
        let gram = gram(&vectors());
        let known = [1.0, -2.0, 0.5, 3.0, 0.25];
        let mut x = [0.0; 5];
        gram.multiply(&known, &mut x);
        GramFactor::new(&gram).solve(&mut x);
        for (x, known) in x.iter().zip(known) {
            assert!((x - known).abs() < 1e-10, "{x} {known}");
        }
    }

    #[test]
    fn a_vector_made_of_earlier_ones_is_left_out() {
        let mut all = vectors();
        let sum: Vec<f64> = all[0].iter().zip(&all[1]).map(|(a, b)| a - b).collect();
        all.insert(2, sum);
        let gram = gram(&all);
        let mut with = [1.0, 2.0, 9.0, 3.0, 4.0, 5.0];
        GramFactor::new(&gram).solve(&mut with);
        let mut without = [1.0, 2.0, 3.0, 4.0, 5.0];
        GramFactor::new(&gram.principal(&[0, 1, 3, 4, 5])).solve(&mut without);
        assert!(with[2].abs() < 1e-300);
        for (place, value) in [0, 1, 3, 4, 5].into_iter().zip(without) {
            assert!((with[place] - value).abs() < 1e-10 * value.abs());
        }
    }
}
