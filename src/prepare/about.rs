//! The approximate inverse about a deformed state, made anew by the session whose
//! programs have become dear. Cost: a P1 solver and its compliance.

use super::TaylorHoodData;
use super::approximate_inverse::ApproximateInverse;
use super::bodies::{DisplacementBody, P1Body};
use super::deformed::Deformed;
use super::error::PrepareError;
use super::moduli::moduli;
use super::{displacement, p1};
use crate::assembly::p1_stiffness::StiffCells;
use crate::assembly::strain::{CellLaws, CellStates, CellTangents, Linearised};
use crate::linalg::{FactoriseError, Workspace};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::plan::augmentation::VOLUMETRIC;
use crate::precond::NodeBlocks;
use crate::precond::node_blocks::are_positive;
use crate::report::CancelToken;
use std::sync::Arc;

impl TaylorHoodData {
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
    ) -> Result<ApproximateInverse, PrepareError> {
        let found = self.with_pressure(plan, mesh, state, cancel);
        if found.is_ok() || cancel.stopped().is_some() {
            found
        } else {
            self.about_without_pressure(plan, mesh, state, cancel)
        }
    }

    /// The approximation about a deformed state without the pressure's part of the
    /// tangent, which says nothing of a body whose faces are held by contact.
    ///
    /// # Errors
    /// [`PrepareError`]: the tangent may have no factor at all.
    pub(crate) fn about_without_pressure(
        &self,
        plan: &Plan,
        mesh: &Mesh,
        state: Deformed<'_>,
        cancel: &CancelToken,
    ) -> Result<ApproximateInverse, PrepareError> {
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
    ) -> Result<ApproximateInverse, PrepareError> {
        let laws = plan.laws();
        let states = CellStates {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            laws: CellLaws {
                laws: &laws,
                of_cell: &plan.problem.resolved.cell_material,
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
        let cells = StiffCells {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            stiffness: &tangents,
        };
        let node_blocks = self.node_blocks(&cells)?;
        let p1 = p1::build(plan, body, cancel)?;
        let body = DisplacementBody {
            mesh,
            space: &self.space,
            geometry: &self.geometry,
            moduli: &moduli(plan),
            held: &self.held,
            grid: &self.grid,
            node_blocks: &node_blocks,
            p1: p1.solver.clone(),
            tangent: Some(state),
            tangents: Some(&tangents),
        };
        let displacement = displacement::build(plan, &body);
        Ok(ApproximateInverse {
            displacement: displacement.preconditioner,
            p1: p1.solver,
            node_blocks: displacement.nodes.unwrap_or(node_blocks),
            compliance: p1.compliance,
            traces: p1.traces,
            solver_bytes: p1.bytes + displacement.bytes,
            p1_part: p1.part,
        })
    }

    /// Inverted node blocks.
    ///
    /// # Errors
    /// Where one is not positive definite.
    fn node_blocks(&self, cells: &StiffCells<'_>) -> Result<NodeBlocks, FactoriseError> {
        let c = self.space.components;
        let blocks = cells.node_blocks(&self.held);
        if are_positive(c, &blocks) {
            Ok(NodeBlocks::invert(c, blocks))
        } else {
            Err(FactoriseError::NotPositiveDefinite)
        }
    }
}
