//! Everything that depends on mesh, supports, material and candidate surface
//! only: immutable, shared by all sessions with the same [`super::PreparedKey`].

use std::sync::Arc;
use std::time::Instant;

use super::Plan;
use super::approximation::Approximation;
use super::displacement::{self, DisplacementBody};
use super::p1::{self, P1Body};
use super::rings::{Rest, rings_at_rest};
use crate::assembly::grid::{Basis, Rows};
use crate::assembly::mass::weighted_mass;
use crate::assembly::node_moduli::softness;
use crate::assembly::p1_stiffness::{CellStiffness, node_blocks};
use crate::assembly::strain::{CellLaws, StrainGrid};
use crate::assembly::{Body, CellGeometry, CellModuli, Constrained, Divergence, Grid, Stiffness};
use crate::element::quadrature::{Simplex, rule};
use crate::linalg::vector::norm;
use crate::linalg::{FactoriseError, LinearOperator, SparseRows, Workspace};
use crate::mesh::Mesh;
use crate::precond::NodeBlocks;
use crate::precond::schur::ChebyshevMass;
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
    pub(crate) body: Constrained<Body>,
    /// C = M / lambda; none when every material is incompressible.
    pub(crate) stabilisation: Option<SparseRows>,
    pub(crate) metric: ChebyshevMass,
    /// No free boundary: a constant pressure does no work.
    pub(crate) is_enclosed: bool,
}

