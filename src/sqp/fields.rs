//! Fields of the current state on the uploaded mesh, in the caller's units.

use super::estimate::cell_estimates;
use super::evaluate::Context;
use super::finite_strain;
use super::results::gradient_at;
use super::state::State;
use crate::report::{FieldData, FieldName};

/// The field `name`; none if the scene has no such field.
pub(crate) fn field(context: &Context<'_>, state: &State, name: FieldName) -> Option<FieldData> {
    let units = &context.plan.units;
    let has_contact = !context.interfaces.list.is_empty();
    let (components, values) = match name {
        FieldName::Displacement => (3, displacement(context, state)),
        FieldName::Pressure if state.pressure.is_empty() => return None,
        FieldName::Pressure => {
            let values = state.pressure.iter().map(|p| p * units.stress);
            (1, on_uploaded(context, values))
        }
        FieldName::ContactPressure
        | FieldName::ContactPressureDeformed
        | FieldName::Gap
        | FieldName::ContactState
            if !has_contact =>
        {
            return None;
        }
        FieldName::ContactPressure => (1, context.touching(state).pressure()),
        FieldName::Gap => (1, context.touching(state).gap()),
        FieldName::ContactState => (1, context.touching(state).contact_state()),
        FieldName::Stress => (
            6,
            per_cell(context, |cell| stress(context, state, cell).to_vec()),
        ),
        FieldName::Jacobian => (
            1,
            per_cell(context, |cell| vec![jacobian(context, state, cell)]),
        ),
        FieldName::ErrorEstimate if context.plan.resolved.is_rubber() => return None,
        FieldName::ErrorEstimate => (1, cell_estimates(context, state)),
        FieldName::ContactPressureDeformed => {
            let pressure = finite_strain::deformed_pressure(context, state)?;
            let touching = context.touching(state);
            (1, touching.on_surface(&pressure, 0.0, f64::max))
        }
    };
    Some(FieldData {
        name,
        components,
        values,
    })
}

fn per_cell(context: &Context<'_>, values: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    (0..context.mesh.cell_count()).flat_map(values).collect()
}

/// Vertex values of used vertices on all uploaded ones.
fn on_uploaded(context: &Context<'_>, values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut out = vec![0.0; context.mesh.vertex_count()];
    for (&uploaded, value) in context.mesh.used_vertices().iter().zip(values) {
        out[uploaded as usize] = value;
    }
    out
}

fn displacement(context: &Context<'_>, state: &State) -> Vec<f64> {
    let space = &context.prepared.space;
    let nodal = space.node_values(&state.displacement);
    let uploaded = context.mesh.vertex_count();
    let mut out = vec![0.0; 3 * (uploaded + space.edges.len())];
    let edges = uploaded as u32..(uploaded + space.edges.len()) as u32;
    let rows = context.mesh.used_vertices().iter().copied().chain(edges);
    for (row, value) in rows.zip(nodal.chunks_exact(space.components)) {
        for (i, component) in value.iter().enumerate() {
            out[3 * row as usize + i] = component * context.plan.units.length;
        }
    }
    out
}

fn centre(context: &Context<'_>) -> [f64; 4] {
    let corners = context.prepared.geometry.vertices;
    std::array::from_fn(|i| {
        if i < corners {
            1.0 / corners as f64
        } else {
            0.0
        }
    })
}

fn jacobian(context: &Context<'_>, state: &State, cell: usize) -> f64 {
    if context.plan.resolved.is_rubber() {
        return finite_strain::volume_ratio(context, state, cell);
    }
    let gradient = gradient_at(context, state, cell, &centre(context));
    1.0 + gradient[0][0] + gradient[1][1] + gradient[2][2]
}

/// Mean stress of a cell: xx yy zz xy yz zx.
fn stress(context: &Context<'_>, state: &State, cell: usize) -> [f64; 6] {
    let gradient = gradient_at(context, state, cell, &centre(context));
    let law =
        context.plan.resolved.materials[usize::from(context.plan.resolved.cell_material[cell])].law;
    let pressure = match state.pressure.is_empty() {
        true => law.pressure(gradient[0][0] + gradient[1][1] + gradient[2][2]),
        false => {
            let corners = context.mesh.cell(cell);
            let sum: f64 = corners.iter().map(|&v| state.pressure[v as usize]).sum();
            sum / corners.len() as f64 * context.plan.units.stress
        }
    };
    let s = match finite_strain::rubber(context, cell) {
        Some(rubber) => finite_strain::true_stress(rubber, &gradient, pressure, state.penalty()),
        None => law.stress(&gradient, pressure),
    };
    [s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[2][0]]
}
