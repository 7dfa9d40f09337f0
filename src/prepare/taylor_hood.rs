//! Everything that depends on mesh, supports, material and candidate surface
//! only: immutable, shared by all sessions with the same [`crate::plan::PreparedKey`].

use std::sync::Arc;
use std::time::Instant;

use super::approximate_inverse::ApproximateInverse;
use super::bodies::{DisplacementBody, P1Body};
use super::displacement;
use super::error::PrepareError;
use super::moduli::moduli;
use super::of_sessions::OfSessions;
use super::p1::{self, P1Built};
use super::pressure::{PressureBlock, PressureBody, pressure_block, stabilisation};
use super::rings::{Rest, rings_at_rest};
use crate::assembly::grid::{Basis, GridSource};
use crate::assembly::p1_stiffness::{CellStiffness, StiffCells};
use crate::assembly::strain::{CellLaws, StrainGrid};
use crate::assembly::{CellGeometry, CellModuli, Constrained, Grid, Stiffness};
use crate::element::quadrature::{Simplex, rule};
use crate::linalg::{Held, SparseRows};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::NodeBlocks;
use crate::report::{CancelToken, Seconds};
use crate::space::TaylorHood;

/// Prepared data of a Taylor-Hood body.
pub(crate) struct TaylorHoodData {
    pub(crate) space: TaylorHood,
    pub(crate) geometry: CellGeometry,
    pub(crate) grid: Arc<Grid>,
    pub(crate) held: Held,
    pub(crate) is_held: Vec<bool>,
    pub(crate) stiffness: Constrained<Stiffness>,
    /// The approximate inverse at rest.
    pub(crate) at_rest: Arc<ApproximateInverse>,
    pub(crate) pressure: Option<PressureBlock>,
    /// Cells of finite strain; none for linear bodies.
    pub(crate) strain: Option<Arc<StrainGrid>>,
    /// What sessions have made of these data and share.
    pub(crate) of_sessions: OfSessions,
    seconds: Seconds,
}

impl std::fmt::Debug for TaylorHoodData {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("TaylorHoodData")
            .field("unknowns", &self.space.displacement_unknowns())
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl TaylorHoodData {
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
        let poll = || match cancel.stopped() {
            Some(stopped) => Err(PrepareError::Stopped(stopped)),
            None => Ok(()),
        };
        let space = TaylorHood::new(mesh);
        let (geometry, moduli) = (geometry_of(plan, mesh), moduli(plan));
        let held = held_of(plan, space.components);
        poll()?;
        let is_turned = plan.is_axisymmetric();
        let rings = is_turned.then(|| rings_at_rest(plan, mesh, &space, &geometry));
        let rings = rings.as_ref().map(|rings| rings as &dyn CellStiffness);
        let cells = rings.unwrap_or(&moduli);
        let body = P1Body {
            mesh,
            space: &space,
            geometry: &geometry,
            stiffness: cells,
            held: &held,
            moved: &[],
        };
        let (p1, (grid, node_blocks)) = rayon::join(
            || p1::build(plan, body, cancel),
            || {
                let source = GridSource {
                    mesh,
                    space: &space,
                    geometry: &geometry,
                    moduli: &moduli,
                    held: &held,
                };
                let cells = StiffCells {
                    mesh,
                    space: &space,
                    geometry: &geometry,
                    stiffness: cells,
                };
                grid_and_blocks(source, &cells)
            },
        );
        let p1 = p1?;
        poll()?;
        Parts {
            start,
            space,
            geometry,
            moduli,
            held,
            grid,
            node_blocks,
            p1,
        }
        .finish(plan, mesh, &poll)
    }

