//! A normal at a vertex from the vertices around it: with z along a first guess of it,
//!
//! ```text
//! z = a x + b y + c x^2 + d x y + e y^2
//! ```
//!
//! by least squares, the normal being (-a, -b, 1). Offsets are measured in the reach of the
//! points along each axis, and curvatures that the points leave open are taken as zero. Cost:
//! a system of five unknowns.

use crate::geometry::vector3::{add, cross, dot, normalised, scale, sub};

/// Unknowns.
const SIZE: usize = 5;
/// Share of the trace that is added to the diagonal.
const RIDGE: f64 = 1e-12;

/// The unit normal near `guess` (unit) at `vertex` of the surface through `others`; `guess`
/// itself where they do not determine it.
pub(super) fn normal(vertex: [f64; 3], guess: [f64; 3], others: &[[f64; 3]]) -> [f64; 3] {
    let first = crate::obstacle::orthogonal(guess);
    let second = cross(guess, first);
    let local: Vec<[f64; 3]> = others
        .iter()
        .map(|&other| {
            let offset = sub(other, vertex);
            [dot(offset, first), dot(offset, second), dot(offset, guess)]
        })
        .collect();
    let reach = |axis: usize| local.iter().map(|p| p[axis].abs()).fold(0.0, f64::max);
    let reach = [reach(0), reach(1)];
    if local.len() < SIZE || reach.contains(&0.0) {
        return guess;
    }
    let Some(found) = least_squares(&local, reach) else {
        return guess;
    };
    let slope = add(
        scale(found[0] / reach[0], first),
        scale(found[1] / reach[1], second),
    );
    normalised(sub(guess, slope)).unwrap_or(guess)
}

fn least_squares(local: &[[f64; 3]], reach: [f64; 2]) -> Option<[f64; SIZE]> {
    let mut matrix = [[0.0; SIZE]; SIZE];
    let mut right = [0.0; SIZE];
    for point in local {
        let (x, y) = (point[0] / reach[0], point[1] / reach[1]);
        let row = [x, y, x * x, x * y, y * y];
        // Near vertices tell more of the slope than far ones.
        let weight = 1.0 / (x * x + y * y).max(RIDGE);
        for i in 0..SIZE {
            for j in 0..SIZE {
                matrix[i][j] += weight * row[i] * row[j];
            }
            right[i] += weight * row[i] * point[2];
        }
    }
    let trace: f64 = (0..SIZE).map(|i| matrix[i][i]).sum();
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += RIDGE * trace;
    }
    cholesky(matrix, right)
}

/// Solves a small system with a positive definite matrix; none where it is not.
fn cholesky(mut a: [[f64; SIZE]; SIZE], mut b: [f64; SIZE]) -> Option<[f64; SIZE]> {
    for i in 0..SIZE {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - sum;
            if i == j {
                if rest <= 0.0 {
                    return None;
                }
                a[i][i] = rest.sqrt();
            } else {
                a[i][j] = rest / a[j][j];
            }
        }
    }
    for i in 0..SIZE {
        let sum: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    for i in (0..SIZE).rev() {
        let sum: f64 = (i + 1..SIZE).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    Some(b)
}
