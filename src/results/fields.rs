//! Fields of the current state on the uploaded mesh, in the caller's units.
//!
//! Values are row-major `[rows, components]`: of vertices and edge midpoints in the order
//! of the upload, of cells, or of points along the surface. Vertices that no cell uses have zeros. Cost: one pass over
//! what the field lives on.

use crate::linalg::vector::norm;
use crate::material::LinearElastic;
use crate::model::Model;
use crate::model::state::State;
use crate::model::values::gradient_at;
use crate::report::{FieldData, FieldName};
use crate::results::estimate::cell_estimates;
use crate::results::finite_strain;
use crate::results::friction::{friction_traction, slip};
use crate::results::nodal_force::nodal_force;
use crate::results::touching::{PATH, Touching};
use crate::scene::SceneKind;

/// The field `name`; none if the scene has no such field. `mode` is the softest motion
/// `[displacement]`, where one is known.
pub(crate) fn field(
    model: &Model<'_>,
    (state, mode): (&State, Option<&[f64]>),
    name: FieldName,
) -> Option<FieldData> {
    let units = &model.plan.problem.units;
    let (components, values) = match name {
        FieldName::Displacement => {
            let nodal = model.prepared.space.node_values(&state.displacement);
            (3, on_nodes(model, &nodal, units.length))
        }
        FieldName::NodalForce => {
            let nodal = nodal_force(model, state);
            (3, on_nodes(model, &nodal, units.force()))
        }
        FieldName::Pressure => (1, pressure(model, state)?),
        FieldName::FrictionTraction => (3, friction_traction(model, state)?),
        FieldName::Slip => (3, slip(model, state)?),
        FieldName::LowestMode => (3, lowest_mode(model, mode?)),
        FieldName::Stress => {
            let of_cell = |cell| stress(model, state, cell).to_vec();
            (6, per_cell(model, of_cell))
        }
        FieldName::Jacobian => {
            let of_cell = |cell| vec![jacobian(model, state, cell)];
            (1, per_cell(model, of_cell))
        }
        FieldName::ErrorEstimate if model.plan.problem.resolved.is_rubber() => return None,
        FieldName::ErrorEstimate => (1, cell_estimates(model, state)),
        FieldName::ContactPressure => (1, touching(model, state)?.pressure()),
        FieldName::Gap => (1, touching(model, state)?.gap()),
        FieldName::ContactState => (1, touching(model, state)?.contact_state()),
        FieldName::ContactPressureDeformed if !model.is_rubber() => return None,
        FieldName::ContactPressureDeformed => (1, touching(model, state)?.pressure()),
        FieldName::ContactPressureUndeformed => {
            let touching = touching(model, state)?;
            let pressure = finite_strain::undeformed_pressure(model, state)?;
            (1, touching.at_nodes(&pressure))
        }
        FieldName::ContactPath => (PATH, touching(model, state)?.path()?),
        // Of a goal, not of the state: the session has it.
        FieldName::ErrorDensity | FieldName::MeshGradient => return None,
    };
    Some(FieldData {
        name,
        components,
        values,
    })
}

/// Whether the scene is one of plane stress.
pub(crate) fn is_sheet(model: &Model<'_>) -> bool {
    model.plan.problem.resolved.kind == SceneKind::PlaneStress
}

/// The pressures of the volume constraint at the vertices; none in a body without them, and in a
/// sheet, whose volume nothing constrains.
fn pressure(model: &Model<'_>, state: &State) -> Option<Vec<f64>> {
    if state.pressure.is_empty() || is_sheet(model) {
        return None;
    }
    let stress = model.plan.problem.units.stress;
    let shares = pressure_shares(model);
    let values = state.pressure.iter().zip(&shares);
    Some(on_uploaded(
        model,
        values.map(|(p, share)| share * p * stress),
    ))
}

/// The fields of contact; none without contact.
fn touching<'a>(model: &Model<'a>, state: &'a State) -> Option<Touching<'a>> {
    let has_contact = !model.interfaces.list.is_empty();
    has_contact.then(|| Touching::of(model, state))
}

/// Internal pressure over the pressure unknown in a cell.
pub(crate) fn pressure_share(model: &Model<'_>, cell: usize) -> f64 {
    let resolved = &model.plan.problem.resolved;
    let law = resolved.materials[usize::from(resolved.cell_material[cell])].law;
    law.pressure_share()
}

