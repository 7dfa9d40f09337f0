//! A frictional sphere pressed on a half-space and dragged, in one step: the largest condensed
//! problem of the tests, whose compliance is Boussinesq's and Cerruti's.

use std::fmt::Write as _;

use super::*;
use crate::linalg::DenseMatrix;
use crate::linalg::vector::largest;
use crate::saddle::{AdmissibleSet, Components, Cones, FrictionBound, SetPart};

const NU: f64 = 0.3;
const FRICTION: f64 = 0.4;

/// Points of a square grid of that spacing within a circle of radius 0.3.
fn points(spacing: f64) -> Vec<[f64; 2]> {
    let count = (0.3 / spacing) as i32;
    let line = -count..=count;
    let all = line.clone().flat_map(|i| line.clone().map(move |j| (i, j)));
    let places = all.map(|(i, j)| [f64::from(i) * spacing, f64::from(j) * spacing]);
    places.filter(|[x, y]| x.hypot(*y) < 0.3).collect()
}

/// Displacements (normal, x, y) at `d` from a force (normal, x, y), G = 1; those of a square
/// on itself are those of the disc of its area.
fn kernel([x, y]: [f64; 2], spacing: f64) -> [[f64; 3]; 3] {
    let distance = x.hypot(y);
    if distance == 0.0 {
        let disc = std::f64::consts::PI * spacing / std::f64::consts::PI.sqrt();
        let along = (2.0 - NU) / (2.0 * disc);
        return [
            [(1.0 - NU) / disc, 0.0, 0.0],
            [0.0, along, 0.0],
            [0.0, 0.0, along],
        ];
    }
    let scale = 1.0 / (2.0 * std::f64::consts::PI * distance);
    let [ex, ey] = [x / distance, y / distance];
    let turn = 0.5 * (1.0 - 2.0 * NU);
    let shear = |a: f64, b: f64, same: f64| scale * ((1.0 - NU) * same + NU * a * b);
    [
        [scale * (1.0 - NU), scale * turn * ex, scale * turn * ey],
        [-scale * turn * ex, shear(ex, ex, 1.0), shear(ex, ey, 0.0)],
        [-scale * turn * ey, shear(ex, ey, 0.0), shear(ey, ey, 1.0)],
    ]
}

/// K and q of a sphere of radius one pressed by `depth` and dragged by `travel`; pressures
/// first, then tractions.
fn problem(points: &[[f64; 2]], spacing: f64, depth: f64, travel: f64) -> (DenseMatrix, Vec<f64>) {
    let count = points.len();
    let place = |point: usize, axis: usize| match axis {
        0 => point,
        _ => count + 2 * point + axis - 1,
    };
    let mut matrix = DenseMatrix::zeros(3 * count, 3 * count);
    let mut linear = vec![0.0; 3 * count];
    for (i, a) in points.iter().enumerate() {
        for (j, b) in points.iter().enumerate() {
            let block = kernel([a[0] - b[0], a[1] - b[1]], spacing);
            for (r, row) in block.iter().enumerate() {
                for (c, value) in row.iter().enumerate() {
                    *matrix.at_mut(place(i, r), place(j, c)) = *value;
                }
            }
        }
        linear[place(i, 0)] = 0.5 * (a[0] * a[0] + a[1] * a[1]) - depth;
        linear[place(i, 1)] = -travel;
    }
    (matrix, linear)
}

/// Solves with Coulomb's law; the solution and its residual.
fn solved(matrix: &DenseMatrix, linear: &[f64]) -> (DenseSolution, Vec<f64>) {
    let count = linear.len() / 3;
    let partners: Vec<u32> = (0..count as u32).collect();
    let bounds = vec![FrictionBound::Coulomb(FRICTION); count];
    let cones = Cones {
        normals: count,
        partners: &partners,
        bounds: &bounds,
        components: Components::Two,
    };
    let part = SetPart {
        size: linear.len(),
        set: AdmissibleSet::Cones(cones),
    };
    let near = (
        &vec![Status::Open; linear.len()][..],
        &vec![0.0; linear.len()][..],
    );
    let solution = solve(matrix, linear, ProductSet::Uniform(part), near).expect("a solution");
    let mut residual = vec![0.0; linear.len()];
    matrix.multiply(&solution.values, &mut residual);
    residual.iter_mut().zip(linear).for_each(|(s, q)| *s += q);
    (solution, residual)
}

/// How far x is from Coulomb's law with residuals s, over the largest of each.
fn misfit(x: &[f64], s: &[f64]) -> f64 {
    let count = x.len() / 3;
    let (force, slip) = (largest(x), largest(s));
    let mut worst = 0.0_f64;
    for i in 0..count {
        let [t, v] = [x, s].map(|all| [all[count + 2 * i], all[count + 2 * i + 1]]);
        let bound = FRICTION * x[i];
        let (size, speed) = (t[0].hypot(t[1]), v[0].hypot(v[1]));
        let against = (t[0] * v[0] + t[1] * v[1] + bound * speed) / (force * slip);
        let signs = (-x[i] / force)
            .max(-s[i] / slip)
            .max(x[i] * s[i] / (force * slip));
        worst = worst
            .max(signs)
            .max((size - bound) / force)
            .max(against.abs());
    }
    worst
}

#[test]
fn a_sphere_pressed_and_dragged_in_one_step_follows_coulombs_law() {
    for (travel, slides) in [(0.002, false), (0.006, false), (0.05, true)] {
        let (matrix, linear) = problem(&points(0.04), 0.04, 0.05, travel);
        let (solution, residual) = solved(&matrix, &linear);
        let misfit = misfit(&solution.values, &residual);
        assert!(misfit < 1e-9, "{travel}: {misfit}");
        let count = linear.len() / 3;
        let sticks = solution.status[count..].contains(&Status::Stick);
        assert_eq!(sticks, !slides);
        assert!((3..=10).contains(&solution.steps), "{}", solution.steps);
    }
}

/// Writes problems with their solutions into the folder CONDENSED, for
/// `tests/benches/peers/condensed_oracle.py`.
#[cfg(test)]
#[test]
#[ignore = "writes files for another solver"]
fn export_for_another_solver() {
    let folder = std::env::var("CONDENSED").expect("a folder in CONDENSED");
    for (number, travel) in [0.001, 0.003, 0.006, 0.01, 0.05].into_iter().enumerate() {
        let (matrix, linear) = problem(&points(0.03), 0.03, 0.05, travel);
        let (solution, _) = solved(&matrix, &linear);
        let mut text = format!("{} {FRICTION}\n", linear.len() / 3);
        for (q, x) in linear.iter().zip(&solution.values) {
            writeln!(text, "{q:e} {x:e}").expect("memory");
        }
        for row in 0..linear.len() {
            let entries =
                (0..linear.len()).map(|column| format!("{:e}", matrix.entry(row, column)));
            writeln!(text, "{}", entries.collect::<Vec<_>>().join(" ")).expect("memory");
        }
        std::fs::write(format!("{folder}/sphere-{number}.txt"), text).expect("a folder");
    }
}
