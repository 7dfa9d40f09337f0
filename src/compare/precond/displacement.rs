//! The hierarchical preconditioners of the displacement block, which hold the
//! assembled edge block. Cost: its assembly.

use std::sync::Arc;

use crate::assembly::grid::Basis;
use crate::compare::assembly::edge_stiffness::edge_blocks;
use crate::compare::precond::hierarchical::{
    Additive, Multiplicative, Splitting, Symmetric, edge_sweep,
};
use crate::linalg::Preconditioner;
use crate::precond::node_pairs::NodePairs;
use crate::prepare::bodies::DisplacementBody;
use crate::scene::DisplacementMethod;

/// The preconditioner of `method` and its bytes without the P1 solver; none for the
/// solver's own.
pub(crate) fn displacement(
    method: DisplacementMethod,
    body: &DisplacementBody<'_>,
) -> Option<(Arc<dyn Preconditioner>, u64)> {
    let around: fn(Splitting) -> Arc<dyn Preconditioner> = match method {
        DisplacementMethod::PMultigrid => return None,
        DisplacementMethod::HierarchicalSsor => |parts| Arc::new(Symmetric(parts)),
        DisplacementMethod::HierarchicalMultiplicative => |parts| Arc::new(Multiplicative(parts)),
        DisplacementMethod::HierarchicalAdditive => |parts| Arc::new(Additive(parts)),
    };
    let (splitting, bytes) = splitting(body);
    Some((around(splitting), bytes))
}

/// A split into its vertex and edge parts with a preconditioner of each, and the bytes
/// that they hold.
fn splitting(body: &DisplacementBody<'_>) -> (Splitting, u64) {
    let vertex_unknowns = body.space.vertices * body.space.components;
    let blocks = edge_blocks(body.mesh, body.geometry, body.moduli);
    let pairs = NodePairs {
        diagonal: &blocks.diagonal,
        pairs: &blocks.pairs,
        off: &blocks.off,
    };
    let held = body.held.entries.iter();
    let held_edges = held.filter_map(|&unknown| unknown.checked_sub(vertex_unknowns as u32));
    let (edges, bytes) = edge_sweep(body.space.components, &pairs, held_edges);
    let splitting = Splitting {
        operator: Arc::new(body.stiffness(Basis::Hierarchical)),
        vertices: body.p1.clone(),
        edges,
        vertex_unknowns,
    };
    (splitting, bytes)
}
