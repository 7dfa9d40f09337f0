//! An approximate inverse of the displacement block about one state: at rest, made
//! with the prepared data and shared; about a deformed state, made by the session
//! that needs it.
//!
//! ```text
//! A^ ~ (A + 2/3 mu int (cof F : grad u)(cof F : grad v))^-1
//! ```
//!
//! The isochoric tangent has no volume stiffness of its own, and node blocks do not
//! smooth what nothing resists. With the second term A at rest is int 2 mu eps : eps,
//! that of linear elasticity; the pressure makes up for the difference.

use std::sync::Arc;

use super::Plan;
use super::displacement::{self, DisplacementBody};
use super::p1::{self, P1Body};
use super::prepared::{PrepareError, Prepared, moduli};
use crate::assembly::p1_stiffness::node_blocks;
use crate::assembly::strain::{CellLaws, CellStates, CellTangents, Linearised, StrainGrid};
use crate::linalg::{DenseMatrix, Preconditioner, Workspace};
use crate::mesh::Mesh;
use crate::precond::NodeBlocks;
use crate::report::CancelToken;

/// Weight of the volume term, in units of the shear modulus.
pub(crate) const VOLUMETRIC: f64 = 2.0 / 3.0;

/// The parts that belong together.
pub(crate) struct Approximation {
    pub(crate) displacement: Arc<dyn Preconditioner>,
    pub(crate) node_blocks: NodeBlocks,
    /// A11^-1 on the contact vertices along `contact_normals`; empty without contact.
    pub(crate) compliance: DenseMatrix,
    pub(crate) contact_normals: Vec<[f64; 3]>,
    /// Of the P1 solver and the displacement preconditioner.
    pub(super) solver_bytes: u64,
    /// Name of the P1 solver's data.
    pub(super) p1_part: &'static str,
}

impl std::fmt::Debug for Approximation {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Approximation")
            .field("bytes", &self.bytes())
            .finish_non_exhaustive()
    }
}

impl Approximation {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.solver_bytes
            + self.node_blocks.bytes()
            + self.compliance.bytes()
            + 24 * self.contact_normals.len() as u64
    }
}

/// A deformed state with its cells.
#[derive(Clone, Copy)]
pub(crate) struct Deformed<'a> {
    pub(crate) cells: &'a Arc<StrainGrid>,
    pub(crate) at: &'a Arc<Linearised>,
    pub(crate) displacement: &'a [f64],
    pub(crate) pressure: &'a [f64],
}

impl Prepared {
    /// The approximation about a deformed state; without the pressure's part of the
    /// tangent where that has no factor with it: free of what holds it in contact, a
    /// surface under pressure may be unstable.
    ///
    /// # Errors
    /// [`PrepareError`]: the tangent may have no factor at all.
    pub(crate) fn about(
        &self,
        plan: &Plan,
        mesh: &Mesh,
        state: Deformed<'_>,
        cancel: &CancelToken,
    ) -> Result<Approximation, PrepareError> {
        let found = self.with_pressure(plan, mesh, state, cancel);
        if found.is_ok() || cancel.stopped().is_some() {
            return found;
        }
        let pressure = vec![0.0; state.pressure.len()];
        let mut at = Linearised::default();
        let fields = (state.displacement, &pressure[..]);
        state
            .cells
            .linearise(fields, &mut at, &mut Workspace::new());
        let without = Deformed {
            at: &Arc::new(at),
            pressure: &pressure,
            ..state
        };
        self.with_pressure(plan, mesh, without, cancel)
    }

    fn with_pressure(
        &self,
        plan: &Plan,
        mesh: &Mesh,
        state: Deformed<'_>,
        cancel: &CancelToken,
    ) -> Result<Approximation, PrepareError> {
        let laws = plan.laws();
        let states = CellStates {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            laws: CellLaws {
                laws: &laws,
                of_cell: &plan.resolved.cell_material,
            },
            displacement: state.displacement,
            pressure: state.pressure,
        };
        let weight = VOLUMETRIC + state.cells.penalty();
        let tangents = CellTangents::new(&states, weight);
        let body = P1Body {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            stiffness: &tangents,
            held: &self.held,
            moved: state.displacement,
        };
        let p1 = p1::build(plan, body, cancel)?;
        let blocks = node_blocks(mesh, &self.space, &self.geometry, &tangents, &self.held);
        let node_blocks = NodeBlocks::invert(self.space.components, blocks);
        let moduli = moduli(plan);
        let body = DisplacementBody {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            moduli: &moduli,
            held: &self.held,
            grid: &self.grid,
            node_blocks: &node_blocks,
            p1: p1.solver.clone(),
            tangent: Some(state),
        };
        let (displacement, displacement_bytes) = displacement::build(plan, body);
        Ok(Approximation {
            displacement,
            node_blocks,
            compliance: p1.compliance,
            contact_normals: p1.normals,
            solver_bytes: p1.bytes + displacement_bytes,
            p1_part: p1.part,
        })
    }
}
