//! The load vector at load factor one, non-dimensional, hierarchical.
//!
//! ```text
//! f_i = int_body b . phi_i dx + int_surface t . phi_i dS
//! ```
//!
//! `[displacement]`, over the smallest shear modulus; b force per undeformed volume, t
//! force per undeformed area. About an axis the radius is in the weight. Follower
//! pressures are no part of it: they depend on the state. Cost: one pass over cells and
//! loaded facets.

use std::f64::consts::TAU;

use crate::assembly::load::{Integral, LoadedFacet};
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Simplex, rule};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;

/// Degree of the rules for analytic loads and error norms.
pub(crate) const MANUFACTURED_DEGREE: u32 = 8;
/// Constant loads times quadratic functions.
const CONSTANT_DEGREE: u32 = 2;
/// Times the radius.
const DEGREE_ABOUT_AXIS: u32 = 3;
/// On curved cells and facets, whose measure varies.
const CURVED_DEGREE: u32 = 6;

/// Cell and facet simplex of a dimension.
pub(crate) fn simplices(dimension: usize) -> (Simplex, Simplex) {
    match dimension {
        2 => (Simplex::Triangle, Simplex::Segment),
        _ => (Simplex::Tetrahedron, Simplex::Triangle),
    }
}

/// All loads of the scene.
pub(crate) fn reference_load(plan: &Plan, mesh: &Mesh, prepared: &TaylorHoodData) -> Vec<f64> {
    let mut load = vec![0.0; prepared.space.displacement_unknowns()];
    match &plan.problem.resolved.manufactured {
        Some(field) => add_manufactured(plan, mesh, prepared, field, &mut load),
        None => add_constant(plan, mesh, prepared, &mut load),
    }
    load
}

/// Adds constant tractions and the body force to `load` `[displacement]`, integrated
/// exactly; about an axis with the radius as weight.
fn add_constant(plan: &Plan, mesh: &Mesh, prepared: &TaylorHoodData, load: &mut [f64]) {
    let (cell, facet) = simplices(plan.problem.units.dimension);
    let scale = plan.problem.units.coordinate_scale;
    let is_turned = plan.is_axisymmetric();
    let degree = match (is_turned, mesh.edge_offsets().is_empty()) {
        (_, false) => CURVED_DEGREE,
        (true, true) => DEGREE_ABOUT_AXIS,
        (false, true) => CONSTANT_DEGREE,
    };
    let turn = |value: [f64; 3], x: [f64; 3]| {
        if is_turned {
            value.map(|t| t * TAU * x[0])
        } else {
            value
        }
    };
    let surface_rule = rule(facet, degree);
    let surface = Integral {
        mesh,
        space: &prepared.space,
        scale,
        rule: &surface_rule,
    };
    for traction in &plan.problem.resolved.tractions {
        let value = traction.value.map(|t| t / plan.problem.units.stress);
        for &index in &traction.facets {
            let vertices = mesh.facet(index as usize);
            let facet = LoadedFacet::new(mesh, vertices, scale);
            surface.add_traction(&facet, &|x, _| turn(value, x), load);
        }
    }
    if plan.problem.resolved.has_body_force() {
        let value = plan
            .problem
            .resolved
            .body_force
            .map(|f| f / plan.problem.units.body_force());
        let volume_rule = rule(cell, degree);
        let radii = &prepared.geometry.radii;
        let density = |cell: usize, x: [f64; 3]| match radii.get(cell) {
            Some(radius) => value.map(|f| f * x[0] / radius),
            None => value,
        };
        let body = Integral {
            rule: &volume_rule,
            ..surface
        };
        body.add_body_force(&prepared.geometry, &density, load);
    }
}

/// Adds body force and boundary tractions of an analytic field to `load`
/// `[displacement]`, by the rule that the scene asks for.
fn add_manufactured(
    plan: &Plan,
    mesh: &Mesh,
    prepared: &TaylorHoodData,
    field: &Manufactured,
    load: &mut [f64],
) {
    let (cell, facet) = simplices(plan.problem.units.dimension);
    let degree = plan.problem.settings.quadrature_degree;
    let degree = degree.unwrap_or(MANUFACTURED_DEGREE);
    let scale = plan.problem.units.coordinate_scale;
    let units = plan.problem.units;
    let shear = |cell: usize| {
        let index = usize::from(plan.problem.resolved.cell_material[cell]);
        plan.problem.resolved.materials[index].law.shear_modulus
    };
    let force = |cell: usize, x: [f64; 3]| {
        field
            .body_force(x.map(|x| x * units.length), shear(cell))
            .map(|f| f / units.body_force())
    };
    let body = Integral {
        mesh,
        space: &prepared.space,
        scale,
        rule: &rule(cell, degree),
    };
    body.add_body_force(&prepared.geometry, &force, load);
    let surface = Integral {
        rule: &rule(facet, degree),
        ..body
    };
    for boundary in mesh.boundary_facets() {
        let vertices = &boundary.vertices[..units.dimension];
        let traction = |x: [f64; 3], normal: [f64; 3]| {
            field
                .traction(
                    x.map(|x| x * units.length),
                    normal,
                    shear(boundary.cell as usize),
                )
                .map(|t| t / units.stress)
        };
        // Held entries of the load belong to reactions and are never read.
        let facet = LoadedFacet::new(mesh, vertices, scale);
        surface.add_traction(&facet, &traction, load);
    }
}
