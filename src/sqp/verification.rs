//! The independent path: residuals recomputed cell by cell from the reported
//! fields, with Lagrange shape functions and a higher rule, in the caller's
//! units, sharing no kernel with the solver.
//!
//! Cost: one pass over the cells with some hundred flops per point.

mod loads;
mod pressures;
mod rubber;
mod volume;

use std::f64::consts::TAU;

use super::evaluate::{Context, ratio};
use super::fields;
use super::increment::Ending;
use super::state::State;
use crate::element::quadrature::{Simplex, rule};
use crate::linalg::vector::norm;
use crate::obstacle::Obstacle;
use crate::report::{FieldName, Residuals};
use crate::scene::SceneKind;

/// Another rule on the faces than the solver's own would change the discrete
/// problem; this is the degree that the contract names.
const FACE_DEGREE: u32 = 8;

/// Residuals of `state`, relative to the scales of the solve.
pub(crate) fn verify(context: &Context<'_>, state: &State, ending: &Ending) -> Residuals {
    let units = &context.plan.units;
    let nodal = nodal_displacement(context, state);
    let (mut force, constraint) = volume::residuals(context, state, &nodal);
    let (gap, scaled_pressure) = contact_residuals(context, state, &nodal, &mut force);
    let force = free_hierarchical(context, &force);
    let gap_unit = units.area() * units.length;
    let wrong = gap
        .iter()
        .zip(&state.active)
        .map(|(&g, &active)| match active {
            true => g,
            false => g.min(0.0),
        });
    let wrong: Vec<f64> = wrong.collect();
    let products: f64 = gap
        .iter()
        .zip(&scaled_pressure)
        .map(|(g, l)| (g * l).abs())
        .sum();
    let negative: Vec<f64> = scaled_pressure.iter().map(|l| l.min(0.0)).collect();
    let pressure_norm = norm(&scaled_pressure);
    let gap_scale = state.scales.gap * gap_unit;
    Residuals {
        equilibrium: ratio(norm(&force), ending.force_scale * units.force()),
        incompressibility: ratio(norm(&constraint), state.scales.constraint * units.volume()),
        complementarity: ratio(products, pressure_norm * gap_scale)
            + ratio(norm(&negative), pressure_norm),
        gap: ratio(norm(&wrong), gap_scale),
    }
}

/// Reported displacement on used nodes, `[nodes, 3]`.
fn nodal_displacement(context: &Context<'_>, state: &State) -> Vec<[f64; 3]> {
    let uploaded = context.mesh.vertex_count();
    let Some(field) = fields::field(context, state, FieldName::Displacement) else {
        return Vec::new();
    };
    let (rows, _) = field.values.as_chunks::<3>();
    let vertices = context
        .mesh
        .used_vertices()
        .iter()
        .map(|&v| rows[v as usize]);
    vertices.chain(rows[uploaded..].iter().copied()).collect()
}

/// Lagrange P2 values and gradients at one point: vertices, then edges.
fn shapes(l: &[f64], g: &[[f64; 3]], pairs: &[(usize, usize)]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let mut values: Vec<f64> = l.iter().map(|&l| l * (2.0 * l - 1.0)).collect();
    let mut slopes: Vec<[f64; 3]> = l
        .iter()
        .zip(g)
        .map(|(&l, g)| g.map(|x| (4.0 * l - 1.0) * x))
        .collect();
    for &(a, b) in pairs {
        values.push(4.0 * l[a] * l[b]);
        let slope = |j: usize| {
            let at = |v: usize| g.get(v).map_or(0.0, |g| g[j]);
            4.0 * (l[a] * at(b) + l[b] * at(a))
        };
        slopes.push([slope(0), slope(1), slope(2)]);
    }
    (values, slopes)
}

/// The way of a point at `radius` around the axis, where the body is turned.
fn turn(context: &Context<'_>, radius: f64) -> f64 {
    match context.plan.resolved.kind {
        SceneKind::Axisymmetric => TAU * radius,
        SceneKind::Solid | SceneKind::PlaneStrain => 1.0,
    }
}

/// Weighted gaps and contact pressures in the caller's units; adds the contact
/// force to `force`.
fn contact_residuals(
    context: &Context<'_>,
    state: &State,
    nodal: &[[f64; 3]],
    force: &mut [[f64; 3]],
) -> (Vec<f64>, Vec<f64>) {
    let units = &context.plan.units;
    let dimension = units.dimension;
    let simplex = if dimension == 2 {
        Simplex::Segment
    } else {
        Simplex::Triangle
    };
    let rule = rule(simplex, FACE_DEGREE);
    let pairs: &[(usize, usize)] = if dimension == 2 {
        &[(0, 1)]
    } else {
        &[(0, 1), (0, 2), (1, 2)]
    };
    let obstacles = context.interfaces.obstacles(&state.drive, units.length);
    let pressure: Vec<f64> = state.multiplier.iter().map(|l| l * units.stress).collect();
    let mut gap = vec![0.0; pressure.len()];
    let scale = units.coordinate_scale * units.length;
    for (interface, obstacle) in context.interfaces.list.iter().zip(&obstacles) {
        for face in &interface.surface.faces {
            let area = match face.radii {
                None => face.area * units.area(),
                // Its length; the way around is that of each point.
                Some([a, b]) => face.area / (0.5 * TAU * (a + b)) * units.length,
            };
            for (point, weight) in rule.points.iter().zip(&rule.weights) {
                let l = &point[..dimension];
                let (values, _) = shapes(l, &[], pairs);
                let mut x = [0.0; 3];
                for (&vertex, l) in face.corners.iter().zip(l) {
                    let corner = context.mesh.coordinates()[vertex as usize];
                    (0..3).for_each(|i| x[i] += l * corner[i] * scale);
                }
                let area = area * turn(context, x[0]);
                for (&node, shape) in face.nodes.iter().zip(&values) {
                    (0..3).for_each(|i| x[i] += shape * nodal[node as usize][i]);
                }
                let contact = obstacle.distance(x.map(|x| x / units.length));
                let at = face.multipliers.iter().zip(l);
                let local: f64 = at
                    .clone()
                    .map(|(&m, l)| l * pressure[interface.offset + m as usize])
                    .sum();
                for (&m, l) in at {
                    gap[interface.offset + m as usize] +=
                        weight * area * l * contact.distance * units.length;
                }
                for (&node, shape) in face.nodes.iter().zip(&values) {
                    for i in 0..3 {
                        force[node as usize][i] +=
                            weight * area * shape * local * contact.normal[i];
                    }
                }
            }
        }
    }
    (gap, pressure)
}

/// Free rows in the basis that the criteria are measured in.
fn free_hierarchical(context: &Context<'_>, lagrange: &[[f64; 3]]) -> Vec<f64> {
    let space = &context.prepared.space;
    let mut rows = lagrange.to_vec();
    for (edge, ends) in space.edges.iter().enumerate() {
        let half = lagrange[space.vertices + edge].map(|x| 0.5 * x);
        for &end in ends {
            (0..3).for_each(|i| rows[end as usize][i] += half[i]);
        }
    }
    let c = space.components;
    let is_held = &context.prepared.is_held;
    rows.iter()
        .enumerate()
        .flat_map(|(node, row)| (0..c).map(move |i| (node * c + i, row[i])))
        .filter(|&(unknown, _)| !is_held[unknown])
        .map(|(_, value)| value)
        .collect()
}

#[cfg(test)]
mod tests;
