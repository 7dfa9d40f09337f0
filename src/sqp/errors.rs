//! Error norms against a manufactured field, by a rule of degree 8 or more.

use rayon::prelude::*;

use super::estimate::moduli;
use super::evaluate::{Context, ratio};
use super::loads::{MANUFACTURED_DEGREE, simplices};
use super::results::{displacement_at, gradient_at};
use super::state::State;
use crate::assembly::load::position;
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Rule, rule};
use crate::geometry::Matrix3;
use crate::report::ManufacturedErrors;

/// Squares of the three errors, of the error's energy norm and of the field's,
/// over one cell, caller's units.
fn cell_squares(
    context: &Context<'_>,
    state: &State,
    field: &Manufactured,
    rule: &Rule,
    cell: usize,
) -> [f64; 5] {
    let units = &context.plan.units;
    let corners = context.mesh.cell(cell);
    let [shear, lame] = moduli(context, cell);
    let mut squares = [0.0; 5];
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let l = &point[..corners.len()];
        let x = position(
            context.mesh,
            units.coordinate_scale * units.length,
            corners,
            l,
        );
        let weight = weight * context.prepared.geometry.volumes[cell] * units.volume();
        let u = displacement_at(context, state, cell, point).map(|v| v * units.length);
        let (exact, load) = (field.displacement(x), state.drive.load);
        let gradient = gradient_at(context, state, cell, point);
        let exact_gradient = field.gradient(x);
        for i in 0..units.dimension {
            squares[0] += weight * (u[i] - load * exact[i]).powi(2);
            for j in 0..units.dimension {
                squares[1] += weight * (gradient[i][j] - load * exact_gradient[i][j]).powi(2);
            }
        }
        let exact = exact_gradient.map(|row| row.map(|slope| load * slope));
        let error: Matrix3 =
            std::array::from_fn(|i| std::array::from_fn(|j| gradient[i][j] - exact[i][j]));
        squares[3] += weight * energy(&error, shear, lame);
        squares[4] += weight * energy(&exact, shear, lame);
        if !state.pressure.is_empty() {
            let p: f64 = corners
                .iter()
                .zip(l)
                .map(|(&v, l)| l * state.pressure[v as usize])
                .sum();
            squares[2] += weight * (p * units.stress - load * field.pressure(x)).powi(2);
        }
    }
    squares
}

/// 2 mu |eps|^2 + lambda (tr eps)^2 of a gradient.
pub(super) fn energy(gradient: &Matrix3, shear: f64, lame: f64) -> f64 {
    let mut square = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            square += (0.5 * (gradient[i][j] + gradient[j][i])).powi(2);
        }
    }
    let trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
    2.0 * shear * square + lame * trace * trace
}

/// The norms.
pub(super) fn manufactured_errors(
    context: &Context<'_>,
    state: &State,
    field: &Manufactured,
) -> ManufacturedErrors {
    let degree = context.plan.scene.solver.quadrature_degree;
    let (simplex, _) = simplices(context.plan.units.dimension);
    let rule = rule(simplex, degree.unwrap_or(MANUFACTURED_DEGREE));
    let cells: Vec<[f64; 5]> = (0..context.prepared.geometry.cells())
        .into_par_iter()
        .map(|cell| cell_squares(context, state, field, &rule, cell))
        .collect();
    let sum = |k: usize| cells.iter().map(|squares| squares[k]).sum::<f64>().sqrt();
    ManufacturedErrors {
        displacement_l2: sum(0),
        displacement_h1: sum(1),
        pressure_l2: (!state.pressure.is_empty()).then(|| sum(2)),
        relative_energy: ratio(sum(3), sum(4)),
    }
}