    /// The same body with the laws of `plan`, in the same units: operators without their inverses
    /// and metrics, which stay those of these data.
    pub(crate) fn with_laws(&self, plan: &Plan, mesh: &Mesh) -> Self {
        let moduli = moduli(plan);
        let (space, geometry) = (self.space.clone(), self.geometry.clone());
        let source = GridSource {
            mesh,
            space: &space,
            geometry: &geometry,
            moduli: &moduli,
            held: &self.held,
        };
        // Of cells of finite strain the grid holds shapes alone.
        let grid = match &self.strain {
            Some(_) => self.grid.clone(),
            None => Arc::new(Grid::new(source)),
        };
        let mut stiffness = self.stiffness.clone();
        stiffness.free.grid = grid.clone();
        let pressure = self.pressure.as_ref();
        let strain = self.strain.as_ref();
        Self {
            pressure: pressure.map(|block| PressureBlock {
                stabilisation: stabilisation(plan, (mesh, &geometry), &moduli),
                ..block.clone()
            }),
            strain: strain.map(|_| Arc::new(strain_grid(plan, mesh, &grid))),
            held: self.held.clone(),
            is_held: self.is_held.clone(),
            at_rest: self.at_rest.clone(),
            of_sessions: OfSessions::default(),
            seconds: Seconds::default(),
            space,
            geometry,
            grid,
            stiffness,
        }
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
            + (8 * self.space.edges.len() + 4 * self.held.entries.len() + self.is_held.len()) as u64
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

/// The cells with their laws, non-dimensional.
fn strain_grid(plan: &Plan, mesh: &Mesh, grid: &Arc<Grid>) -> StrainGrid {
    let laws = plan.laws_at_rest();
    let cells = CellLaws {
        laws: &laws,
        of_cell: &plan.problem.resolved.cell_material,
    };
    let simplex = match plan.problem.units.dimension {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let rule = rule(simplex, plan.strain_degree());
    StrainGrid::new(mesh, grid.clone(), cells, rule)
}

fn geometry_of(plan: &Plan, mesh: &Mesh) -> CellGeometry {
    let scale = plan.problem.units.coordinate_scale;
    if plan.is_axisymmetric() {
        CellGeometry::about_axis(mesh, scale)
    } else {
        CellGeometry::new(mesh, scale)
    }
}

/// What supports hold.
fn held_of(plan: &Plan, components: usize) -> Held {
    Held {
        components,
        entries: plan
            .problem
            .held
            .iter()
            .map(|&(unknown, _)| unknown)
            .collect(),
        nodes: plan.problem.held_nodes.iter().map(|one| one.held).collect(),
    }
}

/// The operator and the inverted blocks of its nodes.
fn grid_and_blocks(source: GridSource<'_>, cells: &StiffCells<'_>) -> (Arc<Grid>, NodeBlocks) {
    let (components, held) = (source.space.components, source.held);
    let blocks = cells.node_blocks(held);
    (
        Arc::new(Grid::new(source)),
        NodeBlocks::invert(components, blocks),
    )
}

/// What is there once the P1 solver and the grid are built.
struct Parts {
    /// When building began.
    start: Instant,
    space: TaylorHood,
    geometry: CellGeometry,
    moduli: CellModuli,
    held: Held,
    grid: Arc<Grid>,
    node_blocks: NodeBlocks,
    p1: P1Built,
}

impl Parts {
    /// Adds the preconditioner of the displacement block and the pressure block.
    fn finish(
        self,
        plan: &Plan,
        mesh: &Mesh,
        poll: &dyn Fn() -> Result<(), PrepareError>,
    ) -> Result<TaylorHoodData, PrepareError> {
        let is_rubber = plan.problem.resolved.is_rubber();
        let is_turned = plan.is_axisymmetric();
        let cells = (is_rubber || is_turned).then(|| Arc::new(strain_grid(plan, mesh, &self.grid)));
        let turned = cells.as_ref().filter(|_| is_turned);
        let rest = turned.map(|cells| Rest::new(cells.clone(), &self.space));
        let strain = cells.filter(|_| is_rubber);
        let body = DisplacementBody {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            moduli: &self.moduli,
            held: &self.held,
            grid: &self.grid,
            node_blocks: &self.node_blocks,
            p1: self.p1.solver.clone(),
            tangent: rest.as_ref().map(Rest::state),
            tangents: None,
        };
        let stiffness = body.stiffness(Basis::Hierarchical);
        let displacement = displacement::build(plan, &body);
        poll()?;
        let body = PressureBody {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            moduli: &self.moduli,
            stiffness: &stiffness,
        };
        let mut pressure = plan.is_mixed().then(|| pressure_block(plan, body));
        if let (Some(block), Some(rest)) = (&mut pressure, &rest) {
            block.is_enclosed = block.stabilisation.is_none() && rest.is_enclosed(&self.held);
        }
        Ok(TaylorHoodData {
            seconds: self.seconds(),
            strain,
            of_sessions: OfSessions::default(),
            stiffness,
            is_held: self.is_held(),
            pressure,
            at_rest: Arc::new(ApproximateInverse {
                displacement: displacement.preconditioner,
                p1: self.p1.solver,
                node_blocks: displacement.nodes.unwrap_or(self.node_blocks),
                compliance: self.p1.compliance,
                traces: self.p1.traces,
                solver_bytes: self.p1.bytes + displacement.bytes,
                p1_part: self.p1.part,
            }),
            space: self.space,
            geometry: self.geometry,
            grid: self.grid,
            held: self.held,
        })
    }

    /// Whether supports hold each unknown `[displacement unknowns]`.
    fn is_held(&self) -> Vec<bool> {
        let mut is_held = vec![false; self.space.displacement_unknowns()];
        let held = self.held.entries.iter();
        held.for_each(|&index| is_held[index as usize] = true);
        is_held
    }

    fn seconds(&self) -> Seconds {
        let total = self.start.elapsed().as_secs_f64();
        Seconds {
            prepare: (total - self.p1.assemble - self.p1.factorise).max(0.0),
            assemble: self.p1.assemble,
            factorise: self.p1.factorise,
            total,
            ..Seconds::default()
        }
    }
}
