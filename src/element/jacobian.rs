//! Bounds on the Jacobian J = det F between known deformation gradients.
//!
//! In a straight cell with quadratic displacement F = sum_i l_i F_i in barycentric
//! coordinates l, so that J is cubic. With the symmetric trilinear form D of the
//! determinant, D(F, F, F) = det F,
//!
//! ```text
//! J = sum_ijk l_i l_j l_k D(F_i, F_j, F_k),   D(A, B, C) = A : (B x C) / 6
//! ```
//!
//! the D are the Bernstein coefficients of J: 20 in a tetrahedron, 10 in a triangle.
//! J is nowhere below the least of them (Johnen, Remacle, Geuzaine, "Geometrical
//! validity of curvilinear finite elements", 2013), and at a corner it is its coefficient. The bound holds where F is linear: an axisymmetric
//! stretch u_r / r is not; there the caller bounds the in-plane J and the stretch
//! apart. Cost: some 50 flops a coefficient.

use crate::geometry::tensor::{Tensor, contract, cross};

/// D of the three tensors, `crossed` being the cross product of two of them.
fn polar(a: &Tensor<f64>, crossed: &Tensor<f64>) -> f64 {
    contract(a, crossed) / 6.0
}

/// The smaller one; NaN where one of them is.
fn least(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// A number that J is nowhere below in a cell with deformation gradients `corners`
/// at its two to four corners: the least Bernstein coefficient, NaN where a
/// gradient is not finite.
#[must_use]
pub fn least_jacobian_bound(corners: &[Tensor<f64>]) -> f64 {
    coefficients(corners).fold(f64::INFINITY, least)
}

/// A number that J is nowhere above there; NaN where a gradient is not finite.
#[must_use]
pub fn most_jacobian_bound(corners: &[Tensor<f64>]) -> f64 {
    -coefficients(corners)
        .map(|coefficient| -coefficient)
        .fold(f64::INFINITY, least)
}

/// The Bernstein coefficients of J.
fn coefficients(corners: &[Tensor<f64>]) -> impl Iterator<Item = f64> {
    let pairs = (0..corners.len()).flat_map(move |i| (i..corners.len()).map(move |j| (i, j)));
    pairs.flat_map(move |(i, j)| {
        let crossed = cross(&corners[i], &corners[j]);
        corners[j..].iter().map(move |c| polar(c, &crossed))
    })
}

/// [`least_jacobian_bound`] over the four parts of a triangle or the eight of a
/// tetrahedron that its edge midpoints cut off: never below it, a quarter of its
/// distance from the true minimum for fine cells.
#[must_use]
pub fn sharper_jacobian_bound(corners: &[Tensor<f64>]) -> f64 {
    let middle = |i: usize, j: usize| -> Tensor<f64> {
        let (a, b) = (&corners[i], &corners[j]);
        std::array::from_fn(|k| std::array::from_fn(|l| 0.5 * (a[k][l] + b[k][l])))
    };
    let inner: &[[(usize, usize); 4]] = match corners.len() {
        4 => &INNER_TETRAHEDRA,
        3 => &INNER_TRIANGLE,
        _ => &[],
    };
    let at_corners = (0..corners.len()).map(|i| {
        let part: Vec<_> = (0..corners.len()).map(|j| middle(i, j)).collect();
        least_jacobian_bound(&part)
    });
    let within = inner.iter().map(|part| {
        let part: Vec<_> = part.iter().map(|&(i, j)| middle(i, j)).collect();
        least_jacobian_bound(&part[..corners.len()])
    });
    at_corners.chain(within).fold(f64::INFINITY, least)
}

/// The octahedron of the edge midpoints of a tetrahedron in four, around the
/// diagonal from edge (0, 2) to edge (1, 3).
const INNER_TETRAHEDRA: [[(usize, usize); 4]; 4] = [
    [(0, 2), (1, 3), (0, 1), (1, 2)],
    [(0, 2), (1, 3), (1, 2), (2, 3)],
    [(0, 2), (1, 3), (2, 3), (0, 3)],
    [(0, 2), (1, 3), (0, 3), (0, 1)],
];

/// The midpoints of a triangle; the last is not read.
const INNER_TRIANGLE: [[(usize, usize); 4]; 1] = [[(0, 1), (1, 2), (0, 2), (0, 2)]];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation_matrix;
    use crate::geometry::tensor::{cofactor, plus};
    use proptest::prelude::*;

    const UNIT: Tensor<f64> = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn determinant(f: &Tensor<f64>) -> f64 {
        contract(f, &cofactor(f)) / 3.0
    }

    fn tensor() -> impl Strategy<Value = Tensor<f64>> {
        prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64))
    }

    /// F at the point with barycentric coordinates in proportion to `weights`.
    fn between(corners: &[Tensor<f64>], weights: &[f64]) -> Tensor<f64> {
        let sum: f64 = weights[..corners.len()].iter().sum();
        let zero = [[0.0; 3]; 3];
        let parts = corners.iter().zip(weights);
        parts.fold(zero, |total, (f, w)| plus(&total, w / sum, f))
    }

    proptest! {
        #[test]
        fn the_bounds_are_below_the_jacobian_everywhere(
            changes in prop::collection::vec(tensor(), 3..=4),
            points in prop::collection::vec(prop::array::uniform4(0.001..1.0_f64), 20),
            size in 0.0..1.0_f64,
        ) {
            let corners: Vec<_> = changes.iter().map(|h| plus(&UNIT, size, h)).collect();
            let bound = least_jacobian_bound(&corners);
            let sharper = sharper_jacobian_bound(&corners);
            prop_assert!(sharper >= bound - 1e-14);
            for weights in &points {
                prop_assert!(determinant(&between(&corners, weights)) >= sharper - 1e-14);
            }
            for corner in &corners {
                prop_assert!(determinant(corner) >= sharper - 1e-14);
            }
        }
    }

    #[test]
    fn a_cell_of_constant_gradient_has_its_jacobian_as_bound() {
        let f = plus(&UNIT, 0.4, &rotation_matrix([0.2, 0.5, -0.3]));
        for corners in [2, 3, 4] {
            let bound = least_jacobian_bound(&vec![f; corners]);
            assert!((bound - determinant(&f)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_parts_of_a_cell_approach_its_least_jacobian() {
        // J = (1 - 2 l)^2 + 0.1 with l of the second corner: the least is 0.1, the
        // least cubic coefficient a third below.
        let end = |x: f64, y: f64| {
            let mut f = UNIT;
            (f[0][0], f[0][1], f[1][0], f[1][1]) = (x, -0.1_f64.sqrt(), 0.1_f64.sqrt(), y);
            f
        };
        let corners = [end(1.0, 1.0), end(-1.0, -1.0), end(1.0, 1.0)];
        assert!((least_jacobian_bound(&corners) - 0.1 + 1.0 / 3.0).abs() < 1e-15);
        assert!((sharper_jacobian_bound(&corners) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn a_plane_stretch_may_vary_out_of_plane() {
        // 1 (1) (1 + l), in the plane J = 1: the bound is that of the stretch.
        let mut wide = UNIT;
        wide[2][2] = 2.0;
        assert!((least_jacobian_bound(&[UNIT, wide, UNIT]) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn tensors_that_are_not_finite_have_no_bound() {
        let broken = [[f64::NAN; 3]; 3];
        assert!(least_jacobian_bound(&[UNIT, UNIT, broken]).is_nan());
        assert!(least_jacobian_bound(&[broken, UNIT, UNIT]).is_nan());
    }
}
