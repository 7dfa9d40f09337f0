//! The volumes that the metrics of contact and of the internal pressure know apart, about one
//! linearisation: `b_k = B^T z_k` for the coarse pressures z_k of the body
//! ([`crate::precond::volume_modes`]). Cost: a P1 solve each.

use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::model::Model;
use crate::precond::p1::Traces;
use crate::precond::volume_modes::{Flexibility, VolumeModes};
use crate::prepare::ApproximateInverse;
use crate::scene::MetricKind;

/// Those of a mixed body, whose volumes `divergence` gives; none where no metric asks for them.
pub(crate) fn volumes(
    model: &Model<'_>,
    (inverse, divergence): (&ApproximateInverse, Option<&dyn LinearOperator>),
    work: &mut Workspace,
) -> Option<VolumeModes> {
    let (Some(block), Some(divergence)) = (&model.prepared.pressure, divergence) else {
        return None;
    };
    let contact = &model.plan.decisions.contact;
    let has_contact = model.plan.unknowns().contact > 0;
    let is_asked =
        block.coarse.is_thin || (has_contact && contact.metric == MetricKind::Compliance);
    // Nested methods solve for the pressure at every step, and fixed steps want a metric
    // that is too large rather than too small.
    if !is_asked || contact.method.is_nested() || contact.method.has_fixed_steps() {
        return None;
    }
    let flexibility = Flexibility {
        p1: &*inverse.p1,
        traces: Traces {
            vertices: &inverse.traces.vertices,
            directions: &inverse.traces.directions,
        },
        node_blocks: &inverse.node_blocks,
        vertex_count: model.prepared.space.vertices,
        edge_ends: edge_ends(model),
        is_held: &model.prepared.is_held,
    };
    let pressures = block.coarse.pressures.clone();
    let changes = products(&pressures, divergence.columns(), |z, change| {
        divergence.apply_transposed(z, change, work);
    });
    let slacks = block.stabilisation.as_ref().map(|stabilisation| {
        products(&pressures, pressures.columns(), |z, slack| {
            stabilisation.apply(z, slack, work);
        })
    });
    let parts = (&changes, slacks.as_ref());
    Some(VolumeModes::new(&flexibility, pressures, parts))
}

/// The image of each row under `map` `[rows, columns]`.
fn products(
    rows: &SparseRows,
    columns: usize,
    mut map: impl FnMut(&[f64], &mut [f64]),
) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(columns);
    let mut row = vec![0.0; rows.columns()];
    let mut image = vec![0.0; columns];
    for place in 0..rows.rows() {
        row.fill(0.0);
        rows.add_row(place, 1.0, &mut row);
        map(&row, &mut image);
        builder.push_dense(&image, 0.0);
    }
    builder.finish()
}

/// Ends of the edges where multipliers are quadratic.
pub(super) fn edge_ends<'a>(model: &Model<'a>) -> Option<&'a [[u32; 2]]> {
    let is_quadratic = model.plan.has_quadratic_multipliers();
    is_quadratic.then_some(&*model.prepared.space.edges)
}
