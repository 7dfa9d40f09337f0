//! Error norms against a manufactured field, by a rule of degree 8 or more.
//!
//! ```text
//! ||u_h - u||,  ||grad(u_h - u)||,  ||p_h - p||   in L2 over the undeformed body
//! ```
//!
//! in the caller's units, the field taken at the load factor reached. Cost: one pass over
//! the cells with some hundred points each.

use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Rule, rule};
use crate::geometry::Matrix3;
use crate::linalg::vector::ratio;
use crate::model::Model;
use crate::model::loads::{MANUFACTURED_DEGREE, simplices};
use crate::model::state::State;
use crate::model::values::{displacement_at, gradient_at};
use crate::parallel;
use crate::report::ManufacturedErrors;
use crate::results::estimate::moduli;

/// Squares of the three errors, of the error's energy norm and of the field's,
/// over one cell, caller's units.
fn cell_squares(
    model: &Model<'_>,
    state: &State,
    field: &Manufactured,
    rule: &Rule,
    cell: usize,
) -> [f64; 5] {
    let units = &model.plan.problem.units;
    let corners = model.mesh.cell(cell);
    let [shear, lame] = moduli(model, cell);
    let mut squares = [0.0; 5];
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let l = &point[..corners.len()];
        let place = model.mesh.position_in(cell, point);
        let x = place.map(|x| x * units.coordinate_scale * units.length);
        let geometry = &model.prepared.geometry;
        let measure = geometry.volumes[cell] * geometry.curves.measure(cell, point);
        let weight = weight * measure * units.volume();
        let u = displacement_at(model, state, cell, point).map(|v| v * units.length);
        let (exact, load) = (field.displacement(x), state.drive.load);
        let gradient = gradient_at(model, state, cell, point);
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
pub(crate) fn energy(gradient: &Matrix3, shear: f64, lame: f64) -> f64 {
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
pub(crate) fn manufactured_errors(
    model: &Model<'_>,
    state: &State,
    field: &Manufactured,
) -> ManufacturedErrors {
    let degree = model.plan.problem.settings.quadrature_degree;
    let (simplex, _) = simplices(model.plan.problem.units.dimension);
    let rule = rule(simplex, degree.unwrap_or(MANUFACTURED_DEGREE));
    let cells = parallel::map(model.prepared.geometry.cells(), 1, &|cell| {
        cell_squares(model, state, field, &rule, cell)
    });
    let sum = |k: usize| cells.iter().map(|squares| squares[k]).sum::<f64>().sqrt();
    ManufacturedErrors {
        displacement_l2: sum(0),
        displacement_h1: sum(1),
        pressure_l2: (!state.pressure.is_empty()).then(|| sum(2)),
        relative_energy: ratio(sum(3), sum(4)),
    }
}
