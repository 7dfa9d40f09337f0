//! Everything that depends on mesh, supports, material and candidate surface
//! only: immutable, shared by all sessions with the same [`super::PreparedKey`].

use std::sync::Arc;
use std::time::Instant;

use super::Plan;
use super::p1::{self, P1Body};
use crate::assembly::grid::{Basis, Rows};
use crate::assembly::mass::weighted_mass;
use crate::assembly::node_couplings::node_couplings;
use crate::assembly::node_moduli::softness;
use crate::assembly::p1_stiffness::node_blocks;
use crate::assembly::{Body, CellGeometry, CellModuli, Divergence, Grid, Stiffness};
use crate::linalg::vector::norm;
use crate::linalg::{
    DenseMatrix, FactoriseError, LinearOperator, Preconditioner, SparseRows, Workspace,
};
use crate::mesh::Mesh;
use crate::precond::schur::ChebyshevMass;
use crate::precond::{AlongLines, NodeBlocks, NodePairs, PMultigrid, Transfer};
use crate::report::{CancelToken, Seconds, Termination};
use crate::space::TaylorHood;

/// Chebyshev steps that invert the pressure mass.
const MASS_STEPS: usize = 6;

/// Why preparation failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PrepareError {
    /// The caller cancelled or its time is up.
    #[error("stopped while preparing: {}", .0.name())]
    Stopped(Termination),
    /// A11 cannot be factorised.
    #[error("the P1 stiffness cannot be factorised: {0}")]
    Factorise(#[from] FactoriseError),
}

/// The pressure block.
#[derive(Debug)]
pub(crate) struct PressureBlock {
    pub(crate) coupling: Divergence,
    /// Displacement and pressure in one product.
    pub(crate) body: Body,
    /// C = M / lambda; none when every material is incompressible.
    pub(crate) stabilisation: Option<SparseRows>,
    pub(crate) metric: ChebyshevMass,
    /// No free boundary: a constant pressure does no work.
    pub(crate) is_enclosed: bool,
}

