//! Follower pressures by Nanson's formula with the deformation gradient of the cell
//! behind each face, undeformed outward normal N and area:
//!
//! ```text
//! f(v) = - int p cof(F) N . v dA
//! ```

use super::super::evaluate::Context;
use super::loads::positions;
use super::rubber::Deformed;
use super::volume::Cell;
use super::{shapes, turn};
use crate::element::quadrature::Rule;
use crate::geometry::vector3::{cross, dot, scale, sub};

/// Adds all pressures at load factor one to `force`.
pub(super) fn add(context: &Context<'_>, rule: &Rule, nodal: &[[f64; 3]], force: &mut [[f64; 3]]) {
    let pressures = context.plan.scene.pressures.iter();
    for (pressure, facets) in pressures.zip(&context.plan.resolved.pressure_facets) {
        for &facet in facets {
            add_facet(context, rule, facet as usize, pressure.value, nodal, force);
        }
    }
}

fn add_facet(
    context: &Context<'_>,
    rule: &Rule,
    facet: usize,
    pressure: f64,
    nodal: &[[f64; 3]],
    force: &mut [[f64; 3]],
) {
    let vertices = context.mesh.facet(facet);
    let corners = positions(context, vertices);
    let along = sub(corners[1], corners[0]);
    let (area, pairs): (_, &[(usize, usize)]) = match corners.get(2) {
        None => ([along[1], -along[0], 0.0], &[(0, 1)]),
        Some(&third) => (
            scale(0.5, cross(along, sub(third, corners[0]))),
            &[(0, 1), (0, 2), (1, 2)],
        ),
    };
    let (number, _) = context.mesh.facet_cell(facet);
    let cell = Cell::new(context, number);
    let nodes = context.prepared.space.facet_nodes(vertices);
    for (l, weight) in rule.points.iter().zip(&rule.weights) {
        let l = &l[..vertices.len()];
        let in_cell = barycentric(context.mesh.cell(number), vertices, l);
        let gradient = cell.point(&in_cell[..=vertices.len()], nodal).gradient;
        let cofactor = Deformed::new(&gradient).cofactor;
        let radius = l.iter().zip(&corners).map(|(l, x)| l * x[0]).sum();
        let factor = -pressure * weight * turn(context, radius);
        let push = cofactor.map(|row| factor * dot(row, area));
        let (values, _) = shapes(l, &[], pairs);
        for (&node, shape) in nodes.iter().zip(&values) {
            (0..3).for_each(|i| force[node as usize][i] += shape * push[i]);
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
