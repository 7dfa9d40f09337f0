//! Contact of a comparison element whose trace is P1: cell bubbles vanish on the
//! surface, so that gaps, resultants and multipliers are those of Taylor-Hood
//! with edge corrections of zero.

use std::collections::BTreeMap;

use crate::compare::element::body::EnrichedBody;
use crate::contact::gap::{Deformed, Measure, linearise};
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{LinearOperator, SparseRows, Workspace};
use crate::model::evaluate::Evaluation;
use crate::model::joined::Joined;
use crate::model::state::State;
use crate::precond::NodeBlocks;
use crate::precond::compliance::{Compliance, ComplianceParts, OF_MIXED};
use crate::precond::p1::Traces;
use crate::report::{FieldName, ObstacleResult};
use crate::results::touching::Touching;

impl EnrichedBody {
    /// P1 values with edge corrections of zero.
    fn trace(&self, state: &State) -> Vec<f64> {
        let mut trace = vec![0.0; self.data.trace.displacement_unknowns()];
        let first = self.data.space.p1_unknowns();
        trace[..first].copy_from_slice(&state.displacement[..first]);
        trace
    }

    /// The body as contact integrals read it: the P1 trace of the displacement, whose
    /// edge corrections are zero.
    fn deformed<'b>(&'b self, trace: &'b [f64]) -> Deformed<'b> {
        Deformed {
            mesh: &self.mesh,
            scale: self.plan.units.coordinate_scale,
            space: &self.data.trace,
            displacement: trace,
            rule: &self.interfaces.rule,
            measure: Measure::Undeformed,
        }
    }

    /// Gaps and their coupling on the columns that `is_held` leaves; sets the gap
    /// of `out`.
    fn linearise(&self, state: &State, held: &[u32], out: &mut Evaluation) {
        let trace = self.trace(state);
        let body = self.deformed(&trace);
        let mut is_held = vec![true; trace.len()];
        is_held[..self.data.space.p1_unknowns()].fill(false);
        held.iter().for_each(|&k| is_held[k as usize] = true);
        let mut joined = Joined::new(state.multiplier.len());
        let length = self.plan.units.length;
        for (interface, obstacle) in self.interfaces.placed(&state.drive, length) {
            let part = linearise(&body, &interface.surface, &obstacle, &is_held);
            out.max_penetration = out.max_penetration.max(part.max_penetration);
            joined.add(interface, part);
        }
        out.sets.clone_from(&self.interfaces.sets);
        (out.gap, out.coupling) = joined.finish(state.displacement.len());
    }

    /// Adds gap, coupling and contact load to the residuals.
    pub(crate) fn add_contact(
        &self,
        state: &State,
        force: &mut [f64],
        out: &mut Evaluation,
        work: &mut Workspace,
    ) {
        self.linearise(state, &self.data.held, out);
        if !state.multiplier.is_empty() {
            let mut contact = work.scratch(force.len());
            let coupling = &out.coupling;
            coupling.apply_transposed(&state.multiplier, &mut contact, work);
            out.contact_norm = norm(&contact);
            add_scaled(force, -1.0, &contact);
            work.give(contact);
        }
    }

    /// Adds C^T l with held columns kept.
    pub(crate) fn add_contact_force(&self, state: &State, force: &mut [f64]) {
        if state.multiplier.is_empty() {
            return;
        }
        let mut all = Evaluation::default();
        self.linearise(state, &[], &mut all);
        let mut contact = vec![0.0; force.len()];
        let coupling = &all.coupling;
        coupling.apply_transposed(&state.multiplier, &mut contact, &mut Workspace::new());
        add_scaled(force, 1.0, &contact);
    }

    /// The metric of the contact pressure.
    pub(crate) fn compliance(&self, coupling: &SparseRows) -> Compliance {
        let parts = ComplianceParts {
            vertex_inverse: &self.data.compliance,
            traces: Traces {
                vertices: &self.data.traces.vertices,
                directions: &self.data.traces.directions,
            },
            node_blocks: &NodeBlocks::invert(self.data.space.components, Vec::new()),
            vertex_count: self.data.space.vertices,
            edge_ends: None,
            is_held: &[],
            volumes: None,
            scale: OF_MIXED,
        };
        Compliance::new(&parts, coupling)
    }

    /// Resultants of every obstacle by name, in the caller's units.
    pub(crate) fn obstacle_results(&self, state: &State) -> BTreeMap<String, ObstacleResult> {
        let trace = self.trace(state);
        self.touching(state, &trace).results(|_, _, _| ())
    }

    /// The body on its obstacles at `state`; `trace` is the displacement at the nodes
    /// of Taylor-Hood.
    fn touching<'b>(&'b self, state: &'b State, trace: &'b [f64]) -> Touching<'b> {
        Touching {
            plan: &self.plan,
            interfaces: &self.interfaces,
            state,
            body: self.deformed(trace),
        }
    }

    /// Contact pressure, gap or state on uploaded vertices; none for other fields
    /// and without obstacles.
    pub(crate) fn contact_field(&self, state: &State, name: FieldName) -> Option<Vec<f64>> {
        if self.interfaces.list.is_empty() {
            return None;
        }
        let trace = self.trace(state);
        let touching = self.touching(state, &trace);
        match name {
            FieldName::ContactPressure => Some(touching.pressure()),
            FieldName::Gap => Some(touching.gap()),
            FieldName::ContactState => Some(touching.contact_state()),
            FieldName::Displacement
            | FieldName::Pressure
            | FieldName::Stress
            | FieldName::Jacobian
            | FieldName::ErrorEstimate
            | FieldName::ContactPressureDeformed
            | FieldName::ContactPressureUndeformed
            | FieldName::FrictionTraction
            | FieldName::Slip
            | FieldName::LowestMode
            | FieldName::NodalForce => None,
        }
    }
}
