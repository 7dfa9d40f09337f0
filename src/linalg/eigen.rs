//! Eigenvalues of a dense matrix and of a tridiagonal one, and powers of a symmetric pencil:
//!
//! ```text
//! A V = M V T,  V^T M V = I:   M V f(T) V^T M
//! ```
//!
//! A, M `[n, n]` symmetric positive definite. Through the Cholesky factor of M and
//! the symmetric eigenproblem of G^-1 A G^-T (Golub and Van Loan, Matrix
//! Computations, 8.7.2). Cost about 20 n^3, one thread, cannot be interrupted.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{Llt, SelfAdjointEigen};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, Par, Side};

use super::{DenseMatrix, FactoriseError};

/// M V T^exponent V^T M of the pencil (`matrix`, `mass`).
///
/// # Errors
/// When one of them is not positive definite.
pub fn pencil_power(
    matrix: &DenseMatrix,
    mass: &DenseMatrix,
    exponent: f64,
) -> Result<DenseMatrix, FactoriseError> {
    let failed = FactoriseError::NotPositiveDefinite;
    let size = matrix.rows();
    if size == 0 {
        return Ok(DenseMatrix::zeros(0, 0));
    }
    let factor = Llt::new(mass.view(), Side::Lower).map_err(|_| failed)?;
    let lower = factor.L();
    let mut reduced = matrix.view().to_owned();
    solve_lower_triangular_in_place(lower, reduced.as_mut(), Par::Seq);
    let mut reduced = reduced.transpose().to_owned();
    solve_lower_triangular_in_place(lower, reduced.as_mut(), Par::Seq);
    let eigen = SelfAdjointEigen::new(reduced.as_ref(), Side::Lower).map_err(|_| failed)?;
    let values = eigen.S().column_vector();
    if (0..size).any(|i| values[i].is_nan() || values[i] <= 0.0) {
        return Err(failed);
    }
    let product = |a: faer::MatRef<'_, f64>, b: faer::MatRef<'_, f64>| {
        let mut product = Mat::<f64>::zeros(size, size);
        matmul(product.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
        product
    };
    // M V = G Q; half of the power on each side keeps the result symmetric.
    let mut half = product(lower, eigen.U());
    for j in 0..size {
        let factor = values[j].powf(0.5 * exponent);
        half.col_mut(j)
            .iter_mut()
            .for_each(|value| *value *= factor);
    }
    let whole = product(half.as_ref(), half.transpose());
    let mut power = DenseMatrix::zeros(size, size);
    for j in 0..size {
        for i in 0..size {
            *power.at_mut(i, j) = 0.5 * (whole[(i, j)] + whole[(j, i)]);
        }
    }
    Ok(power)
}

/// Least and largest eigenvalue of a symmetric tridiagonal matrix and the vector of the least, of unit length, `beside`
/// the entries beside its `diagonal` `[n]`, further ones unread; none where the iteration
/// fails.
pub fn least_of_tridiagonal(diagonal: &[f64], beside: &[f64]) -> Option<([f64; 2], Vec<f64>)> {
    let size = diagonal.len();
    if size == 0 {
        return None;
    }
    let matrix = Mat::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside.get(i.min(j)).copied().unwrap_or(0.0),
        _ => 0.0,
    });
    let eigen = SelfAdjointEigen::new(matrix.as_ref(), Side::Lower).ok()?;
    let values = eigen.S().column_vector();
    // Ascending.
    let extremes = [values[0], values[size - 1]];
    Some((extremes, eigen.U().col(0).iter().copied().collect()))
}

/// Eigenvectors of unit length of a symmetric matrix, whose lower triangle is read, by ascending
/// eigenvalue; none where the iteration fails.
pub fn symmetric(matrix: &DenseMatrix) -> Option<Vec<Vec<f64>>> {
    let eigen = SelfAdjointEigen::new(matrix.view(), Side::Lower).ok()?;
    let vectors = eigen.U().col_iter();
    Some(
        vectors
            .map(|vector| vector.iter().copied().collect())
            .collect(),
    )
}

/// Real and imaginary parts of the eigenvalues of a square matrix; none where the
/// iteration fails.
pub fn eigenvalues(matrix: &DenseMatrix) -> Option<Vec<[f64; 2]>> {
    let values = matrix.view().eigenvalues().ok()?;
    Some(values.iter().map(|value| [value.re, value.im]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vector::reproducible_noise;

    /// R R^T plus a multiple of the identity.
    fn positive_definite(size: usize, seed: usize) -> DenseMatrix {
        let noise = reproducible_noise((seed + 1) * size * size);
        let entries = &noise[seed * size * size..];
        let mut matrix = DenseMatrix::zeros(size, size);
        for i in 0..size {
            for j in 0..size {
                let rows = (0..size).map(|k| entries[i * size + k] * entries[j * size + k]);
                *matrix.at_mut(i, j) = rows.sum::<f64>() + f64::from(u8::from(i == j));
            }
        }
        matrix
    }

    fn difference(a: &DenseMatrix, b: &DenseMatrix) -> f64 {
        let size = a.rows();
        let entries = (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
        entries
            .map(|(i, j)| (a.at(i, j) - b.at(i, j)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn powers_nought_and_one_are_the_mass_and_the_matrix() {
        let (matrix, mass) = (positive_definite(6, 0), positive_definite(6, 1));
        let power = |exponent| pencil_power(&matrix, &mass, exponent).expect("definite");
        assert!(difference(&power(0.0), &mass) < 1e-13);
        assert!(difference(&power(1.0), &matrix) < 1e-12);
    }

    #[test]
    fn the_inverse_square_root_squares_to_the_inverse() {
        let (matrix, mass) = (positive_definite(6, 2), positive_definite(6, 3));
        let root = pencil_power(&matrix, &mass, -0.5).expect("definite");
        // root M^-1 root x = M A^-1 M x for any x: with y = A z, M z = M A^-1 y.
        let z = reproducible_noise(6);
        let mut y = vec![0.0; 6];
        matrix.multiply(&z, &mut y);
        let factor = crate::linalg::DenseCholesky::new(&mass).expect("definite");
        factor.solve(&mut y);
        let (mut once, mut twice) = (vec![0.0; 6], vec![0.0; 6]);
        root.multiply(&y, &mut once);
        factor.solve(&mut once);
        root.multiply(&once, &mut twice);
        let mut exact = vec![0.0; 6];
        mass.multiply(&z, &mut exact);
        for (value, exact) in twice.iter().zip(exact) {
            assert!((value - exact).abs() < 1e-11, "{value} {exact}");
        }
    }

    #[test]
    fn an_indefinite_pencil_is_refused() {
        let (mut matrix, mass) = (positive_definite(3, 0), positive_definite(3, 1));
        *matrix.at_mut(1, 1) = -5.0;
        assert!(pencil_power(&matrix, &mass, -0.5).is_err());
        assert!(pencil_power(&mass, &matrix, -0.5).is_err());
    }
}
