//! Internal forces and volume constraints, cell by cell:
//!
//! ```text
//! int P : grad v,   int q (div u + p / lambda)   or   int q (J - 1 + p / K)
//! ```
//!
//! in the caller's units. About the axis x = 0 the strain around it is u_x / x and
//! the volume that of the full turn.

use super::super::evaluate::Context;
use super::super::state::State;
use super::rubber::Deformed;
use super::{loads, shapes, turn};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::tensor::Tensor;
use crate::mesh::barycentric_gradients;
use crate::scene::SceneKind;
use crate::scene::validate::ResolvedMaterial;

/// Exact for products of quadratic gradients and then some.
const LINEAR_DEGREE: u32 = 4;

/// Load minus internal force on Lagrange nodes, and the volume constraint.
pub(super) fn residuals(
    context: &Context<'_>,
    state: &State,
    nodal: &[[f64; 3]],
) -> (Vec<[f64; 3]>, Vec<f64>) {
    let simplex = match context.mesh.cell_kind().dimension() {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let rule = rule(simplex, degree(context));
    let mut out = (
        loads::external_load(context, state, nodal),
        vec![0.0; state.pressure.len()],
    );
    for cell in 0..context.mesh.cell_count() {
        add_cell(context, state, nodal, &rule, cell, &mut out);
    }
    out
}

/// Of rubber the solver's own: another rule would change the discrete problem.
fn degree(context: &Context<'_>) -> u32 {
    match context.plan.resolved.is_rubber() {
        true => context.plan.strain_degree(),
        false => LINEAR_DEGREE,
    }
}

/// A cell in the caller's units.
pub(super) struct Cell {
    corners: [[f64; 3]; 4],
    gradients: [[f64; 3]; 4],
    vertices: usize,
    pub(super) nodes: Vec<usize>,
    pairs: &'static [(usize, usize)],
    kind: SceneKind,
}

/// Shape functions and the displacement gradient at a point.
pub(super) struct Point {
    pub(super) gradient: Tensor<f64>,
    values: Vec<f64>,
    slopes: Vec<[f64; 3]>,
    /// x of the undeformed point.
    radius: f64,
}

impl Cell {
    pub(super) fn new(context: &Context<'_>, cell: usize) -> Self {
        let units = &context.plan.units;
        let kind = context.mesh.cell_kind();
        let scale = units.coordinate_scale * units.length;
        let corners = context.mesh.corners(cell).map(|x| x.map(|x| x * scale));
        let vertices = context.mesh.cell(cell);
        let pairs = kind.edges();
        let edges = &context.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
        let first = context.prepared.space.vertices;
        let edge_nodes = edges.iter().map(|&e| first + e as usize);
        Self {
            corners,
            gradients: barycentric_gradients(kind, &corners),
            vertices: vertices.len(),
            nodes: vertices
                .iter()
                .map(|&v| v as usize)
                .chain(edge_nodes)
                .collect(),
            pairs,
            kind: context.plan.resolved.kind,
        }
    }

    /// At barycentric coordinates `l`.
    pub(super) fn point(&self, l: &[f64], nodal: &[[f64; 3]]) -> Point {
        let (values, slopes) = shapes(l, &self.gradients[..self.vertices], self.pairs);
        let mut gradient = [[0.0; 3]; 3];
        let mut along = 0.0;
        for (&node, (value, slope)) in self.nodes.iter().zip(values.iter().zip(&slopes)) {
            along += value * nodal[node][0];
            for i in 0..3 {
                for j in 0..3 {
                    gradient[i][j] += nodal[node][i] * slope[j];
                }
            }
        }
        let radius = l.iter().zip(&self.corners).map(|(l, x)| l * x[0]).sum();
        if self.kind == SceneKind::Axisymmetric {
            // On the axis the strains across it are equal.
            gradient[2][2] = match radius > 0.0 {
                true => along / radius,
                false => gradient[0][0],
            };
        }
        Point {
            gradient,
            values,
            slopes,
            radius,
        }
    }
}

impl Point {
    /// Takes `weight` P : grad v off `force`.
    fn take_off(&self, cell: &Cell, weight: f64, stress: &Tensor<f64>, force: &mut [[f64; 3]]) {
        for (&node, slope) in cell.nodes.iter().zip(&self.slopes) {
            for i in 0..3 {
                for j in 0..3 {
                    force[node][i] -= weight * stress[i][j] * slope[j];
                }
            }
        }
        if cell.kind == SceneKind::Axisymmetric {
            let hoop = weight * stress[2][2] / self.radius;
            let values = cell.nodes.iter().zip(&self.values);
            values.for_each(|(&node, value)| force[node][0] -= hoop * value);
        }
    }
}

/// Stress and volume defect at a displacement gradient and, in mixed form, a
/// pressure.
fn response(
    context: &Context<'_>,
    penalty: f64,
    material: &ResolvedMaterial,
    gradient: &Tensor<f64>,
    pressure: Option<f64>,
) -> (Tensor<f64>, f64) {
    if let Some(rubber) = &material.rubber {
        let pressure = pressure.unwrap_or(0.0);
        let deformed = Deformed::new(gradient);
        let defect = deformed.volume_defect(rubber, pressure);
        let share = penalty * rubber.shear_modulus() * defect;
        return (deformed.stress(rubber, pressure - share), defect);
    }
    let law = &material.law;
    let dilation = gradient[0][0] + gradient[1][1] + gradient[2][2];
    let pressure = pressure.unwrap_or_else(|| law.pressure(dilation));
    // The grad-div term takes part of the volume stress over.
    let penalty = context.plan.penalty() * law.shear_modulus * dilation;
    let stress = law.stress(gradient, pressure - penalty);
    (stress, dilation + pressure * law.inverse_lame)
}

fn add_cell(
    context: &Context<'_>,
    state: &State,
    nodal: &[[f64; 3]],
    rule: &Rule,
    number: usize,
    (force, constraint): &mut (Vec<[f64; 3]>, Vec<f64>),
) {
    let cell = Cell::new(context, number);
    let measure = context.mesh.cell_kind().signed_measure(&cell.corners);
    let vertices = context.mesh.cell(number);
    let material = usize::from(context.plan.resolved.cell_material[number]);
    let material = &context.plan.resolved.materials[material];
    let is_mixed = !state.pressure.is_empty();
    for (l, weight) in rule.points.iter().zip(&rule.weights) {
        let point = cell.point(&l[..vertices.len()], nodal);
        let weight = weight * measure * turn(context, point.radius);
        let pressure = is_mixed.then(|| {
            let at = vertices.iter().zip(l);
            let sum: f64 = at.map(|(&v, l)| l * state.pressure[v as usize]).sum();
            sum * context.plan.units.stress
        });
        let (stress, defect) = response(
            context,
            state.penalty(),
            material,
            &point.gradient,
            pressure,
        );
        if is_mixed {
            for (&vertex, l) in vertices.iter().zip(l) {
                constraint[vertex as usize] += weight * l * defect;
            }
        }
        point.take_off(&cell, weight, &stress, force);
    }
}
