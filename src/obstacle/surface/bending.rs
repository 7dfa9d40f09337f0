//! The Hessian of the distance to a patch.

use super::patch::Patch;
use crate::geometry::Matrix3;
use crate::geometry::vector3::dot;

/// Hessian of the distance at `distance` along `normal` from the point `l`: with the tangents
/// T, the metric I = T^T T and B = -n . d2X,
///
/// ```text
/// H = T I^-1 B (I + d B)^-1 T^T
/// ```
///
/// zero where the point is beyond a centre of curvature.
pub(super) fn curvature(patch: &Patch, l: [f64; 3], normal: [f64; 3], distance: f64) -> Matrix3 {
    let d = patch.derivatives(l);
    let symmetric = |m: [f64; 3]| [[m[0], m[1]], [m[1], m[2]]];
    let metric = symmetric([
        dot(d.first[0], d.first[0]),
        dot(d.first[0], d.first[1]),
        dot(d.first[1], d.first[1]),
    ]);
    let bent = symmetric(d.second.map(|second| -dot(normal, second)));
    let moved: [[f64; 2]; 2] =
        std::array::from_fn(|i| std::array::from_fn(|j| metric[i][j] + distance * bent[i][j]));
    let (Some(metric), Some(moved)) = (inverse(&metric), inverse(&moved)) else {
        return [[0.0; 3]; 3];
    };
    let middle = product(&product(&metric, &bent), &moved);
    let entry = |i: usize, j: usize| {
        let mut sum = 0.0;
        for (a, row) in middle.iter().enumerate() {
            for (b, value) in row.iter().enumerate() {
                sum += d.first[a][i] * value * d.first[b][j];
            }
        }
        sum
    };
    // Symmetric but for rounding.
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (entry(i, j) + entry(j, i))))
}

fn inverse(m: &[[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let is_positive = m[0][0] > 0.0 && determinant > 1e-12 * m[0][0] * m[1][1].abs();
    is_positive.then(|| {
        [
            [m[1][1] / determinant, -m[0][1] / determinant],
            [-m[1][0] / determinant, m[0][0] / determinant],
        ]
    })
}

fn product(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}
