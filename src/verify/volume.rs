//! Internal forces and volume constraints, cell by cell:
//!
//! ```text
//! int P : grad v,   int q (div u + p / lambda)   or   int q (J - 1 + p / K)
//! ```
//!
//! in the caller's units. About the axis x = 0 the strain around it is u_x / x and
//! the volume that of the full turn.

use super::cell::Cell;
use super::rubber::Deformed;
use super::{loads, turn};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::tensor::Tensor;
use crate::model::Model;
use crate::model::state::State;
use crate::scene::validate::ResolvedMaterial;

/// Exact for products of quadratic gradients and then some.
const LINEAR_DEGREE: u32 = 4;

/// Load minus internal force on Lagrange nodes, and the volume constraint, where nodes have moved by
/// `nodal`, and within bodies by `within`.
pub(crate) fn residuals(
    model: &Model<'_>,
    state: &State,
    (nodal, within): (&[[f64; 3]], &[[f64; 3]]),
) -> (Vec<[f64; 3]>, Vec<f64>) {
    let simplex = match model.mesh.cell_kind().dimension() {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let rule = rule(simplex, degree(model));
    let mut out = (
        loads::external_load(model, state, nodal),
        vec![0.0; state.pressure.len()],
    );
    let body = Body {
        model,
        state,
        nodal: within,
        rule: &rule,
    };
    for cell in 0..model.mesh.cell_count() {
        body.add_cell(cell, &mut out);
    }
    out
}

/// Of rubber the solver's own: another rule would change the discrete problem.
fn degree(model: &Model<'_>) -> u32 {
    if model.plan.problem.resolved.is_rubber() {
        model.plan.strain_degree()
    } else {
        LINEAR_DEGREE
    }
}

/// A body in the state `state`, whose Lagrange displacement is `nodal` but for translations.
struct Body<'a, 'm> {
    model: &'a Model<'m>,
    state: &'a State,
    nodal: &'a [[f64; 3]],
    rule: &'a Rule,
}

impl Body<'_, '_> {
    /// Stress and volume defect at a displacement gradient and, in mixed form, a
    /// pressure.
    fn response(
        &self,
        material: &ResolvedMaterial,
        gradient: &Tensor<f64>,
        pressure: Option<f64>,
    ) -> (Tensor<f64>, f64) {
        if let Some(rubber) = &material.rubber {
            let pressure = pressure.unwrap_or(0.0);
            let deformed = Deformed::new(gradient);
            let defect = deformed.volume_defect(rubber, pressure);
            let share = self.state.penalty * rubber.shear_modulus() * defect;
            return (deformed.stress(rubber, pressure - share), defect);
        }
        let law = &material.law;
        let dilation = gradient[0][0] + gradient[1][1] + gradient[2][2];
        let pressure = pressure.unwrap_or_else(|| law.pressure(dilation));
        // The grad-div term takes part of the volume stress over.
        let penalty = self.model.plan.penalty() * law.shear_modulus * dilation;
        let stress = law.stress(gradient, pressure - penalty);
        (stress, dilation + pressure * law.inverse_lame)
    }

    /// Pressure at barycentric coordinates `l`; none in the displacement form.
    fn pressure(&self, vertices: &[u32], l: &[f64]) -> Option<f64> {
        (!self.state.pressure.is_empty()).then(|| {
            let at = vertices.iter().zip(l);
            let sum: f64 = at.map(|(&v, l)| l * self.state.pressure[v as usize]).sum();
            sum * self.model.plan.problem.units.stress
        })
    }

    fn add_cell(&self, number: usize, (force, constraint): &mut (Vec<[f64; 3]>, Vec<f64>)) {
        let model = self.model;
        let cell = Cell::new(model, number);
        let measure = model.mesh.cell_kind().signed_measure(&cell.corners);
        let vertices = model.mesh.cell(number);
        let material = usize::from(model.plan.problem.resolved.cell_material[number]);
        let material = &model.plan.problem.resolved.materials[material];
        for (l, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            let point = cell.point(&l[..vertices.len()], self.nodal);
            let weight = weight * measure * point.measure * turn(model, point.place[0]);
            let pressure = self.pressure(vertices, l);
            let (stress, defect) = self.response(material, &point.gradient, pressure);
            if pressure.is_some() {
                for (&vertex, l) in vertices.iter().zip(l) {
                    constraint[vertex as usize] += weight * l * defect;
                }
            }
            point.take_off(&cell, weight, &stress, force);
        }
    }
}
