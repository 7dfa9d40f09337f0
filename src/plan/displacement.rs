//! The preconditioner of the displacement block: which one, why, and building it.
//!
//! The p-multigrid takes half the iterations of the hierarchical methods, one P1
//! solve per application instead of two, and holds no assembled edge block; it is
//! the choice for every scene. The others stand beside it for comparison.

use std::sync::Arc;

use super::Plan;
use super::approximation::{Deformed, VOLUMETRIC};
use super::saddle::Demand;
use crate::assembly::edge_stiffness::edge_blocks;
use crate::assembly::grid::Basis;
use crate::assembly::node_couplings::node_couplings;
use crate::assembly::strain::TangentStiffness;
use crate::assembly::{CellGeometry, CellModuli, Constrained, Grid, Stiffness};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::mesh::Mesh;
use crate::precond::hierarchical::{Additive, Multiplicative, Splitting, Symmetric, edge_sweep};
use crate::precond::lines::LagrangeNodes;
use crate::precond::symmetric_blocks::NodePairs;
use crate::precond::{AlongLines, NodeBlocks, PMultigrid, Transfer};
use crate::space::TaylorHood;

/// Preconditioners of the displacement block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DisplacementMethod {
    /// Chebyshev smoothing on P2 around a P1 solve.
    PMultigrid,
    /// P1, edges, P1.
    HierarchicalSsor,
    /// P1, then edges.
    HierarchicalMultiplicative,
    /// P1 and edges side by side.
    HierarchicalAdditive,
}

impl DisplacementMethod {
    /// `asked` is the scene's `solver.displacement_preconditioner`.
    pub(super) fn choose(asked: &str) -> Self {
        match asked {
            "hierarchical-ssor" => Self::HierarchicalSsor,
            "hierarchical-multiplicative" => Self::HierarchicalMultiplicative,
            "hierarchical-additive" => Self::HierarchicalAdditive,
            _ => Self::PMultigrid,
        }
    }

    /// What it asks of the outer method.
    pub(super) fn demand(self) -> Demand {
        match self {
            Self::HierarchicalMultiplicative => Demand::Flexible,
            Self::PMultigrid | Self::HierarchicalSsor | Self::HierarchicalAdditive => Demand::None,
        }
    }

    /// Whether the edge block is assembled.
    pub(super) fn is_hierarchical(self) -> bool {
        match self {
            Self::PMultigrid => false,
            Self::HierarchicalSsor
            | Self::HierarchicalMultiplicative
            | Self::HierarchicalAdditive => true,
        }
    }

    /// The pressure step, in units of the shear modulus, that goes with it: the
    /// poorer the preconditioner, the shorter.
    pub(super) fn pressure_step(self) -> f64 {
        if self.is_hierarchical() { 1.0 } else { 2.0 }
    }

    /// Applications beside those of p-multigrid at equal accuracy.
    pub(super) fn relative_applications(self) -> f64 {
        match self {
            Self::PMultigrid => 1.0,
            Self::HierarchicalSsor => 1.9,
            Self::HierarchicalMultiplicative => 2.2,
            Self::HierarchicalAdditive => 3.5,
        }
    }

    /// The choice in words and why.
    pub(super) fn describe(self, degree: usize) -> (String, &'static str) {
        let name = match self {
            Self::PMultigrid => {
                let reason = match degree {
                    2 => "well-shaped cells",
                    _ => "stretched cells or a stiff volume response",
                };
                return (format!("p-multigrid, Chebyshev degree {degree}"), reason);
            }
            Self::HierarchicalSsor => "hierarchical block SSOR: P1, edges, P1",
            Self::HierarchicalMultiplicative => "hierarchical block Gauss-Seidel: P1, edges",
            Self::HierarchicalAdditive => "hierarchical block Jacobi: P1 beside edges",
        };
        (
            name.to_owned(),
            "asked for; edges by one Gauss-Seidel sweep",
        )
    }
}

/// What it is built from.
pub(super) struct DisplacementBody<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) space: &'a TaylorHood,
    pub(super) geometry: &'a CellGeometry,
    pub(super) moduli: &'a CellModuli,
    pub(super) held: &'a Arc<[u32]>,
    pub(super) grid: &'a Arc<Grid>,
    pub(super) node_blocks: &'a NodeBlocks,
    pub(super) p1: Arc<dyn Preconditioner>,
    /// None at rest.
    pub(super) tangent: Option<Deformed<'a>>,
}

