//! Loads that another code gives by nodes, facets or cells, non-dimensional, hierarchical:
//!
//! ```text
//! f_i = int_body b . phi_i dx + int_surface t . phi_i dS,   b, t = sum_a v_a N_a + v_part
//! ```
//!
//! `[displacement]`, dead loads at load factor one. Products of quadratic functions are
//! integrated exactly, about an axis with the radius as weight. Cost: one pass over the loaded
//! facets, and over the cells where the body force has values; nothing without values.

use std::borrow::Cow;
use std::f64::consts::TAU;

use super::Model;
use super::drive::Drive;
use super::loads::simplices;
use crate::assembly::load::{Integral, LoadedFacet, shape_values};
use crate::element::quadrature::rule;
use crate::scene::validate::Spread;

/// Degree of two quadratic functions.
const DEGREE: u32 = 4;
/// What the measure of curved cells and facets adds to it.
const CURVED: u32 = 2;

/// All dead loads at load factor one `[displacement]`.
pub(crate) fn dead_load<'a>(model: &Model<'a>, drive: &Drive) -> Cow<'a, [f64]> {
    let mut load = Cow::Borrowed(model.load);
    if !drive.given.is_unloaded() {
        add_given(model, drive, load.to_mut());
    }
    load
}

/// Adds what is given to `load` `[displacement]`.
fn add_given(model: &Model<'_>, drive: &Drive, load: &mut [f64]) {
    let (cell, facet) = simplices(model.plan.problem.units.dimension);
    let bent = match model.mesh.edge_offsets() {
        [] => 0,
        _ => CURVED,
    };
    let degree = DEGREE + u32::from(model.plan.is_axisymmetric()) + bent;
    let (cell_rule, facet_rule) = (rule(cell, degree), rule(facet, degree));
    let surface = Integral {
        mesh: model.mesh,
        space: &model.prepared.space,
        scale: model.plan.problem.units.coordinate_scale,
        rule: &facet_rule,
    };
    let tractions = model.plan.problem.resolved.tractions.iter();
    for (traction, spread) in tractions.zip(&drive.given.tractions) {
        if !spread.is_zero() {
            add_traction(model, &surface, (&traction.facets, spread), load);
        }
    }
    let body = Integral {
        rule: &cell_rule,
        ..surface
    };
    for spread in drive.given.body_force.iter().filter(|one| !one.is_zero()) {
        add_body_force(model, &body, spread, load);
    }
}

fn add_traction(
    model: &Model<'_>,
    surface: &Integral<'_>,
    (facets, spread): (&[u32], &Spread),
    load: &mut [f64],
) {
    let unit = 1.0 / model.plan.problem.units.stress;
    let space = &model.prepared.space;
    for &index in facets {
        let vertices = model.mesh.facet(index as usize);
        let facet = LoadedFacet::new(model.mesh, vertices, surface.scale);
        let part = Local::new(
            spread,
            (&space.facet_nodes(vertices), index),
            vertices.len(),
        );
        let density = |l: &[f64]| {
            let turn = if model.plan.is_axisymmetric() {
                TAU * facet.position(surface, l)[0]
            } else {
                1.0
            };
            part.at(l).map(|value| value * unit * turn)
        };
        surface.add_facet_density(&facet, &density, load);
    }
}

fn add_body_force(model: &Model<'_>, body: &Integral<'_>, spread: &Spread, load: &mut [f64]) {
    let unit = 1.0 / model.plan.problem.units.body_force();
    let geometry = &model.prepared.geometry;
    let locals = (0..model.mesh.cell_count()).map(|cell| {
        let nodes: Vec<u32> = body.nodes(cell).collect();
        Local::new(spread, (&nodes, cell as u32), model.mesh.cell(cell).len())
    });
    let locals: Vec<Local> = locals.collect();
    let density = |cell: usize, l: &[f64]| {
        let turn = geometry.radii.get(cell).map_or(1.0, |radius| {
            body.scale * model.mesh.position_in(cell, l)[0] / radius
        });
        locals[cell].at(l).map(|value| value * unit * turn)
    };
    body.add_cell_density(geometry, &density, load);
}

/// Values on one facet or cell, in the hierarchical basis.
struct Local {
    coefficients: Vec<[f64; 3]>,
    constant: [f64; 3],
}

impl Local {
    /// On the simplex of that number with these nodes, of which the first are `corners`.
    fn new(spread: &Spread, (nodes, part): (&[u32], u32), corners: usize) -> Self {
        let mut coefficients: Vec<[f64; 3]> =
            nodes.iter().map(|&node| spread.nodes.at(node)).collect();
        let mut edge = corners;
        for a in 0..corners {
            for b in a + 1..corners {
                let mean = |i: usize| 0.5 * (coefficients[a][i] + coefficients[b][i]);
                let mean = [mean(0), mean(1), mean(2)];
                if let Some(middle) = coefficients.get_mut(edge) {
                    middle.iter_mut().zip(mean).for_each(|(x, mean)| *x -= mean);
                }
                edge += 1;
            }
        }
        Self {
            coefficients,
            constant: spread.parts.at(part),
        }
    }

    /// The value at barycentric coordinates.
    fn at(&self, l: &[f64]) -> [f64; 3] {
        let mut value = self.constant;
        for (shape, row) in shape_values(l).iter().zip(&self.coefficients) {
            value
                .iter_mut()
                .zip(row)
                .for_each(|(sum, x)| *sum += shape * x);
        }
        value
    }
}