/// Prepared data.
pub struct Prepared {
    pub(crate) space: TaylorHood,
    pub(crate) geometry: CellGeometry,
    pub(crate) grid: Arc<Grid>,
    pub(crate) held: Arc<[u32]>,
    pub(crate) is_held: Vec<bool>,
    pub(crate) stiffness: Stiffness,
    pub(crate) displacement: Arc<dyn Preconditioner>,
    smoother_bytes: u64,
    pub(crate) node_blocks: NodeBlocks,
    pub(crate) pressure: Option<PressureBlock>,
    /// A11^-1 on the contact vertices along `contact_normals`; empty without contact.
    pub(crate) compliance: DenseMatrix,
    pub(crate) contact_normals: Vec<[f64; 3]>,
    p1_bytes: u64,
    p1_part: &'static str,
    seconds: Seconds,
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Prepared")
            .field("unknowns", &self.space.displacement_unknowns())
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl Prepared {
    /// Builds the data of `plan`.
    ///
    /// # Errors
    /// [`PrepareError`]; the token is polled between phases.
    pub fn build(
        plan: &Plan,
        mesh: &Arc<Mesh>,
        cancel: &CancelToken,
    ) -> Result<Self, PrepareError> {
        let start = Instant::now();
        let poll = || {
            cancel
                .stopped()
                .map_or(Ok(()), |t| Err(PrepareError::Stopped(t)))
        };
        let space = TaylorHood::new(mesh);
        let geometry = CellGeometry::new(mesh, plan.units.coordinate_scale);
        let moduli = moduli(plan);
        let held: Arc<[u32]> = plan.held.iter().map(|&(unknown, _)| unknown).collect();
        poll()?;
        let body = P1Body {
            mesh,
            space: &space,
            geometry: &geometry,
            moduli: &moduli,
            held: &held,
        };
        let (p1, (grid, blocks)) = rayon::join(
            || p1::build(plan, body, cancel),
            || {
                let grid = Arc::new(Grid::new(mesh, &space, &geometry, &moduli, &held));
                let blocks = node_blocks(mesh, &space, &geometry, &moduli, &held);
                (grid, NodeBlocks::invert(space.components, blocks))
            },
        );
        let p1 = p1?;
        poll()?;
        let stiffness = |basis| Stiffness {
            grid: grid.clone(),
            basis,
            size: space.displacement_unknowns(),
            held: held.clone(),
        };
        let transfer = Transfer::new(
            space.vertices,
            space.components,
            space.edges.clone(),
            held.clone(),
        );
        let cycle = |degree: usize| {
            PMultigrid::new(
                Arc::new(stiffness(Basis::Lagrange)),
                blocks.clone(),
                p1.solver.clone(),
                transfer.clone(),
                degree,
                &mut Workspace::new(),
            )
        };
        let along_lines = plan.smooths_along_lines().then(|| {
            let inner = Arc::new(cycle(plan.smoother_degree));
            let operator = Arc::new(stiffness(Basis::Hierarchical));
            lines_around(
                body,
                plan.units.coordinate_scale,
                operator,
                transfer.clone(),
                inner,
            )
        });
        let (displacement, smoother_bytes): (Arc<dyn Preconditioner>, u64) =
            match along_lines.flatten() {
                Some(lines) => {
                    let bytes = lines.bytes() + blocks.bytes();
                    (Arc::new(lines), bytes)
                }
                None => {
                    let cycle = cycle(plan.smoother_degree);
                    let bytes = cycle.bytes();
                    (Arc::new(cycle), bytes)
                }
            };
        poll()?;
        let pressure = plan.is_mixed().then(|| {
            pressure_block(
                mesh,
                &space,
                &geometry,
                &moduli,
                &stiffness(Basis::Hierarchical),
            )
        });
        let mut is_held = vec![false; space.displacement_unknowns()];
        held.iter()
            .for_each(|&index| is_held[index as usize] = true);
        let total = start.elapsed().as_secs_f64();
        Ok(Self {
            stiffness: stiffness(Basis::Hierarchical),
            space,
            geometry,
            grid,
            held,
            is_held,
            displacement,
            smoother_bytes,
            node_blocks: blocks,
            pressure,
            compliance: p1.compliance,
            contact_normals: p1.normals,
            p1_bytes: p1.bytes,
            p1_part: p1.part,
            seconds: Seconds {
                prepare: (total - p1.assemble - p1.factorise).max(0.0),
                assemble: p1.assemble,
                factorise: p1.factorise,
                total,
                ..Seconds::default()
            },
        })
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let pressure = self.pressure.as_ref().map_or(0, |block| {
            block.metric.bytes() + block.stabilisation.as_ref().map_or(0, SparseRows::bytes)
        });
        self.geometry.bytes()
            + self.grid.bytes()
            + self.p1_bytes
            + self.smoother_bytes
            + self.node_blocks.bytes()
            + self.compliance.bytes()
            + 24 * self.contact_normals.len() as u64
            + pressure
            + (8 * self.space.edges.len() + 4 * self.held.len() + self.is_held.len()) as u64
    }

    /// Wall seconds that building took; `prepare` is what is not named apart.
    pub fn seconds(&self) -> Seconds {
        self.seconds
    }

    /// Names of the parts, for reports of reuse.
    pub(crate) fn parts(&self) -> Vec<String> {
        let mut parts = vec![
            "numbering",
            "geometry",
            "operator",
            self.p1_part,
            "smoother",
        ];
        if self.pressure.is_some() {
            parts.push("pressure_metric");
        }
        if self.compliance.rows() > 0 {
            parts.push("contact_compliance");
        }
        parts.into_iter().map(str::to_owned).collect()
    }
}

/// `inner` between smoothings along strongly coupled nodes, where there are
/// groups of them.
fn lines_around(
    body: P1Body<'_>,
    scale: f64,
    operator: Arc<Stiffness>,
    transfer: Transfer,
    inner: Arc<PMultigrid>,
) -> Option<AlongLines> {
    let P1Body {
        mesh,
        space,
        geometry,
        moduli,
        held,
    } = body;
    let couplings = node_couplings(mesh, space, geometry, moduli);
    let coordinates: Vec<[f64; 3]> = (0..space.nodes())
        .map(|node| node_position(mesh, space, node).map(|x| x * scale))
        .collect();
    let nodes = NodePairs {
        components: space.components,
        coordinates: &coordinates,
        pairs: &couplings.pairs,
        off: &couplings.off,
        diagonal: &couplings.diagonal,
        held,
    };
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

/// Non-dimensional moduli of each cell.
fn moduli(plan: &Plan) -> CellModuli {
    let mut moduli = CellModuli::default();
    for &index in &plan.resolved.cell_material {
        let law = plan.resolved.materials[usize::from(index)].law;
        let (lame, inverse) = match plan.is_mixed() {
            true => (0.0, law.inverse_lame * plan.units.stress),
            false => (law.lame() / plan.units.stress, 0.0),
        };
        moduli.shear.push(law.shear_modulus / plan.units.stress);
        moduli.lame.push(lame);
        moduli.inverse_lame.push(inverse);
    }
    moduli
}

/// Whether B^T 1 vanishes on free rows.
fn constant_pressure_is_idle(coupling: &Divergence) -> bool {
    let mut work = Workspace::new();
    let ones = vec![1.0; coupling.vertices];
    let (mut free, mut all) = (vec![0.0; coupling.size], vec![0.0; coupling.size]);
    coupling.apply_transposed(&ones, &mut free, &mut work);
    coupling
        .grid
        .divergence_transposed(Rows::All, &ones, &mut all, &mut work);
    norm(&free) <= 1e-12 * norm(&all)
}

fn pressure_block(
    mesh: &Mesh,
    space: &TaylorHood,
    geometry: &CellGeometry,
    moduli: &CellModuli,
    stiffness: &Stiffness,
) -> PressureBlock {
    let is_homogeneous = moduli
        .shear
        .windows(2)
        .all(|pair| pair[0].to_bits() == pair[1].to_bits());
    let softness = match is_homogeneous {
        true => Vec::new(),
        false => softness(mesh, space, geometry, moduli),
    };
    let schur = |cell: usize| match is_homogeneous {
        true => 0.5 / moduli.shear[cell] + moduli.inverse_lame[cell],
        false => 0.5 * softness[cell] + moduli.inverse_lame[cell],
    };
    let compressible = moduli.inverse_lame.iter().any(|&inverse| inverse != 0.0);
    let coupling = Divergence {
        grid: stiffness.grid.clone(),
        vertices: space.vertices,
        size: stiffness.size,
    };
    let body = Body {
        grid: stiffness.grid.clone(),
        vertices: space.vertices,
        size: stiffness.size,
        held: stiffness.held.clone(),
    };
    PressureBlock {
        body,
        is_enclosed: !compressible && constant_pressure_is_idle(&coupling),
        coupling,
        stabilisation: compressible
            .then(|| weighted_mass(mesh, geometry, |cell| moduli.inverse_lame[cell])),
        metric: ChebyshevMass::new(
            weighted_mass(mesh, geometry, schur),
            space.components,
            MASS_STEPS,
        ),
    }
}
