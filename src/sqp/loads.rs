//! The load vector at load factor one, non-dimensional, hierarchical.

use std::f64::consts::TAU;

use crate::assembly::load::{add_body_force, add_traction, facet_measure};
use crate::element::manufactured::Manufactured;
use crate::element::quadrature::{Simplex, rule};
use crate::mesh::Mesh;
use crate::plan::{Plan, TaylorHoodData as Prepared};

/// Degree of the rules for analytic loads and error norms.
pub(super) const MANUFACTURED_DEGREE: u32 = 8;
/// Constant loads times quadratic functions.
const CONSTANT_DEGREE: u32 = 2;
/// Times the radius.
const DEGREE_ABOUT_AXIS: u32 = 3;

/// Cell and facet simplex of a dimension.
pub(super) fn simplices(dimension: usize) -> (Simplex, Simplex) {
    match dimension {
        2 => (Simplex::Triangle, Simplex::Segment),
        _ => (Simplex::Tetrahedron, Simplex::Triangle),
    }
}

/// All loads of the scene.
pub(crate) fn reference_load(plan: &Plan, mesh: &Mesh, prepared: &Prepared) -> Vec<f64> {
    let mut load = vec![0.0; prepared.space.displacement_unknowns()];
    match &plan.resolved.manufactured {
        Some(field) => add_manufactured(plan, mesh, prepared, field, &mut load),
        None => add_constant(plan, mesh, prepared, &mut load),
    }
    load
}

fn add_constant(plan: &Plan, mesh: &Mesh, prepared: &Prepared, load: &mut [f64]) {
    let (cell, facet) = simplices(plan.units.dimension);
    let scale = plan.units.coordinate_scale;
    let is_turned = plan.is_axisymmetric();
    let degree = match is_turned {
        true => DEGREE_ABOUT_AXIS,
        false => CONSTANT_DEGREE,
    };
    let turn = |value: [f64; 3], x: [f64; 3]| match is_turned {
        true => value.map(|t| t * TAU * x[0]),
        false => value,
    };
    let surface_rule = rule(facet, degree);
    for (traction, facets) in plan
        .scene
        .tractions
        .iter()
        .zip(&plan.resolved.traction_facets)
    {
        let value = traction.value.map(|t| t / plan.units.stress);
        for &index in facets {
            let vertices = mesh.facet(index as usize);
            let (area, _) = facet_measure(mesh, vertices, scale);
            let space = &prepared.space;
            add_traction(
                mesh,
                space,
                vertices,
                area,
                scale,
                &surface_rule,
                &|x| turn(value, x),
                load,
            );
        }
    }
    if plan.has_body_force() {
        let value = plan.scene.body_force.map(|f| f / plan.units.body_force());
        let volumes = &prepared.geometry.volumes;
        let volume_rule = rule(cell, degree);
        let radii = &prepared.geometry.radii;
        let density = |cell: usize, x: [f64; 3]| match radii.get(cell) {
            Some(radius) => value.map(|f| f * x[0] / radius),
            None => value,
        };
        add_body_force(
            mesh,
            &prepared.space,
            volumes,
            scale,
            &volume_rule,
            &density,
            load,
        );
    }
}

fn add_manufactured(
    plan: &Plan,
    mesh: &Mesh,
    prepared: &Prepared,
    field: &Manufactured,
    load: &mut [f64],
) {
    let (cell, facet) = simplices(plan.units.dimension);
    let degree = plan
        .scene
        .solver
        .quadrature_degree
        .unwrap_or(MANUFACTURED_DEGREE);
    let scale = plan.units.coordinate_scale;
    let units = plan.units;
    let shear = |cell: usize| {
        let index = usize::from(plan.resolved.cell_material[cell]);
        plan.resolved.materials[index].law.shear_modulus
    };
    let force = |cell: usize, x: [f64; 3]| {
        field
            .body_force(x.map(|x| x * units.length), shear(cell))
            .map(|f| f / units.body_force())
    };
    let volumes = &prepared.geometry.volumes;
    add_body_force(
        mesh,
        &prepared.space,
        volumes,
        scale,
        &rule(cell, degree),
        &force,
        load,
    );
    let surface_rule = rule(facet, degree);
    for boundary in mesh.boundary_facets() {
        let vertices = &boundary.vertices[..units.dimension];
        let (area, normal) = facet_measure(mesh, vertices, scale);
        let traction = |x: [f64; 3]| {
            field
                .traction(
                    x.map(|x| x * units.length),
                    normal,
                    shear(boundary.cell as usize),
                )
                .map(|t| t / units.stress)
        };
        // Held entries of the load belong to reactions and are never read.
        let space = &prepared.space;
        add_traction(
            mesh,
            space,
            vertices,
            area,
            scale,
            &surface_rule,
            &traction,
            load,
        );
    }
}
