//! The solver of the P1 block: which one, why, and building it.
//!
//! Multigrid needs time and bytes in proportion to the vertices, a factor grows
//! faster but bears any contrast of stiffness and gives the contact compliance
//! on the way. The choice rests on sizes alone; a cycle that turns out weak is
//! replaced by the factor.

use std::sync::Arc;
use std::time::Instant;

use super::saddle::Demand;
use super::{Plan, PrepareError, estimate};
use crate::assembly::CellGeometry;
use crate::assembly::p1_stiffness::{CellStiffness, P1Blocks, p1_blocks};
use crate::contact::surface::vertex_normals;
use crate::linalg::cholesky::Precision;
use crate::linalg::{DenseMatrix, FactoriseError, Preconditioner};
use crate::mesh::Mesh;
use crate::precond::p1::{
    AmgError, AmgP1, DirectP1, Traces, VertexBlocks, incomplete_cholesky_cg, vertex_order,
};
use crate::report::{CancelToken, Termination};
use crate::space::TaylorHood;

/// Flops below which the factor takes less time than the multigrid saves.
const CHEAP_FACTOR: f64 = 1e9;
/// Bytes of the largest factor. Contact is worth any factor that fits: columns
/// of the compliance by multigrid take three to four times as long (hertz-sphere
/// l5, l6).
const LARGEST_FACTOR: f64 = 4e9;
/// Flops of a factor that contrast or poor cells are worth.
const DEAREST_FACTOR: f64 = 4e11;
/// Ratio of shear moduli up to which multigrid was seen to keep its counts, in
/// layers and in a ball across the mesh, stiff and soft.
const MODEST_CONTRAST: f64 = 1e6;
/// Mean quality of cells below which multigrid needs several times the steps.
const POOR_CELLS: f64 = 0.4;
/// Shift of A11 for floating bodies, in mu / L^2.
const SHIFT: f64 = 1e-2;

/// Solvers of the P1 block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum P1Solver {
    /// Sparse Cholesky factor.
    Direct,
    /// Smoothed-aggregation multigrid.
    Amg,
    /// Conjugate gradients around an incomplete factor.
    IcCg,
}

impl P1Solver {
    /// The name in plans.
    pub(super) fn describe(self) -> &'static str {
        match self {
            Self::Direct => "sparse Cholesky",
            Self::Amg => "smoothed-aggregation multigrid, single precision",
            Self::IcCg => "incomplete Cholesky, conjugate gradients to a tolerance",
        }
    }

    /// The name of its data in reports of reuse.
    fn part(self) -> &'static str {
        match self {
            Self::Direct => "p1_factor",
            Self::Amg => "p1_multigrid",
            Self::IcCg => "p1_incomplete_factor",
        }
    }

    /// What it asks of the outer method.
    pub(super) fn demand(self) -> Demand {
        match self {
            Self::Direct | Self::Amg => Demand::None,
            Self::IcCg => Demand::Flexible,
        }
    }
}

/// A choice with its reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct P1Choice {
    pub(super) solver: P1Solver,
    pub(super) reason: String,
}

impl P1Choice {
    fn new(solver: P1Solver, reason: impl Into<String>) -> Self {
        Self {
            solver,
            reason: reason.into(),
        }
    }
}

/// What the choice rests on.
#[derive(Clone, Copy, Debug)]
pub(super) struct P1Sizes {
    /// 2 or 3.
    pub(super) dimension: usize,
    /// Vertices of the mesh.
    pub(super) vertices: u64,
    /// Vertices of candidate faces.
    pub(super) contact_vertices: usize,
    /// Largest over smallest shear modulus.
    pub(super) contrast: f64,
    /// Mean quality of the cells, 1 for regular ones.
    pub(super) quality: f64,
}

