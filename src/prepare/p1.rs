//! Building the solver of the P1 block A11 that a plan chose, with the compliance of
//! the contact vertices that comes with it:
//!
//! ```text
//! A11 = P^T A P (+ shift M where rigid modes are free),   N^T A11^-1 N on contact vertices
//! ```
//!
//! Non-dimensional. Cost: that of the factor or of the multigrid hierarchy with its columns; a cycle
//! that turns out weak is replaced by the factor.

use std::sync::Arc;
use std::time::Instant;

use super::bodies::P1Body;
use super::error::PrepareError;
use super::traces::TraceDirections;
use crate::assembly::p1_stiffness::project_couplings;
use crate::assembly::p1_stiffness::{P1Blocks, StiffCells};
use crate::comparisons::Comparisons;
use crate::linalg::cholesky::Precision;
use crate::linalg::{DenseMatrix, FactoriseError, Preconditioner};
use crate::plan::Plan;
use crate::precond::p1::{AmgError, AmgP1, DirectP1, Traces, VertexBlocks, vertex_order};
use crate::report::{CancelToken, Termination};
use crate::scene::P1Solver;

/// Shift of A11 for floating bodies, in mu / L^2.
const SHIFT: f64 = 1e-2;
/// That for bodies which ties hold: turned under the tractions of a tie such a body loses energy, up to
/// some mu, and an inverse that is far above finds no way back. In mu / L^2: 224 applications for 367 with 1e-2, of a
/// bush in tubes 1e5 times as stiff.
const SHIFT_OF_TIED: f64 = 1.0;

/// What resists free rigid modes in inverses of the body; zero where none is free.
pub(super) fn shift(plan: &Plan) -> f64 {
    match (plan.is_floating(), plan.is_shifted()) {
        (true, _) => SHIFT,
        (false, true) => SHIFT_OF_TIED,
        (false, false) => 0.0,
    }
}

/// A solver of the P1 block and what came with it.
pub(crate) struct P1Built {
    pub(crate) solver: Arc<dyn Preconditioner>,
    /// A11^-1 on `traces`; empty without contact.
    pub(crate) compliance: Arc<DenseMatrix>,
    /// Vertices and directions of `compliance`.
    pub(crate) traces: TraceDirections,
    /// Bytes of the solver.
    pub(crate) bytes: u64,
    /// Name of the data.
    pub(crate) part: &'static str,
    /// Wall seconds of assembly.
    pub(crate) assemble: f64,
    /// Wall seconds of everything else.
    pub(crate) factorise: f64,
}

impl P1Built {
    /// Without normals and seconds.
    fn new(
        method: P1Solver,
        solver: Arc<dyn Preconditioner>,
        bytes: u64,
        compliance: DenseMatrix,
    ) -> Self {
        Self {
            solver,
            compliance: Arc::new(compliance),
            traces: TraceDirections::default(),
            bytes,
            part: method.part(),
            assemble: 0.0,
            factorise: 0.0,
        }
    }
}

/// Assembles A11 and builds the solver that `plan` chose, or the factor where
/// multigrid does not serve.
pub(crate) fn build(
    plan: &Plan,
    body: P1Body<'_>,
    cancel: &CancelToken,
) -> Result<P1Built, PrepareError> {
    let start = Instant::now();
    let cells = StiffCells {
        mesh: body.mesh,
        space: body.space,
        geometry: body.geometry,
        stiffness: body.stiffness,
    };
    let mut blocks = cells.p1_blocks(shift(plan));
    let edges = (&body.space.edges[..], &mut blocks.off[..]);
    project_couplings(body.held, &mut blocks.diagonal, edges, 1.0);
    let assemble = start.elapsed().as_secs_f64();
    let directions = TraceDirections::new(plan, body);
    let traces = Traces {
        vertices: &directions.vertices,
        directions: &directions.directions,
    };
    let comparisons = plan.comparisons.as_ref();
    let other = |all: &Arc<dyn Comparisons>| {
        all.p1(plan.decisions.p1.solver, &vertex_blocks(body, &blocks))
    };
    let mut built = match comparisons.and_then(other) {
        // Scenes with contact are refused those: they give no compliance.
        Some((solver, bytes)) => {
            let none = DenseMatrix::zeros(0, 0);
            P1Built::new(plan.decisions.p1.solver, solver, bytes, none)
        }
        None => own(plan, body, (&blocks, &traces), cancel)?,
    };
    built.traces = directions;
    built.assemble = assemble;
    built.factorise = start.elapsed().as_secs_f64() - assemble;
    Ok(built)
}

/// Factor or multigrid, or the factor where multigrid does not serve.
fn own(
    plan: &Plan,
    body: P1Body<'_>,
    (blocks, traces): (&P1Blocks, &Traces<'_>),
    cancel: &CancelToken,
) -> Result<P1Built, PrepareError> {
    if plan.decisions.p1.solver == P1Solver::Amg
        && let Ok(cycle) = hierarchy(body, blocks)
    {
        return multigrid(cycle, traces, cancel);
    }
    Ok(direct(plan, body, blocks, traces)?)
}

fn direct(
    plan: &Plan,
    body: P1Body<'_>,
    blocks: &P1Blocks,
    traces: &Traces<'_>,
) -> Result<P1Built, FactoriseError> {
    let c = body.space.components;
    let matrix = blocks.lower_columns(body.space, &body.held.entries);
    let order = vertex_order(
        body.mesh.coordinates(),
        &body.space.edges,
        &plan.decisions.contact_vertices,
    );
    let factorise = |precision| DirectP1::new(&matrix, &order, c, precision);
    let factor = match plan.factor_precision().0 {
        // Rounding may cost a small pivot its sign.
        Precision::Single => {
            factorise(Precision::Single).or_else(|_| factorise(Precision::Double))?
        }
        Precision::Double => factorise(Precision::Double)?,
    };
    let (compliance, bytes) = (factor.compliance(traces, c), factor.bytes());
    let solver = Arc::new(factor);
    Ok(P1Built::new(P1Solver::Direct, solver, bytes, compliance))
}

fn vertex_blocks<'a>(body: P1Body<'a>, blocks: &'a P1Blocks) -> VertexBlocks<'a> {
    VertexBlocks {
        components: body.space.components,
        coordinates: body.mesh.coordinates(),
        edges: &body.space.edges,
        diagonal: &blocks.diagonal,
        off: &blocks.off,
        held: body.held,
    }
}

/// Multigrid in single precision, or in double where that overshoots.
fn hierarchy(body: P1Body<'_>, blocks: &P1Blocks) -> Result<AmgP1, AmgError> {
    let view = vertex_blocks(body, blocks);
    match AmgP1::new(&view, Precision::Single) {
        Err(AmgError::Indefinite) => AmgP1::new(&view, Precision::Double),
        other => other,
    }
}

fn multigrid(
    cycle: AmgP1,
    traces: &Traces<'_>,
    cancel: &CancelToken,
) -> Result<P1Built, PrepareError> {
    let compliance = cycle
        .compliance(traces, &|| cancel.stopped().is_none())
        .ok_or_else(|| PrepareError::Stopped(cancel.stopped().unwrap_or(Termination::Cancelled)))?;
    let bytes = cycle.bytes();
    let solver = Arc::new(cycle);
    Ok(P1Built::new(P1Solver::Amg, solver, bytes, compliance))
}
