//! The volumes that the metrics of contact and of the internal pressure know apart, about one
//! linearisation: `b_k = B^T z_k` for the coarse pressures z_k of the body
//! ([`crate::precond::volume_mode`]). Cost: a P1 solve each.

use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::precond::volume_mode::{Flexibility, VolumeMode};
use crate::prepare::ApproximateInverse;
use crate::scene::MetricKind;

/// Those of a mixed body, whose volumes `divergence` gives; none where no metric asks for them.
pub(super) fn volumes(
    model: &Model<'_>,
    (inverse, divergence): (&ApproximateInverse, Option<&dyn LinearOperator>),
    work: &mut Workspace,
) -> Vec<VolumeMode> {
    let (Some(block), Some(divergence)) = (&model.prepared.pressure, divergence) else {
        return Vec::new();
    };
    let contact = &model.plan.contact;
    let has_contact = model.plan.unknowns().contact > 0;
    let is_asked =
        block.coarse.is_thin || (has_contact && contact.metric == MetricKind::Compliance);
    // Nested methods solve for the pressure at every step, and fixed steps want a metric
    // that is too large rather than too small.
    if !is_asked || contact.method.is_nested() || contact.method.has_fixed_steps() {
        return Vec::new();
    }
    let flexibility = Flexibility {
        p1: &*inverse.p1,
        node_blocks: &inverse.node_blocks,
        vertex_count: model.prepared.space.vertices,
        edge_ends: edge_ends(model),
        is_held: &model.prepared.is_held,
    };
    let mut modes: Vec<VolumeMode> = Vec::new();
    for pressures in block.coarse.pressures.clone() {
        let mut change = vec![0.0; divergence.columns()];
        divergence.apply_transposed(&pressures, &mut change, work);
        let mut slack = vec![0.0; pressures.len()];
        if let Some(stabilisation) = &block.stabilisation {
            stabilisation.apply(&pressures, &mut slack, work);
        }
        let parts = (pressures, &change[..], &slack[..]);
        let mode = VolumeMode::new(&flexibility, parts, &modes, work);
        modes.extend(mode);
    }
    modes
}

/// Ends of the edges where multipliers are quadratic.
pub(super) fn edge_ends<'a>(model: &Model<'a>) -> Option<&'a [[u32; 2]]> {
    let is_quadratic = model.plan.has_quadratic_multipliers();
    is_quadratic.then_some(&*model.prepared.space.edges)
}
