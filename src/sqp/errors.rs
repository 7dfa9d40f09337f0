//! Error norms against a manufactured field, by a rule of degree 8 or more.

use rayon::prelude::*;

use super::evaluate::Context;
use super::loads::{MANUFACTURED_DEGREE, simplices};
use super::results::{displacement_at, gradient_at};
use super::state::State;
use crate::assembly::load::position;
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Rule, rule};
use crate::report::ManufacturedErrors;

/// Squares of the three errors over one cell, caller's units.
fn cell_squares(
    context: &Context<'_>,
    state: &State,
    field: &Manufactured,
    rule: &Rule,
    cell: usize,
) -> [f64; 3] {
    let units = &context.plan.units;
    let corners = context.mesh.cell(cell);
    let mut squares = [0.0; 3];
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

/// The three norms.
pub(super) fn manufactured_errors(
    context: &Context<'_>,
    state: &State,
    field: &Manufactured,
) -> ManufacturedErrors {
    let degree = context.plan.scene.solver.quadrature_degree;
    let (simplex, _) = simplices(context.plan.units.dimension);
    let rule = rule(simplex, degree.unwrap_or(MANUFACTURED_DEGREE));
    let cells: Vec<[f64; 3]> = (0..context.prepared.geometry.cells())
        .into_par_iter()
        .map(|cell| cell_squares(context, state, field, &rule, cell))
        .collect();
    let sum = |k: usize| cells.iter().map(|squares| squares[k]).sum::<f64>().sqrt();
    ManufacturedErrors {
        displacement_l2: sum(0),
        displacement_h1: sum(1),
        pressure_l2: (!state.pressure.is_empty()).then(|| sum(2)),
    }
}
