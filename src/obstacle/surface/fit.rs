//! A normal at a vertex from the vertices around it: with z along a first guess of it,
//!
//! ```text
//! z = a x + b y + c x^2 + d x y + e y^2 (+ f x^3 + g x^2 y + h x y^2 + i y^3)
//! ```
//!
//! by least squares, the normal being (-a, -b, 1). Terms of third order are taken where they
//! halve what the others leave: on a torus they do, on a sphere they would fit its fourth order.
//! Offsets are measured in the reach of the points along each axis, and curvatures that the
//! points leave open are taken as zero. Cost: a system of five and one of nine unknowns.

use crate::geometry::vector3::{add, cross, dot, normalised, scale, sub};

/// Unknowns of second order, and of third.
const QUADRIC: usize = 5;
const CUBIC: usize = 9;
/// Points from which on terms of third order are determined.
const ENOUGH: usize = 12;
/// Share of what the quadric leaves that the cubic may leave to be taken.
const BETTER: f64 = 0.5;
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
    if local.len() < QUADRIC || reach.contains(&0.0) {
        return guess;
    }
    let Some(slope) = slope(&local, reach) else {
        return guess;
    };
    let slope = add(scale(slope[0], first), scale(slope[1], second));
    normalised(sub(guess, slope)).unwrap_or(guess)
}

/// a and b of the points.
fn slope(local: &[[f64; 3]], reach: [f64; 2]) -> Option<[f64; 2]> {
    let points: Vec<Weighted> = local
        .iter()
        .map(|&[x, y, z]| {
            let (x, y) = (x / reach[0], y / reach[1]);
            let terms = terms(x, y);
            // Near vertices tell more of the slope than far ones.
            let weight = 1.0 / (x * x + y * y).max(RIDGE);
            Weighted { terms, z, weight }
        })
        .collect();
    let system = system(&points);
    let quadric = least_squares::<QUADRIC>(&points, &system)?;
    let cubic = if local.len() >= ENOUGH {
        least_squares::<CUBIC>(&points, &system)
    } else {
        None
    };
    let [a, b] = match cubic {
        Some(cubic) if cubic.left < BETTER * quadric.left => cubic.slope,
        _ => quadric.slope,
    };
    Some([a / reach[0], b / reach[1]])
}

/// A point with its terms.
struct Weighted {
    terms: [f64; CUBIC],
    z: f64,
    weight: f64,
}

/// A fit: its slopes along both axes, and the weighted norm of what it leaves.
struct Fit {
    slope: [f64; 2],
    left: f64,
}

/// All terms at a point.
fn terms(x: f64, y: f64) -> [f64; CUBIC] {
    let (xx, yy) = (x * x, y * y);
    [x, y, xx, x * y, yy, xx * x, xx * y, x * yy, yy * y]
}

/// Matrix and, in the last column, right-hand side of all terms; those of fewer terms are its
/// first rows and columns.
fn system(points: &[Weighted]) -> [[f64; CUBIC + 1]; CUBIC] {
    let mut system = [[0.0; CUBIC + 1]; CUBIC];
    for point in points {
        let [a, b, c, d, e, f, g, h, i] = point.terms;
        let all = [a, b, c, d, e, f, g, h, i, point.z];
        for (row, term) in system.iter_mut().zip(point.terms) {
            let weighted = point.weight * term;
            for (entry, other) in row.iter_mut().zip(all) {
                *entry += weighted * other;
            }
        }
    }
    system
}

fn least_squares<const SIZE: usize>(
    points: &[Weighted],
    system: &[[f64; CUBIC + 1]; CUBIC],
) -> Option<Fit> {
    let mut matrix: [[f64; SIZE]; SIZE] =
        std::array::from_fn(|i| std::array::from_fn(|j| system[i][j]));
    let right: [f64; SIZE] = std::array::from_fn(|i| system[i][CUBIC]);
    let trace: f64 = (0..SIZE).map(|i| matrix[i][i]).sum();
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] += RIDGE * trace;
    }
    let found = cholesky(matrix, right)?;
    let left = points.iter().map(|point| {
        let fitted: f64 = found
            .iter()
            .zip(point.terms)
            .map(|(c, term)| c * term)
            .sum();
        point.weight * (fitted - point.z).powi(2)
    });
    Some(Fit {
        slope: [found[0], found[1]],
        left: left.sum::<f64>().sqrt(),
    })
}

/// Solves a small system with a positive definite matrix; none where it is not.
fn cholesky<const SIZE: usize>(
    mut a: [[f64; SIZE]; SIZE],
    mut b: [f64; SIZE],
) -> Option<[f64; SIZE]> {
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