/// The same at vertices `[vertices]`; where materials meet the largest, which is one.
fn pressure_shares(model: &Model<'_>) -> Vec<f64> {
    let mut shares = vec![f64::NEG_INFINITY; model.prepared.space.vertices];
    for cell in 0..model.mesh.cell_count() {
        let share = pressure_share(model, cell);
        for &vertex in model.mesh.cell(cell) {
            let known = &mut shares[vertex as usize];
            *known = known.max(share);
        }
    }
    shares
}

/// Values of every cell one after the other `[cells, components]`.
fn per_cell(model: &Model<'_>, values: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    (0..model.mesh.cell_count()).flat_map(values).collect()
}

/// Vertex values of used vertices on all uploaded ones.
fn on_uploaded(model: &Model<'_>, values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut out = vec![0.0; model.mesh.vertex_count()];
    for (&uploaded, value) in model.mesh.used_vertices().iter().zip(values) {
        out[uploaded as usize] = value;
    }
    out
}

/// Values of nodes `[nodes * components]` at uploaded vertices, then at edges `[nodes, 3]`,
/// times `unit`; unused vertices are zero.
fn on_nodes(model: &Model<'_>, nodal: &[f64], unit: f64) -> Vec<f64> {
    let space = &model.prepared.space;
    let uploaded = model.mesh.vertex_count();
    let mut out = vec![0.0; 3 * (uploaded + space.edges.len())];
    let edges = uploaded as u32..(uploaded + space.edges.len()) as u32;
    let rows = model.mesh.used_vertices().iter().copied().chain(edges);
    for (row, value) in rows.zip(nodal.chunks_exact(space.components)) {
        for (i, component) in value.iter().enumerate() {
            out[3 * row as usize + i] = component * unit;
        }
    }
    out
}

/// `motion` `[displacement]` at uploaded vertices `[vertices, 3]`, its largest vector one
/// long.
fn lowest_mode(model: &Model<'_>, motion: &[f64]) -> Vec<f64> {
    let space = &model.prepared.space;
    let vertices = motion.chunks_exact(space.components).take(space.vertices);
    let largest = vertices.clone().map(norm).fold(0.0, f64::max);
    let mut out = vec![0.0; 3 * model.mesh.vertex_count()];
    for (&row, vector) in model.mesh.used_vertices().iter().zip(vertices) {
        let own = out[3 * row as usize..].iter_mut().zip(vector);
        own.for_each(|(out, x)| *out = x / largest);
    }
    out
}

/// Barycentric coordinates of the middle of a cell `[4]`, padded with zeros.
fn centre(model: &Model<'_>) -> [f64; 4] {
    let corners = model.prepared.geometry.vertices;
    std::array::from_fn(|i| {
        if i < corners {
            1.0 / corners as f64
        } else {
            0.0
        }
    })
}

/// Mean of J over one cell; linear bodies report 1 + div u at the middle.
pub(crate) fn jacobian(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    if model.plan.problem.resolved.is_rubber() {
        return finite_strain::volume_ratio(model, state, cell);
    }
    1.0 + dilation(model, state, cell)
}

/// div u at the middle of a cell of a linear body; with the strain across a sheet.
fn dilation(model: &Model<'_>, state: &State, cell: usize) -> f64 {
    let gradient = gradient_at(model, state, cell, &centre(model));
    let inside = gradient[0][0] + gradient[1][1];
    if is_sheet(model) {
        inside * (1.0 + law_of(model, cell).thinning())
    } else {
        inside + gradient[2][2]
    }
}

fn law_of(model: &Model<'_>, cell: usize) -> LinearElastic {
    let resolved = &model.plan.problem.resolved;
    resolved.materials[usize::from(resolved.cell_material[cell])].law
}

/// Mean stress of a cell: xx yy zz xy yz zx.
fn stress(model: &Model<'_>, state: &State, cell: usize) -> [f64; 6] {
    let gradient = gradient_at(model, state, cell, &centre(model));
    let law = law_of(model, cell);
    let pressure = if state.pressure.is_empty() {
        law.pressure(gradient[0][0] + gradient[1][1] + gradient[2][2])
    } else {
        let corners = model.mesh.cell(cell);
        let sum: f64 = corners.iter().map(|&v| state.pressure[v as usize]).sum();
        sum / corners.len() as f64 * model.plan.problem.units.stress
    };
    let mut s = match finite_strain::rubber(model, cell) {
        Some(rubber) => finite_strain::true_stress(rubber, &gradient, pressure, state.penalty),
        None => law.stress(&gradient, pressure),
    };
    if is_sheet(model) {
        s[2][2] = 0.0;
    }
    [s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[2][0]]
}
