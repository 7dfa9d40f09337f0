//! Values at the points of a batch from those at its vertices, grad u = sum_j lambda_j G_j.

use pulp::Simd;

use crate::assembly::kernel::points::{Tensor as Square, zeros};
use crate::assembly::lanes::Pack;
use crate::geometry::tensor::Tensor;

/// grad u at the vertices.
pub(super) type VertexGradients<S, const V: usize, const D: usize> = [Square<S, D>; V];

/// A plane tensor in space.
#[inline(always)]
pub(super) fn in_space<S: Simd, const D: usize>(simd: S, plane: &Square<S, D>) -> Tensor<Pack<S>> {
    let mut out = [[Pack::splat(simd, 0.0); 3]; 3];
    for i in 0..D {
        for j in 0..D {
            out[i][j] = plane[i][j];
        }
    }
    out
}

/// sum_j lambda_j G_j.
#[inline(always)]
pub(super) fn at_point<S: Simd, const V: usize, const D: usize>(
    simd: S,
    hats: &[Pack<S>; V],
    vertex: &VertexGradients<S, V, D>,
) -> Tensor<Pack<S>> {
    let mut out = zeros::<S, D, D, f64>(simd);
    for (hat, gradient) in hats.iter().zip(vertex) {
        for i in 0..D {
            for j in 0..D {
                out[i][j] = out[i][j].plus_product(*hat, gradient[i][j]);
            }
        }
    }
    in_space(simd, &out)
}

/// Barycentric coordinates of a point.
#[inline(always)]
pub(super) fn hats<S: Simd, const V: usize>(simd: S, point: &[f64; 4]) -> [Pack<S>; V] {
    let mut out = [Pack::splat(simd, 0.0); V];
    for (hat, value) in out.iter_mut().zip(point) {
        *hat = Pack::splat(simd, *value);
    }
    out
}
