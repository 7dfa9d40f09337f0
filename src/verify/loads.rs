//! The loads once more, on Lagrange nodes and in the caller's units, without
//! the load vector of the solver.

use super::cell::{facet_area, positions};
use super::pressures::Pushed;
use super::{shapes, turn};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::vector3::{add, norm, scale};
use crate::mesh::CurvedFacet;
use crate::model::Model;
use crate::model::given::Given;
use crate::model::state::State;
use crate::scene::validate::Spread;

/// Degree of the rule for constant loads.
const CONSTANT_DEGREE: u32 = 4;
/// Degree of the rule for analytic loads, which are part of the discrete problem.
const ANALYTIC_DEGREE: u32 = 8;
/// Degree of the rule for values of other codes, at every radius.
const VALUES_DEGREE: u32 = 6;
/// Degree of the rule where the measure of cells and facets varies.
const CURVED_DEGREE: u32 = 6;
/// Exact for cof F N times quadratic functions, at every radius.
const PRESSURE_DEGREE: u32 = 5;

/// The same times a quadratic function.
const FLUID_DEGREE: u32 = 7;

/// All loads at the state's load factor, and fluids, `[nodes, 3]`.
pub(crate) fn external_load(model: &Model<'_>, state: &State, nodal: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut force = vec![[0.0; 3]; model.prepared.space.nodes()];
    let field = model.plan.problem.resolved.manufactured.as_ref();
    let degree = match field {
        Some(_) => model
            .plan
            .problem
            .settings
            .quadrature_degree
            .unwrap_or(ANALYTIC_DEGREE),
        None if !model.mesh.edge_offsets().is_empty() => CURVED_DEGREE,
        None if state.drive.given.is_unloaded() => CONSTANT_DEGREE,
        None => VALUES_DEGREE,
    };
    let (cell, facet) = match model.plan.problem.units.dimension {
        2 => (Simplex::Triangle, Simplex::Segment),
        _ => (Simplex::Tetrahedron, Simplex::Triangle),
    };
    let given = &state.drive.given;
    let has_force = model.plan.problem.resolved.has_body_force() || !given.body_force.is_empty();
    if has_force || field.is_some() {
        let rule = &rule(cell, degree);
        Integral { model, given, rule }.add_volume(&mut force);
    }
    let surface = Integral {
        model,
        given,
        rule: &rule(facet, degree),
    };
    surface.add_surfaces(&mut force);
    let pushed = Pushed {
        model,
        rule: &rule(facet, PRESSURE_DEGREE),
        nodal,
    };
    pushed.add_pressures(&mut force);
    force
        .iter_mut()
        .for_each(|row| *row = scale(state.drive.load, *row));
    let pushed = Pushed {
        rule: &rule(facet, FLUID_DEGREE),
        ..pushed
    };
    pushed.add_fluids(state, &mut force);
    force
}

fn shear_modulus(model: &Model<'_>, cell: usize) -> f64 {
    let material = usize::from(model.plan.problem.resolved.cell_material[cell]);
    model.plan.problem.resolved.materials[material]
        .law
        .shear_modulus
}

/// Loads by one rule, as they are added to forces `[nodes, 3]`.
struct Integral<'a, 'm> {
    model: &'a Model<'m>,
    given: &'a Given,
    rule: &'a Rule,
}

/// The values that are given in a region, by its number, at the Lagrange functions there.
fn given_at(spread: Option<&Spread>, part: u32, nodes: &[u32], shapes: &[f64]) -> [f64; 3] {
    let Some(spread) = spread else {
        return [0.0; 3];
    };
    let mut value = spread.parts.at(part);
    for (&node, shape) in nodes.iter().zip(shapes) {
        let row = spread.nodes.at(node);
        (0..3).for_each(|i| value[i] += shape * row[i]);
    }
    value
}

/// A point of a region, in the caller's units.
struct Place {
    position: [f64; 3],
    /// Unit normal of a facet.
    normal: [f64; 3],
    /// Volume, area or length per weight of a rule.
    measure: f64,
}

/// A cell or facet in the caller's units.
struct Region<'a> {
    /// What another code gives there, by the number of the region.
    given: (Option<&'a Spread>, u32),
    /// Vertices, then edges.
    nodes: &'a [u32],
    /// Corners.
    corners: usize,
    /// Position, normal and measure at a point.
    at: &'a dyn Fn(&[f64]) -> Place,
    /// Ends of its edges.
    pairs: &'a [(usize, usize)],
}

