//! The loads once more, on Lagrange nodes and in the caller's units, without
//! the load vector of the solver.

use super::super::evaluate::Context;
use super::super::state::State;
use super::{pressures, shapes, turn};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{cross, norm, scale, sub};

/// Degree of the rule for constant loads.
const CONSTANT_DEGREE: u32 = 4;
/// Degree of the rule for analytic loads, which are part of the discrete problem.
const ANALYTIC_DEGREE: u32 = 8;
/// Exact for cof F N times quadratic functions, at every radius.
const PRESSURE_DEGREE: u32 = 5;

/// All loads at the state's load factor, `[nodes, 3]`.
pub(super) fn external_load(
    context: &Context<'_>,
    state: &State,
    nodal: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let mut force = vec![[0.0; 3]; context.prepared.space.nodes()];
    let field = context.plan.resolved.manufactured.as_ref();
    let degree = match field {
        Some(_) => context
            .plan
            .scene
            .solver
            .quadrature_degree
            .unwrap_or(ANALYTIC_DEGREE),
        None => CONSTANT_DEGREE,
    };
    let (cell, facet) = match context.plan.units.dimension {
        2 => (Simplex::Triangle, Simplex::Segment),
        _ => (Simplex::Tetrahedron, Simplex::Triangle),
    };
    if context.plan.has_body_force() || field.is_some() {
        add_volume(context, &rule(cell, degree), &mut force);
    }
    add_surfaces(context, &rule(facet, degree), &mut force);
    pressures::add(context, &rule(facet, PRESSURE_DEGREE), nodal, &mut force);
    force
        .iter_mut()
        .for_each(|row| *row = scale(state.drive.load, *row));
    force
}

fn shear_modulus(context: &Context<'_>, cell: usize) -> f64 {
    let material = usize::from(context.plan.resolved.cell_material[cell]);
    context.plan.resolved.materials[material].law.shear_modulus
}

/// Corner positions in the caller's units.
pub(super) fn positions(context: &Context<'_>, vertices: &[u32]) -> Vec<[f64; 3]> {
    let factor = context.plan.units.coordinate_scale * context.plan.units.length;
    let corner = |&vertex: &u32| scale(factor, context.mesh.coordinates()[vertex as usize]);
    vertices.iter().map(corner).collect()
}

fn point_at(corners: &[[f64; 3]], l: &[f64]) -> [f64; 3] {
    let mut x = [0.0; 3];
    for (corner, l) in corners.iter().zip(l) {
        (0..3).for_each(|i| x[i] += l * corner[i]);
    }
    x
}

fn add_volume(context: &Context<'_>, rule: &Rule, force: &mut [[f64; 3]]) {
    let kind = context.mesh.cell_kind();
    let pairs = kind.edges();
    let factor = context.plan.units.coordinate_scale * context.plan.units.length;
    for cell in 0..context.mesh.cell_count() {
        let vertices = context.mesh.cell(cell);
        let measure = kind.signed_measure(&context.mesh.corners(cell).map(|x| scale(factor, x)));
        let corners = positions(context, vertices);
        let density = |x: [f64; 3]| match &context.plan.resolved.manufactured {
            Some(field) => field.body_force(x, shear_modulus(context, cell)),
            None => context.plan.scene.body_force,
        };
        let edges = &context.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
        let edge_nodes = edges
            .iter()
            .map(|&e| e + context.prepared.space.vertices as u32);
        let nodes: Vec<u32> = vertices.iter().copied().chain(edge_nodes).collect();
        add_simplex(
            context, rule, &nodes, &corners, measure, pairs, &density, force,
        );
    }
}

fn add_surfaces(context: &Context<'_>, rule: &Rule, force: &mut [[f64; 3]]) {
    if let Some(field) = &context.plan.resolved.manufactured {
        for facet in context.mesh.boundary_facets() {
            let vertices = &facet.vertices[..context.plan.units.dimension];
            let shear = shear_modulus(context, facet.cell as usize);
            let traction = |x: [f64; 3], n: [f64; 3]| field.traction(x, n, shear);
            add_facet(context, rule, vertices, &traction, force);
        }
        return;
    }
    let tractions = context.plan.scene.tractions.iter();
    for (traction, facets) in tractions.zip(&context.plan.resolved.traction_facets) {
        for &facet in facets {
            let value = |_: [f64; 3], _: [f64; 3]| traction.value;
            add_facet(
                context,
                rule,
                context.mesh.facet(facet as usize),
                &value,
                force,
            );
        }
    }
}

fn add_facet(
    context: &Context<'_>,
    rule: &Rule,
    vertices: &[u32],
    traction: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
    force: &mut [[f64; 3]],
) {
    let corners = positions(context, vertices);
    let along = sub(corners[1], corners[0]);
    let (area_vector, pairs): (_, &[(usize, usize)]) = match corners.get(2) {
        None => ([along[1], -along[0], 0.0], &[(0, 1)]),
        Some(&third) => (
            scale(0.5, cross(along, sub(third, corners[0]))),
            &[(0, 1), (0, 2), (1, 2)],
        ),
    };
    let area = norm(area_vector);
    let normal = scale(1.0 / area, area_vector);
    let nodes = context.prepared.space.facet_nodes(vertices);
    let density = |x: [f64; 3]| traction(x, normal);
    add_simplex(
        context, rule, &nodes, &corners, area, pairs, &density, force,
    );
}

#[allow(clippy::too_many_arguments)]
fn add_simplex(
    context: &Context<'_>,
    rule: &Rule,
    nodes: &[u32],
    corners: &[[f64; 3]],
    measure: f64,
    pairs: &[(usize, usize)],
    density: &dyn Fn([f64; 3]) -> [f64; 3],
    force: &mut [[f64; 3]],
) {
    for (point, weight) in rule.points.iter().zip(&rule.weights) {
        let l = &point[..corners.len()];
        let place = point_at(corners, l);
        let value = density(place);
        let weight = weight * measure * turn(context, place[0]);
        let (values, _) = shapes(l, &[], pairs);
        for (&node, shape) in nodes.iter().zip(&values) {
            for i in 0..3 {
                force[node as usize][i] += weight * shape * value[i];
            }
        }
    }
}
