//! Follower pressures by Nanson's formula with the deformation gradient of the cell
//! behind each face, undeformed outward normal N and area:
//!
//! ```text
//! f(v) = - int p cof(F) N . v dA
//! ```

use super::cell::{Cell, facet_area, positions};
use super::rubber::Deformed;
use super::{shapes, turn};
use crate::element::quadrature::Rule;
use crate::geometry::vector3::{dot, scale};
use crate::mesh::CurvedFacet;
use crate::model::Model;
use crate::model::state::State;

/// A body under pressures, deformed by the Lagrange displacement `nodal` `[nodes, 3]`.
pub(crate) struct Pushed<'a, 'm> {
    /// The body.
    pub(crate) model: &'a Model<'m>,
    /// Rule on its facets.
    pub(crate) rule: &'a Rule,
    /// Displacement, in the caller's units.
    pub(crate) nodal: &'a [[f64; 3]],
}

impl Pushed<'_, '_> {
    /// Adds all pressures at load factor one to `force` `[nodes, 3]`.
    pub(crate) fn add_pressures(&self, force: &mut [[f64; 3]]) {
        for pressure in &self.model.plan.problem.resolved.pressures {
            for &facet in &pressure.facets {
                self.add_facet(facet as usize, &|_, _| pressure.value, force);
            }
        }
    }

    /// Adds the fluids of `state`: over a wet node its pressure times L^2, over a wet edge times
    /// 2 L L.
    pub(crate) fn add_fluids(&self, state: &State, force: &mut [[f64; 3]]) {
        let problem = &self.model.plan.problem;
        let fluids = problem.resolved.fluids.iter().zip(&problem.fluid_surfaces);
        let states = state.drive.fluids.iter().enumerate();
        for ((fluid, surface), (index, drive)) in fluids.zip(states) {
            let wet = state.share_of_fluid(index);
            let wet_at = |node: u32| {
                let place = surface.nodes.binary_search(&node);
                place.map_or(0.0, |place| wet[place])
            };
            let pressure = |nodes: &[u32], l: &[f64]| {
                let corners = l.iter().map(|l| l * l);
                let pairs = (0..l.len()).flat_map(|a| (a + 1..l.len()).map(move |b| (a, b)));
                let edges = pairs.map(|(a, b)| 2.0 * l[a] * l[b]);
                let shares = corners.chain(edges).zip(nodes);
                let wetted = shares.map(|(share, &node)| share * wet_at(node));
                drive.pressure * wetted.sum::<f64>()
            };
            for &facet in &fluid.facets {
                self.add_facet(facet as usize, &pressure, force);
            }
        }
    }

    /// Adds a pressure that depends on the nodes of the facet and barycentric coordinates.
    fn add_facet(
        &self,
        facet: usize,
        pressure: &dyn Fn(&[u32], &[f64]) -> f64,
        force: &mut [[f64; 3]],
    ) {
        let model = self.model;
        let vertices = model.mesh.facet(facet);
        let corners = positions(model, vertices);
        let (flat, pairs) = facet_area(&corners);
        let factor = model.plan.problem.units.coordinate_scale * model.plan.problem.units.length;
        let curve = CurvedFacet::of(model.mesh, factor, vertices);
        let (number, _) = model.mesh.facet_cell(facet);
        let cell = Cell::new(model, number);
        let nodes = model.prepared.space.facet_nodes(vertices);
        for (l, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            let l = &l[..vertices.len()];
            let in_cell = barycentric(model.mesh.cell(number), vertices, l);
            let point = cell.point(&in_cell[..=vertices.len()], self.nodal);
            let cofactor = Deformed::new(&point.gradient).cofactor;
            let area = curve.as_ref().map_or(flat, |curve| curve.area_vector(l));
            let factor = -pressure(&nodes, l) * weight * turn(model, point.place[0]);
            let push = if model.is_rubber() {
                cofactor.map(|row| factor * dot(row, area))
            } else {
                scale(factor, area)
            };
            let (values, _) = shapes(l, &[], pairs);
            for (&node, shape) in nodes.iter().zip(&values) {
                (0..3).for_each(|i| force[node as usize][i] += shape * push[i]);
            }
        }
    }
}

/// Coordinates in the cell of a point with coordinates `l` on its facet.
fn barycentric(cell: &[u32], facet: &[u32], l: &[f64]) -> [f64; 4] {
    let mut coordinates = [0.0; 4];
    for (coordinate, vertex) in coordinates.iter_mut().zip(cell) {
        let place = facet.iter().position(|one| one == vertex);
        *coordinate = place.map_or(0.0, |place| l[place]);
    }
    coordinates
}