impl DisplacementBody<'_> {
    /// A in the given basis.
    pub(super) fn stiffness(&self, basis: Basis) -> Constrained<Stiffness> {
        Constrained {
            free: Stiffness {
                grid: self.grid.clone(),
                basis,
                size: self.space.displacement_unknowns(),
            },
            held: self.held.clone(),
        }
    }

    /// A in the given basis, or the tangent with its volume term.
    fn operator(&self, basis: Basis) -> Arc<dyn LinearOperator> {
        let Some(state) = self.tangent else {
            return Arc::new(self.stiffness(basis));
        };
        Arc::new(Constrained {
            free: TangentStiffness {
                cells: state.cells.clone(),
                at: state.at.clone(),
                basis,
                volumetric: VOLUMETRIC,
                size: self.space.displacement_unknowns(),
            },
            held: self.held.clone(),
        })
    }
}

/// The preconditioner that `plan` chose, and its bytes without the P1 solver.
pub(super) fn build(plan: &Plan, body: DisplacementBody<'_>) -> (Arc<dyn Preconditioner>, u64) {
    match plan.displacement {
        DisplacementMethod::PMultigrid => p_multigrid(plan, &body),
        DisplacementMethod::HierarchicalSsor => {
            let (splitting, bytes) = splitting(body);
            (Arc::new(Symmetric(splitting)), bytes)
        }
        DisplacementMethod::HierarchicalMultiplicative => {
            let (splitting, bytes) = splitting(body);
            (Arc::new(Multiplicative(splitting)), bytes)
        }
        DisplacementMethod::HierarchicalAdditive => {
            let (splitting, bytes) = splitting(body);
            (Arc::new(Additive(splitting)), bytes)
        }
    }
}

fn p_multigrid(plan: &Plan, body: &DisplacementBody<'_>) -> (Arc<dyn Preconditioner>, u64) {
    let transfer = Transfer::new(
        body.space.vertices,
        body.space.components,
        body.space.edges.clone(),
        body.held.clone(),
    );
    let inner = Arc::new(PMultigrid::new(
        body.operator(Basis::Lagrange),
        body.node_blocks.clone(),
        body.p1.clone(),
        transfer.clone(),
        plan.smoother_degree,
        &mut Workspace::new(),
    ));
    let bytes = inner.bytes();
    let around = plan
        .smooths_along_lines()
        .then(|| lines_around(plan, body, transfer, inner.clone()));
    match around.flatten() {
        Some(lines) => {
            let bytes = lines.bytes() + body.node_blocks.bytes();
            (Arc::new(lines), bytes)
        }
        None => (inner, bytes),
    }
}

/// `inner` between smoothings along strongly coupled nodes, where there are
/// groups of them.
fn lines_around(
    plan: &Plan,
    body: &DisplacementBody<'_>,
    transfer: Transfer,
    inner: Arc<PMultigrid>,
) -> Option<AlongLines> {
    let couplings = node_couplings(body.mesh, body.space, body.geometry, body.moduli);
    let scale = plan.units.coordinate_scale;
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
        held: body.held,
    };
    let operator = body.operator(Basis::Hierarchical);
    AlongLines::new(&nodes, operator, transfer, inner, &mut Workspace::new())
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

fn splitting(body: DisplacementBody<'_>) -> (Splitting, u64) {
    let vertex_unknowns = body.space.vertices * body.space.components;
    let blocks = edge_blocks(body.mesh, body.geometry, body.moduli);
    let pairs = NodePairs {
        diagonal: &blocks.diagonal,
        pairs: &blocks.pairs,
        off: &blocks.off,
    };
    let held = body.held.iter();
    let held_edges = held.filter_map(|&unknown| unknown.checked_sub(vertex_unknowns as u32));
    let (edges, bytes) = edge_sweep(body.space.components, &pairs, held_edges);
    let splitting = Splitting {
        operator: Arc::new(body.stiffness(Basis::Hierarchical)),
        vertices: body.p1,
        edges,
        vertex_unknowns,
    };
    (splitting, bytes)
}
