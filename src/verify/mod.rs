//! The independent path: residuals recomputed cell by cell from the reported
//! fields, with Lagrange shape functions and a higher rule, in the caller's
//! units, sharing no kernel with the solver, and measured by the solver's scales.
//!
//! Cost: one pass over the cells with some hundred flops per point.

mod area;
mod cell;
mod contact;
mod friction;
mod loads;
mod pressures;
mod rubber;
mod volume;

use std::f64::consts::TAU;

use contact::Faces;

use crate::linalg::vector::{norm, ratio};
use crate::model::Model;
use crate::model::ending::Ending;
use crate::model::evaluate::pressure_scale;
use crate::model::state::State;
use crate::report::{FieldName, Residuals};
use crate::results::fields;
use crate::scene::SceneKind;

/// Residuals of `state`, relative to the scales of the solve.
pub(crate) fn verify(model: &Model<'_>, state: &State, ending: &Ending) -> Residuals {
    let units = &model.plan.problem.units;
    let nodal = nodal_displacement(model, state);
    let relative = relative_displacement(model, state);
    let within = relative.as_deref().unwrap_or(&nodal);
    let (mut force, constraint) = volume::residuals(model, state, (&nodal, within));
    let body = free_hierarchical(model, &force);
    let faces = Faces::new(model, &nodal);
    let (gap, scaled_pressure) = contact::residuals(&faces, state, &mut force);
    let friction = model.interfaces.friction.as_ref();
    let friction =
        friction.map(|friction| friction::residuals(friction, (model, state), &faces, &mut force));
    let force = free_hierarchical(model, &force);
    let carried: Vec<f64> = body.iter().zip(&force).map(|(a, b)| a - b).collect();
    let force_scale = ending.force_scale * units.force();
    let gap_unit = units.area() * units.length;
    let wrong = gap
        .iter()
        .zip(&state.status)
        .map(|(&g, status)| if status.is_closed() { g } else { g.min(0.0) });
    let mut wrong: Vec<f64> = wrong.collect();
    let products: f64 = gap
        .iter()
        .zip(&scaled_pressure)
        .map(|(g, l)| (g * l).abs())
        .sum();
    let contacts = model.plan.normal_multipliers();
    let one_sided = scaled_pressure[..contacts].iter();
    let mut negative: Vec<f64> = one_sided.map(|l| l.min(0.0)).collect();
    if let Some(misfit) = friction {
        wrong[misfit.tractions].copy_from_slice(&misfit.slip);
        negative.extend(misfit.excess);
    }
    let pressure_scale = pressure_scale(norm(&scaled_pressure), norm(&carried), force_scale);
    let gap_scale = state.scales.gap * gap_unit;
    Residuals {
        equilibrium: ratio(norm(&force), force_scale),
        incompressibility: ratio(norm(&constraint), state.scales.constraint * units.volume()),
        complementarity: ratio(products, pressure_scale * gap_scale)
            + ratio(norm(&negative), pressure_scale),
        gap: ratio(norm(&wrong), gap_scale),
    }
}

/// Reported displacement on used nodes, `[nodes, 3]`.
fn nodal_displacement(model: &Model<'_>, state: &State) -> Vec<[f64; 3]> {
    let uploaded = model.mesh.vertex_count();
    let Some(field) = fields::field(model, (state, None), FieldName::Displacement) else {
        return Vec::new();
    };
    let (rows, _) = field.values.as_chunks::<3>();
    let vertices = model.mesh.used_vertices().iter().map(|&v| rows[v as usize]);
    vertices.chain(rows[uploaded..].iter().copied()).collect()
}

/// The same as far as bodies do not move alike, where the state has more digits of that; none elsewhere.
fn relative_displacement(model: &Model<'_>, state: &State) -> Option<Vec<[f64; 3]>> {
    state.remainder.as_ref()?;
    let relative = State {
        displacement: state.relative_displacement().into_owned(),
        ..state.clone()
    };
    Some(nodal_displacement(model, &relative))
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
fn turn(model: &Model<'_>, radius: f64) -> f64 {
    match model.plan.problem.resolved.kind {
        SceneKind::Axisymmetric => TAU * radius,
        SceneKind::Solid | SceneKind::PlaneStrain | SceneKind::PlaneStress => 1.0,
    }
}

/// Free rows in the basis that the criteria are measured in.
fn free_hierarchical(model: &Model<'_>, lagrange: &[[f64; 3]]) -> Vec<f64> {
    let space = &model.prepared.space;
    let mut rows = lagrange.to_vec();
    for (edge, ends) in space.edges.iter().enumerate() {
        let half = lagrange[space.vertices + edge].map(|x| 0.5 * x);
        for &end in ends {
            (0..3).for_each(|i| rows[end as usize][i] += half[i]);
        }
    }
    let c = space.components;
    for one in &model.plan.problem.held_nodes {
        one.held.project(&mut rows[one.held.node as usize]);
    }
    let is_held = &model.prepared.is_held;
    rows.iter()
        .enumerate()
        .flat_map(|(node, row)| (0..c).map(move |i| (node * c + i, row[i])))
        .filter(|&(unknown, _)| !is_held[unknown])
        .map(|(_, value)| value)
        .collect()
}

#[cfg(test)]
mod tests;
