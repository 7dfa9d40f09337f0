//! The pressure block of a mixed body: divergence, volume compliance, and the weighted
//! mass that is the metric of the pressure,
//!
//! ```text
//! B u - S p = 0,   S = M / lambda,   metric = M / (step mu) + S
//! ```
//!
//! Non-dimensional. Cost: two masses.

use super::coarse_pressures::CoarsePressures;
use crate::assembly::grid::Rows;
use crate::assembly::mass::weighted_mass;
use crate::assembly::node_moduli::softness;
use crate::assembly::strain::CURVED_DEGREE;
use crate::assembly::{Body, CellGeometry, CellModuli, Constrained, Divergence, Stiffness};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::linalg::vector::norm;
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::schur::ChebyshevMass;
use crate::scene::validate::parts;
use crate::space::TaylorHood;

/// Chebyshev steps that invert the pressure mass.
const MASS_STEPS: usize = 6;

/// The pressure block.
#[derive(Clone, Debug)]
pub(crate) struct PressureBlock {
    pub(crate) coupling: Divergence,
    /// Displacement and pressure in one product.
    pub(crate) body: Constrained<Body>,
    /// C = M / lambda; none when every material is incompressible.
    pub(crate) stabilisation: Option<SparseRows>,
    pub(crate) metric: ChebyshevMass,
    /// Pressures that the metric of contact knows apart.
    pub(crate) coarse: CoarsePressures,
    /// No free boundary: a constant pressure does no work.
    pub(crate) is_enclosed: bool,
}

impl PressureBlock {
    /// The inverse of M / (`weight` step mu) + S by that many Chebyshev steps, in a body of that
    /// many dimensions.
    pub(crate) fn softened(&self, weight: f64, steps: usize, dimension: usize) -> ChebyshevMass {
        let share = weight.recip();
        let softened = self.metric.mass().scaled_above(share, 0.0);
        let sum = match &self.stabilisation {
            Some(own) => softened.plus_multiple(1.0 - share, own),
            None => softened,
        };
        ChebyshevMass::new(sum, dimension, steps)
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

/// Connected part of each vertex; empty where the body is one.
fn several_parts(mesh: &Mesh) -> Vec<u32> {
    let parts = parts(mesh);
    if parts.iter().any(|&part| part > 0) {
        parts
    } else {
        Vec::new()
    }
}

/// What a pressure acts on.
#[derive(Clone, Copy)]
pub(crate) struct PressureBody<'a> {
    /// Mesh.
    pub(crate) mesh: &'a Mesh,
    /// Numbering of the displacement.
    pub(crate) space: &'a TaylorHood,
    /// Gradients and volumes of the cells.
    pub(crate) geometry: &'a CellGeometry,
    /// Moduli of the cells.
    pub(crate) moduli: &'a CellModuli,
    /// A of the displacement.
    pub(crate) stiffness: &'a Constrained<Stiffness>,
}

/// The block of a linear body.
pub(crate) fn pressure_block(plan: &Plan, body: PressureBody<'_>) -> PressureBlock {
    let PressureBody {
        mesh,
        space,
        geometry,
        moduli,
        stiffness,
    } = body;
    let step = plan.pressure_step();
    let is_homogeneous = moduli
        .shear
        .windows(2)
        .all(|pair| pair[0].to_bits() == pair[1].to_bits());
    let softness = if is_homogeneous {
        Vec::new()
    } else {
        softness(mesh, space, geometry, moduli)
    };
    let schur = |cell: usize| {
        if is_homogeneous {
            1.0 / (step * moduli.shear[cell]) + moduli.inverse_lame[cell]
        } else {
            softness[cell] / step + moduli.inverse_lame[cell]
        }
    };
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
    let cells = (mesh, geometry);
    let rule = volume_rule(plan);
    let stabilisation = stabilisation(plan, cells, moduli);
    PressureBlock {
        body,
        coarse: CoarsePressures::new(mesh, &several_parts(mesh), plan.unknowns().contact),
        is_enclosed: stabilisation.is_none() && constant_pressure_is_idle(&coupling),
        coupling,
        stabilisation,
        metric: ChebyshevMass::new(
            weighted_mass(cells, &rule, schur),
            space.components,
            MASS_STEPS,
        ),
    }
}

/// S; none when every material is incompressible.
pub(super) fn stabilisation(
    plan: &Plan,
    cells: (&Mesh, &CellGeometry),
    moduli: &CellModuli,
) -> Option<SparseRows> {
    let is_compressible = moduli.inverse_lame.iter().any(|&inverse| inverse != 0.0);
    is_compressible
        .then(|| weighted_mass(cells, &volume_rule(plan), |cell| moduli.inverse_lame[cell]))
}

/// The rule of the volumes of cells.
fn volume_rule(plan: &Plan) -> Rule {
    let simplex = match plan.problem.units.dimension {
        2 => Simplex::Triangle,
        _ => Simplex::Tetrahedron,
    };
    let degree = if plan.problem.resolved.is_rubber() {
        plan.strain_degree()
    } else {
        CURVED_DEGREE
    };
    rule(simplex, degree)
}
