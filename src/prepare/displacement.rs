//! Building the preconditioner of the displacement block that a plan chose, at rest
//! or about a deformed state.
//!
//! p-multigrid: Chebyshev smoothing on P2 around a P1 solve, between smoothings along
//! strongly coupled nodes where cells are stretched. Cost: node blocks and a few operator
//! products.

use std::sync::Arc;

use super::bodies::DisplacementBody;
use super::p1;
use crate::assembly::grid::Basis;
use crate::assembly::node_couplings::node_couplings;
use crate::assembly::p1_stiffness::{RIGID, project_couplings};
use crate::comparisons::Comparisons;
use crate::linalg::cholesky::Precision;
use crate::linalg::{LinearOperator, Preconditioner, Widened};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::lines::LagrangeNodes;
use crate::precond::node_pairs::NodePairs;
use crate::precond::p_multigrid::{Smoother, largest_eigenvalue};
use crate::precond::{AlongLines, NodeBlocks, PMultigrid, Transfer};
use crate::space::TaylorHood;

/// A preconditioner of the displacement block.
pub(crate) struct Built {
    /// The preconditioner.
    pub(crate) preconditioner: Arc<dyn Preconditioner>,
    /// Its bytes without the P1 solver.
    pub(crate) bytes: u64,
    /// How nodes move alone, in stretched cells with the nodes that they are coupled to: what the
    /// compliance of contact takes for the edges.
    pub(crate) nodes: Option<NodeBlocks>,
}

/// The preconditioner that `plan` chose.
pub(crate) fn build(plan: &Plan, body: &DisplacementBody<'_>) -> Built {
    let comparisons = plan.comparisons.as_ref();
    let other =
        |all: &Arc<dyn Comparisons>| all.displacement(plan.decisions.displacement, &body.split());
    match comparisons.and_then(other) {
        Some((preconditioner, bytes)) => Built {
            preconditioner,
            bytes,
            nodes: None,
        },
        None => p_multigrid(plan, body),
    }
}

fn p_multigrid(plan: &Plan, body: &DisplacementBody<'_>) -> Built {
    let transfer = Transfer::new(
        body.space.vertices,
        body.space.components,
        body.space.edges.clone(),
        body.held.clone(),
    );
    let (inner, bytes) = on_lagrange_nodes(plan, body, transfer.clone());
    let wants_lines = plan.smooths_along_lines() || plan.has_compliance_along_lines();
    let around = wants_lines.then(|| lines_around(plan, body, transfer, inner.clone()));
    let around = around.flatten();
    let contact = around
        .as_ref()
        .filter(|_| plan.has_compliance_along_lines());
    let nodes =
        contact.map(|lines| lines.with_groups(body.node_blocks, &on_contact(plan, body.space)));
    match around.filter(|_| plan.smooths_along_lines()) {
        Some(lines) => Built {
            bytes: lines.bytes() + bytes,
            nodes,
            preconditioner: Arc::new(lines),
        },
        None => Built {
            preconditioner: inner,
            bytes,
            nodes,
        },
    }
}

/// p-multigrid and its bytes; in single precision where the P1 factor may be.
fn on_lagrange_nodes(
    plan: &Plan,
    body: &DisplacementBody<'_>,
    transfer: Transfer,
) -> (Arc<dyn Preconditioner>, u64) {
    let single = may_be_single(plan, body).then(|| body.single_operator());
    let single = single.flatten();
    let Some((operator, bytes)) = single else {
        let operator = body.operator(Basis::Lagrange);
        let smoother = smoother(plan, body, &*operator);
        let inner = PMultigrid::new(Arc::new(operator), smoother, body.p1.clone(), transfer);
        let bytes = inner.bytes();
        return (Arc::new(inner), bytes);
    };
    let smoother = match body.tangent {
        // At rest the same in both precisions but for rounding: in double no last digit depends on
        // the instruction set.
        None => smoother(plan, body, &*body.operator(Basis::Lagrange)),
        Some(_) => {
            let size = body.space.displacement_unknowns();
            let operator = Widened {
                operator: &*operator,
                size,
            };
            smoother(plan, body, &operator)
        }
    };
    let inner = PMultigrid::new(operator, smoother, body.p1.clone(), transfer);
    let bytes = bytes + inner.bytes();
    (Arc::new(inner), bytes)
}

/// Whether the smoother bears single precision, and about a deformed state one tangent a cell: with
/// friction directions are forgotten in a system without symmetry, which stagnates where the
/// inverse is a little further from the tangent (decision 51).
fn may_be_single(plan: &Plan, body: &DisplacementBody<'_>) -> bool {
    let is_near = body.tangent.is_none() || !plan.has_friction();
    plan.factor_precision().0 == Precision::Single && is_near
}

/// Node blocks, steps and interval of the smoother of `operator`.
fn smoother(plan: &Plan, body: &DisplacementBody<'_>, operator: &dyn LinearOperator) -> Smoother {
    Smoother {
        blocks: body.node_blocks.clone(),
        smoothing: plan.smoothing(),
        largest: largest_eigenvalue(operator, body.node_blocks, body.held),
    }
}

/// `inner` between smoothings along strongly coupled nodes, where there are
/// groups of them.
fn lines_around(
    plan: &Plan,
    body: &DisplacementBody<'_>,
    transfer: Transfer,
    inner: Arc<dyn Preconditioner>,
) -> Option<AlongLines> {
    let mut couplings = node_couplings(body.mesh, body.space, body.geometry, body.moduli);
    let shift = p1::shift(plan);
    if shift > 0.0 {
        // A group may be a whole part of the body, whose rigid modes nothing else resists.
        couplings.add_mass(shift, (body.mesh, body.space), body.geometry, body.moduli);
    }
    let pairs = (&couplings.pairs[..], &mut couplings.off[..]);
    project_couplings(body.held, &mut couplings.diagonal, pairs, RIGID);
    let scale = plan.problem.units.coordinate_scale;
    let coordinates: Vec<[f64; 3]> = (0..body.space.nodes())
        .map(|node| node_position(body.mesh, body.space, node).map(|x| x * scale))
        .collect();
    let nodes = LagrangeNodes {
        components: body.space.components,
        coordinates: &coordinates,
        blocks: NodePairs {
            diagonal: &couplings.diagonal,
            pairs: &couplings.pairs,
            off: &couplings.off,
        },
        held: &body.held.entries,
    };
    let operator = body.operator(Basis::Hierarchical);
    AlongLines::new(&nodes, operator, transfer, inner)
}

/// Whether a node is a contact vertex or between two of them `[nodes]`.
fn on_contact(plan: &Plan, space: &TaylorHood) -> Vec<bool> {
    let mut is_seen = vec![false; space.nodes()];
    let vertices = plan.decisions.contact_vertices.iter();
    vertices.for_each(|&vertex| is_seen[vertex as usize] = true);
    for (edge, ends) in space.edges.iter().enumerate() {
        is_seen[space.vertices + edge] = ends.iter().all(|&end| is_seen[end as usize]);
    }
    is_seen
}

/// Position of a vertex or of the middle of an edge.
fn node_position(mesh: &Mesh, space: &TaylorHood, node: usize) -> [f64; 3] {
    let at = |vertex: u32| mesh.coordinates()[vertex as usize];
    match node.checked_sub(space.vertices) {
        None => at(node as u32),
        Some(edge) => {
            let [a, b] = space.edges[edge].map(at);
            std::array::from_fn(|i| 0.5 * (a[i] + b[i]))
        }
    }
}