/// Chooses; `asked` is the scene's `solver.p1_solver`.
pub(super) fn choose(asked: &str, sizes: P1Sizes) -> P1Choice {
    let (entries, flops) = estimate::factor(sizes.dimension, sizes.vertices);
    let cost = format!(
        "the factor takes {:.1} Gflop and {:.0} MB",
        1e-9 * flops,
        8e-6 * entries
    );
    let fits = 8.0 * entries <= LARGEST_FACTOR;
    let is_affordable = fits && flops <= DEAREST_FACTOR;
    match asked {
        "cholesky" => return P1Choice::new(P1Solver::Direct, "asked for"),
        "amg" => return P1Choice::new(P1Solver::Amg, "asked for"),
        "ic-cg" => return P1Choice::new(P1Solver::IcCg, "asked for"),
        _ => (),
    }
    if flops <= CHEAP_FACTOR {
        P1Choice::new(P1Solver::Direct, format!("small: {cost}"))
    } else if fits && sizes.contact_vertices > 0 {
        let reason = format!("the factor also gives the contact compliance; {cost}");
        P1Choice::new(P1Solver::Direct, reason)
    } else if !is_affordable {
        P1Choice::new(P1Solver::Amg, format!("large: {cost}"))
    } else if sizes.contrast > MODEST_CONTRAST {
        let reason = format!("shear moduli differ {:.0e} times; {cost}", sizes.contrast);
        P1Choice::new(P1Solver::Direct, reason)
    } else if sizes.quality < POOR_CELLS {
        let reason = format!("stretched cells, mean quality {:.2}; {cost}", sizes.quality);
        P1Choice::new(P1Solver::Direct, reason)
    } else {
        let reason = format!("{} vertices: {cost}", sizes.vertices);
        P1Choice::new(P1Solver::Amg, reason)
    }
}

/// A solver of the P1 block and what came with it.
pub(super) struct P1Built {
    pub(super) solver: Arc<dyn Preconditioner>,
    /// A11^-1 on the contact vertices along `normals`; empty without contact.
    pub(super) compliance: DenseMatrix,
    /// Directions of `compliance`.
    pub(super) normals: Vec<[f64; 3]>,
    /// Bytes of the solver.
    pub(super) bytes: u64,
    /// Name of the data.
    pub(super) part: &'static str,
    /// Wall seconds of assembly.
    pub(super) assemble: f64,
    /// Wall seconds of everything else.
    pub(super) factorise: f64,
}

/// Mesh and material of A11.
#[derive(Clone, Copy)]
pub(super) struct P1Body<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) space: &'a TaylorHood,
    pub(super) geometry: &'a CellGeometry,
    pub(super) stiffness: &'a dyn CellStiffness,
    pub(super) held: &'a [u32],
    /// Hierarchical displacement of the surface; empty at rest.
    pub(super) moved: &'a [f64],
}

/// Assembles A11 and builds the solver that `plan` chose, or the factor where
/// multigrid does not serve.
pub(super) fn build(
    plan: &Plan,
    body: P1Body<'_>,
    cancel: &CancelToken,
) -> Result<P1Built, PrepareError> {
    let start = Instant::now();
    let shift = if plan.is_floating() { SHIFT } else { 0.0 };
    let blocks = p1_blocks(body.mesh, body.space, body.geometry, body.stiffness, shift);
    let assemble = start.elapsed().as_secs_f64();
    let normals = contact_normals(plan, body);
    let traces = Traces {
        vertices: &plan.contact_vertices,
        directions: &normals,
    };
    let mut built = match plan.p1.solver {
        P1Solver::Direct => direct(plan, body, &blocks, &traces)?,
        P1Solver::Amg => match hierarchy(body, &blocks) {
            Ok(cycle) => multigrid(cycle, &traces, cancel)?,
            Err(_) => direct(plan, body, &blocks, &traces)?,
        },
        P1Solver::IcCg => incomplete(body, &blocks),
    };
    built.normals = normals;
    built.assemble = assemble;
    built.factorise = start.elapsed().as_secs_f64() - assemble;
    Ok(built)
}

/// Normals of the candidate surface, zero in held components.
fn contact_normals(plan: &Plan, body: P1Body<'_>) -> Vec<[f64; 3]> {
    let facets = plan.resolved.obstacle_facets.iter().flatten();
    let scale = plan.units.coordinate_scale;
    let c = body.space.components;
    let position = |vertex: u32| {
        let mut at = body.mesh.coordinates()[vertex as usize].map(|x| scale * x);
        let moved = body
            .moved
            .get(vertex as usize * c..(vertex as usize + 1) * c);
        for (x, by) in at.iter_mut().zip(moved.unwrap_or_default()) {
            *x += by;
        }
        at
    };
    let mut normals = vertex_normals(
        position,
        facets.map(|&facet| body.mesh.facet(facet as usize)),
        &plan.contact_vertices,
    );
    let c = c as u32;
    for (normal, &vertex) in normals.iter_mut().zip(&plan.contact_vertices) {
        for (component, unknown) in normal.iter_mut().zip(vertex * c..(vertex + 1) * c) {
            if body.held.binary_search(&unknown).is_ok() {
                *component = 0.0;
            }
        }
    }
    normals
}