/// Prepared data.
pub(crate) struct Prepared {
    pub(crate) space: TaylorHood,
    pub(crate) geometry: CellGeometry,
    pub(crate) grid: Arc<Grid>,
    pub(crate) held: Arc<[u32]>,
    pub(crate) is_held: Vec<bool>,
    pub(crate) stiffness: Constrained<Stiffness>,
    /// The approximate inverse at rest.
    pub(crate) at_rest: Arc<Approximation>,
    pub(crate) pressure: Option<PressureBlock>,
    /// Cells of finite strain; none for linear bodies.
    pub(crate) strain: Option<Arc<StrainGrid>>,
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
    pub(crate) fn build(
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
        let geometry = geometry_of(plan, mesh);
        let moduli = moduli(plan);
        let held: Arc<[u32]> = plan.held.iter().map(|&(unknown, _)| unknown).collect();
        poll()?;
        let rings = (plan.is_axisymmetric()).then(|| rings_at_rest(plan, mesh, &space, &geometry));
        let cells: &dyn CellStiffness = match &rings {
            Some(rings) => rings,
            None => &moduli,
        };
        let body = P1Body {
            mesh,
            space: &space,
            geometry: &geometry,
            stiffness: cells,
            held: &held,
            moved: &[],
        };
        let (p1, (grid, blocks)) = rayon::join(
            || p1::build(plan, body, cancel),
            || {
                let grid = Arc::new(Grid::new(mesh, &space, &geometry, &moduli, &held));
                let blocks = node_blocks(mesh, &space, &geometry, cells, &held);
                (grid, NodeBlocks::invert(space.components, blocks))
            },
        );
        let p1 = p1?;
        poll()?;
        let strain = plan
            .resolved
            .is_rubber()
            .then(|| Arc::new(strain_grid(plan, mesh, &grid)));
        let turned = strain.as_ref().filter(|_| plan.is_axisymmetric());
        let rest = turned.map(|cells| Rest::new(cells.clone(), &space));
        let body = DisplacementBody {
            mesh,
            space: &space,
            geometry: &geometry,
            moduli: &moduli,
            held: &held,
            grid: &grid,
            node_blocks: &blocks,
            p1: p1.solver,
            tangent: rest.as_ref().map(Rest::state),
        };
        let stiffness = body.stiffness(Basis::Hierarchical);
        let (displacement, displacement_bytes) = displacement::build(plan, body);
        poll()?;
        let mut pressure = plan
            .is_mixed()
            .then(|| pressure_block(plan, mesh, &space, &geometry, &moduli, &stiffness));
        if let (Some(block), Some(rest)) = (&mut pressure, &rest) {
            block.is_enclosed = block.stabilisation.is_none() && rest.is_enclosed(&held);
        }
        let mut is_held = vec![false; space.displacement_unknowns()];
        held.iter()
            .for_each(|&index| is_held[index as usize] = true);
        let total = start.elapsed().as_secs_f64();
        let seconds = Seconds {
            prepare: (total - p1.assemble - p1.factorise).max(0.0),
            assemble: p1.assemble,
            factorise: p1.factorise,
            total,
            ..Seconds::default()
        };
        Ok(Self {
            strain,
            stiffness,
            space,
            geometry,
            grid,
            held,
            is_held,
            at_rest: Arc::new(Approximation {
                displacement,
                node_blocks: blocks,
                compliance: p1.compliance,
                contact_normals: p1.normals,
                solver_bytes: p1.bytes + displacement_bytes,
                p1_part: p1.part,
            }),
            pressure,
            seconds,
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let pressure = self.pressure.as_ref().map_or(0, |block| {
            block.metric.bytes() + block.stabilisation.as_ref().map_or(0, SparseRows::bytes)
        });
        self.geometry.bytes()
            + self.grid.bytes()
            + self.strain.as_ref().map_or(0, |strain| strain.bytes())
            + self.at_rest.bytes()
            + pressure
            + (8 * self.space.edges.len() + 4 * self.held.len() + self.is_held.len()) as u64
    }

    /// Wall seconds that building took; `prepare` is what is not named apart.
    pub(crate) fn seconds(&self) -> Seconds {
        self.seconds
    }

    /// Names of the parts, for reports of reuse.
    pub(crate) fn parts(&self) -> Vec<String> {
        let mut parts = vec![
            "numbering",
            "geometry",
            "operator",
            self.at_rest.p1_part,
            "smoother",
        ];
        if self.pressure.is_some() {
            parts.push("pressure_metric");
        }
        if self.at_rest.compliance.rows() > 0 {
            parts.push("contact_compliance");
        }
        parts.into_iter().map(str::to_owned).collect()
    }
}

/// Non-dimensional moduli of each cell.
pub(super) fn moduli(plan: &Plan) -> CellModuli {
    let mut moduli = CellModuli::default();
    for &index in &plan.resolved.cell_material {
        let law = plan.resolved.materials[usize::from(index)].law;
        let (lame, inverse) = match plan.is_mixed() {
            // The penalty is a grad-div term of the displacement block.
            true => (
                plan.penalty() * law.shear_modulus / plan.units.stress,
                law.inverse_lame * plan.units.stress,
            ),
            false => (law.lame() / plan.units.stress, 0.0),
        };
        moduli.shear.push(law.shear_modulus / plan.units.stress);
        moduli.lame.push(lame);
        moduli.inverse_lame.push(inverse);
    }
    moduli
}

/// The cells with their laws, non-dimensional.
fn strain_grid(plan: &Plan, mesh: &Mesh, grid: &Arc<Grid>) -> StrainGrid {
    let laws = plan.laws();
    let cells = CellLaws {
        laws: &laws,
        of_cell: &plan.resolved.cell_material,
    };
    let simplex = match plan.units.dimension {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let rule = rule(simplex, plan.strain_degree());
    let cells = StrainGrid::new(mesh, grid.clone(), cells, rule);
    match plan.is_axisymmetric() {
        true => cells.about_axis(mesh, plan.units.coordinate_scale),
        false => cells,
    }
}

fn geometry_of(plan: &Plan, mesh: &Mesh) -> CellGeometry {
    let scale = plan.units.coordinate_scale;
    match plan.is_axisymmetric() {
        true => CellGeometry::about_axis(mesh, scale),
        false => CellGeometry::new(mesh, scale),
    }
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
    plan: &Plan,
    mesh: &Mesh,
    space: &TaylorHood,
    geometry: &CellGeometry,
    moduli: &CellModuli,
    stiffness: &Constrained<Stiffness>,
) -> PressureBlock {
    let step = plan.displacement.pressure_step() + plan.penalty();
    let is_homogeneous = moduli
        .shear
        .windows(2)
        .all(|pair| pair[0].to_bits() == pair[1].to_bits());
    let softness = match is_homogeneous {
        true => Vec::new(),
        false => softness(mesh, space, geometry, moduli),
    };
    let schur = |cell: usize| match is_homogeneous {
        true => 1.0 / (step * moduli.shear[cell]) + moduli.inverse_lame[cell],
        false => softness[cell] / step + moduli.inverse_lame[cell],
    };
    let compressible = moduli.inverse_lame.iter().any(|&inverse| inverse != 0.0);
    let Stiffness { grid, size, .. } = &stiffness.free;
    let coupling = Divergence {
        grid: grid.clone(),
        vertices: space.vertices,
        size: *size,
    };
    let body = Constrained {
        free: Body {
            grid: grid.clone(),
            vertices: space.vertices,
            size: *size,
        },
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
