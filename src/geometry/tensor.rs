//! Tensors of three by three numbers, where a number may stand for several
//! elements at a time.
//!
//! `tensor[i][j]` couples direction i to direction j. The cross product of
//! tensors, (A x B)_iI = eps_ijk eps_IJK A_jJ B_kK, gives cof F = F x F / 2 and
//! its derivative F x dF (Bonet, Gil, Ortigosa, "A computational framework for
//! polyconvex large strain elasticity", 2015). Every function costs some ten to
//! forty products. Loops stand where `map` could: a closure inside the standard library is
//! compiled without the vector registers of the kernel around it, product by product.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A number, or as many as move together.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// `value` in the shape of `self`.
    #[must_use]
    fn constant(self, value: f64) -> Self;
    /// `self + a b`.
    #[must_use]
    fn plus_product(self, a: Self, b: Self) -> Self;
    /// 1 / self.
    #[must_use]
    fn inverse(self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        self + a * b
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        1.0 / self
    }
}

/// `[i][j]`.
pub type Tensor<N> = [[N; 3]; 3];

/// A : B.
#[inline(always)]
pub fn contract<N: Number>(a: &Tensor<N>, b: &Tensor<N>) -> N {
    let mut sum = a[0][0] * b[0][0];
    for i in 0..3 {
        for j in 0..3 {
            if i + j > 0 {
                sum = sum.plus_product(a[i][j], b[i][j]);
            }
        }
    }
    sum
}

/// tr A.
#[inline(always)]
pub fn trace<N: Number>(a: &Tensor<N>) -> N {
    a[0][0] + a[1][1] + a[2][2]
}

/// A x B, symmetric in A and B.
#[inline(always)]
pub fn cross<N: Number>(a: &Tensor<N>, b: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        for m in 0..3 {
            let (n, o) = ((m + 1) % 3, (m + 2) % 3);
            let plus = (a[j][n] * b[k][o]).plus_product(a[k][o], b[j][n]);
            let minus = (a[j][o] * b[k][n]).plus_product(a[k][n], b[j][o]);
            out[i][m] = plus - minus;
        }
    }
    out
}

/// cof A = det A times the transposed inverse.
#[inline(always)]
pub fn cofactor<N: Number>(a: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        for m in 0..3 {
            let (n, o) = ((m + 1) % 3, (m + 2) % 3);
            out[i][m] = a[j][n] * a[k][o] - a[j][o] * a[k][n];
        }
    }
    out
}

/// A + factor B.
#[inline(always)]
pub fn plus<N: Number>(a: &Tensor<N>, factor: N, b: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = a[i][j].plus_product(factor, b[i][j]);
        }
    }
    out
}

/// factor A.
#[inline(always)]
pub fn scaled<N: Number>(factor: N, a: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for x in out.as_flattened_mut() {
        *x = factor * *x;
    }
    out
}

/// tr(A) I - A^T = I x A.
#[inline(always)]
pub fn unit_cross<N: Number>(a: &Tensor<N>) -> Tensor<N> {
    let t = trace(a);
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = -a[j][i];
        }
        out[i][i] += t;
    }
    out
}

/// A B.
#[inline(always)]
pub fn product<N: Number>(a: &Tensor<N>, b: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            let first = a[i][0] * b[0][j];
            out[i][j] = first
                .plus_product(a[i][1], b[1][j])
                .plus_product(a[i][2], b[2][j]);
        }
    }
    out
}

/// A^T.
#[inline(always)]
pub fn transposed<N: Number>(a: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = a[j][i];
        }
    }
    out
}

/// A + I.
#[inline(always)]
pub fn plus_unit<N: Number>(a: &Tensor<N>) -> Tensor<N> {
    let mut out = *a;
    for (i, row) in out.iter_mut().enumerate() {
        row[i] += row[i].constant(1.0);
    }
    out
}

/// det(I + H) - 1 = tr H + tr cof H + det H, without cancellation.
#[inline(always)]
pub fn volume_change<N: Number>(h: &Tensor<N>) -> N {
    let c = cofactor(h);
    let determinant = (h[0][0] * c[0][0])
        .plus_product(h[0][1], c[0][1])
        .plus_product(h[0][2], c[0][2]);
    trace(h) + trace(&c) + determinant
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Tensor<f64> = [[0.9, -0.2, 0.3], [0.1, 1.3, -0.4], [-0.5, 0.2, 0.8]];
    const B: Tensor<f64> = [[0.3, 0.7, -0.1], [-0.6, 0.2, 0.4], [0.1, -0.3, 0.5]];

    fn close(a: &Tensor<f64>, b: &Tensor<f64>) -> bool {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.into_iter().all(|(x, y)| (x - y).abs() < 1e-14)
    }

    #[test]
    fn the_cofactor_is_half_a_cross_product_and_inverts() {
        let c = cofactor(&A);
        assert!(close(&scaled(0.5, &cross(&A, &A)), &c));
        let determinant = contract(&A, &c) / 3.0;
        let unit = scaled(1.0 / determinant, &product(&A, &transposed(&c)));
        let zero = [[0.0; 3]; 3];
        assert!(close(&unit, &plus_unit(&zero)));
    }

    #[test]
    fn the_unit_tensor_crosses_as_trace_less_transpose() {
        let unit = plus_unit(&[[0.0; 3]; 3]);
        assert!(close(&cross(&unit, &B), &unit_cross(&B)));
        assert!(close(&cross(&A, &B), &cross(&B, &A)));
    }

    #[test]
    fn tiny_volume_changes_keep_their_digits() {
        let h = scaled(1e-12, &B);
        let exact = 1e-12 * (trace(&B) + 1e-12 * trace(&cofactor(&B)));
        assert!((volume_change(&h) - exact).abs() < 1e-15 * exact.abs());
        let f = plus_unit(&B);
        let determinant = contract(&f, &cofactor(&f)) / 3.0;
        assert!((volume_change(&B) + 1.0 - determinant).abs() < 1e-14);
    }
}