fn direct(
    plan: &Plan,
    body: P1Body<'_>,
    blocks: &P1Blocks,
    traces: &Traces<'_>,
) -> Result<P1Built, FactoriseError> {
    let c = body.space.components;
    let matrix = blocks.lower_columns(body.space, body.held);
    let order = vertex_order(
        body.mesh.coordinates(),
        &body.space.edges,
        &plan.contact_vertices,
    );
    let factorise = |precision| DirectP1::new(&matrix, &order, c, precision);
    let factor = match plan.factor_precision().0 {
        // Rounding may cost a small pivot its sign.
        Precision::Single => {
            factorise(Precision::Single).or_else(|_| factorise(Precision::Double))?
        }
        Precision::Double => factorise(Precision::Double)?,
    };
    Ok(P1Built {
        compliance: factor.compliance(traces, c),
        normals: Vec::new(),
        bytes: factor.bytes(),
        solver: Arc::new(factor),
        part: P1Solver::Direct.part(),
        assemble: 0.0,
        factorise: 0.0,
    })
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

/// Scenes with contact are refused it: it gives no compliance.
fn incomplete(body: P1Body<'_>, blocks: &P1Blocks) -> P1Built {
    let (solver, bytes) = incomplete_cholesky_cg(&vertex_blocks(body, blocks));
    P1Built {
        compliance: DenseMatrix::zeros(0, 0),
        normals: Vec::new(),
        bytes,
        solver,
        part: P1Solver::IcCg.part(),
        assemble: 0.0,
        factorise: 0.0,
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
    Ok(P1Built {
        compliance,
        normals: Vec::new(),
        bytes: cycle.bytes(),
        solver: Arc::new(cycle),
        part: P1Solver::Amg.part(),
        assemble: 0.0,
        factorise: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A well-shaped homogeneous body without contact.
    fn body(vertices: u64) -> P1Sizes {
        P1Sizes {
            dimension: 3,
            vertices,
            contact_vertices: 0,
            contrast: 1.0,
            quality: 0.7,
        }
    }

    #[test]
    fn the_scene_has_the_last_word() {
        for (asked, solver) in [
            ("cholesky", P1Solver::Direct),
            ("amg", P1Solver::Amg),
            ("ic-cg", P1Solver::IcCg),
        ] {
            assert_eq!(choose(asked, body(100)).solver, solver);
            assert_eq!(choose(asked, body(1_000_000)).solver, solver);
        }
    }

    #[test]
    fn multigrid_takes_over_where_the_factor_is_dear() {
        assert_eq!(choose("auto", body(1331)).solver, P1Solver::Direct);
        assert_eq!(choose("auto", body(4913)).solver, P1Solver::Amg);
        let plane = P1Sizes {
            dimension: 2,
            ..body(20_000)
        };
        assert_eq!(choose("auto", plane).solver, P1Solver::Direct);
    }

    #[test]
    fn contact_contrast_and_poor_cells_keep_the_factor_while_it_fits() {
        let hard = |vertices| {
            [
                P1Sizes {
                    contact_vertices: 500,
                    ..body(vertices)
                },
                P1Sizes {
                    contrast: 1e9,
                    ..body(vertices)
                },
                P1Sizes {
                    quality: 0.2,
                    ..body(vertices)
                },
            ]
        };
        for (sizes, word) in hard(20_000)
            .into_iter()
            .zip(["contact", "moduli", "quality"])
        {
            let choice = choose("auto", sizes);
            assert_eq!(choice.solver, P1Solver::Direct);
            assert!(choice.reason.contains(word), "{}", choice.reason);
        }
        for sizes in hard(200_000) {
            assert_eq!(choose("auto", sizes).solver, P1Solver::Amg);
        }
    }
}