impl Integral<'_, '_> {
    fn add_volume(&self, force: &mut [[f64; 3]]) {
        let model = self.model;
        let kind = model.mesh.cell_kind();
        let pairs = kind.edges();
        let factor = model.plan.problem.units.coordinate_scale * model.plan.problem.units.length;
        for cell in 0..model.mesh.cell_count() {
            let vertices = model.mesh.cell(cell);
            let measure = kind.signed_measure(&model.mesh.corners(cell).map(|x| scale(factor, x)));
            let density = |x: [f64; 3], _: [f64; 3]| match &model.plan.problem.resolved.manufactured
            {
                Some(field) => field.body_force(x, shear_modulus(model, cell)),
                None => model.plan.problem.resolved.body_force,
            };
            let edges = &model.mesh.cell_edges()[cell * pairs.len()..(cell + 1) * pairs.len()];
            let edge_nodes = edges
                .iter()
                .map(|&e| e + model.prepared.space.vertices as u32);
            let nodes: Vec<u32> = vertices.iter().copied().chain(edge_nodes).collect();
            let curves = &model.prepared.geometry.curves;
            let at = |l: &[f64]| Place {
                position: scale(factor, model.mesh.position_in(cell, l)),
                normal: [0.0; 3],
                measure: measure * curves.measure(cell, l),
            };
            let region = Region {
                given: (self.given.body_force.first(), cell as u32),
                nodes: &nodes,
                corners: vertices.len(),
                at: &at,
                pairs,
            };
            self.add(&region, &density, force);
        }
    }

    fn add_surfaces(&self, force: &mut [[f64; 3]]) {
        let model = self.model;
        if let Some(field) = &model.plan.problem.resolved.manufactured {
            for facet in model.mesh.boundary_facets() {
                let vertices = &facet.vertices[..model.plan.problem.units.dimension];
                let shear = shear_modulus(model, facet.cell as usize);
                let traction = |x: [f64; 3], n: [f64; 3]| field.traction(x, n, shear);
                self.add_facet((vertices, None, 0), &traction, force);
            }
            return;
        }
        for (index, traction) in model.plan.problem.resolved.tractions.iter().enumerate() {
            let given = self.given.tractions.get(index);
            for &facet in &traction.facets {
                let value = |_: [f64; 3], _: [f64; 3]| traction.value;
                let place = (model.mesh.facet(facet as usize), given, facet);
                self.add_facet(place, &value, force);
            }
        }
    }

    fn add_facet(
        &self,
        (vertices, given, facet): (&[u32], Option<&Spread>, u32),
        traction: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
        force: &mut [[f64; 3]],
    ) {
        let model = self.model;
        let corners = positions(model, vertices);
        let (area_vector, pairs) = facet_area(&corners);
        let factor = model.plan.problem.units.coordinate_scale * model.plan.problem.units.length;
        let flat = CurvedFacet {
            corners: [0, 1, 2].map(|v| corners.get(v).copied().unwrap_or_default()),
            offsets: [[0.0; 3]; 3],
        };
        let curve = CurvedFacet::of(model.mesh, factor, vertices);
        let at = |l: &[f64]| {
            let area = curve
                .as_ref()
                .map_or(area_vector, |curve| curve.area_vector(l));
            Place {
                position: curve.as_ref().unwrap_or(&flat).position(l),
                normal: scale(1.0 / norm(area), area),
                measure: norm(area),
            }
        };
        let region = Region {
            given: (given, facet),
            nodes: &model.prepared.space.facet_nodes(vertices),
            corners: vertices.len(),
            at: &at,
            pairs,
        };
        self.add(&region, traction, force);
    }

    fn add(
        &self,
        region: &Region<'_>,
        density: &dyn Fn([f64; 3], [f64; 3]) -> [f64; 3],
        force: &mut [[f64; 3]],
    ) {
        for (point, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            let l = &point[..region.corners];
            let place = (region.at)(l);
            let (values, _) = shapes(l, &[], region.pairs);
            let (spread, part) = region.given;
            let value = add(
                density(place.position, place.normal),
                given_at(spread, part, region.nodes, &values),
            );
            let weight = weight * place.measure * turn(self.model, place.position[0]);
            for (&node, shape) in region.nodes.iter().zip(&values) {
                for i in 0..3 {
                    force[node as usize][i] += weight * shape * value[i];
                }
            }
        }
    }
}
