//! Contact of a comparison element whose trace is P1: cell bubbles vanish on the
//! surface, so that gaps, resultants and multipliers are those of Taylor-Hood
//! with edge corrections of zero.

use std::collections::BTreeMap;

use super::super::drive::Drive;
use super::super::evaluate::Evaluation;
use super::super::state::State;
use super::body::Body;
use crate::contact::gap::{Deformed, evaluate_gaps, linearise};
use crate::contact::resultant::resultant;
use crate::linalg::vector::{add_scaled, norm};
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::obstacle::{Moving, Obstacle};
use crate::precond::NodeBlocks;
use crate::precond::compliance::{ComplianceParts, compliance};
use crate::precond::p1::Traces;
use crate::report::{FieldName, ObstacleResult};

/// Contact state of vertices that carry no multiplier.
const NOT_A_CANDIDATE: f64 = -1.0;

impl Body<'_> {
    /// P1 values with edge corrections of zero.
    fn trace(&self, state: &State) -> Vec<f64> {
        let mut trace = vec![0.0; self.data.trace.displacement_unknowns()];
        let first = self.data.space.p1_unknowns();
        trace[..first].copy_from_slice(&state.displacement[..first]);
        trace
    }

    fn deformed<'b>(&'b self, trace: &'b [f64]) -> Deformed<'b> {
        Deformed {
            mesh: self.mesh,
            scale: self.plan.units.coordinate_scale,
            space: &self.data.trace,
            displacement: trace,
            rule: &self.interfaces.rule,
        }
    }

    fn obstacles(&self, drive: &Drive) -> Vec<Moving> {
        let length = self.plan.units.length;
        self.interfaces.obstacles(drive, length)
    }

    /// Gaps and their coupling on the columns that `is_held` leaves; sets the gap
    /// of `out`.
    fn linearise(&self, state: &State, drive: &Drive, held: &[u32], out: &mut Evaluation) {
        let trace = self.trace(state);
        let body = self.deformed(&trace);
        let mut is_held = vec![true; trace.len()];
        is_held[..self.data.space.p1_unknowns()].fill(false);
        held.iter().for_each(|&k| is_held[k as usize] = true);
        let mut builder = SparseRowsBuilder::new(state.displacement.len());
        let list = self.interfaces.list.iter();
        for (interface, obstacle) in list.zip(&self.obstacles(drive)) {
            let mut part = linearise(&body, &interface.surface, obstacle, &is_held);
            out.gap.append(&mut part.gap);
            out.max_penetration = out.max_penetration.max(part.max_penetration);
            part.rows.iter_mut().for_each(|row| builder.push_row(row));
        }
        out.coupling = builder.finish();
    }

    /// Adds gap, coupling and contact load to the residuals.
    pub(super) fn add_contact(
        &self,
        state: &State,
        drive: &Drive,
        force: &mut [f64],
        out: &mut Evaluation,
        work: &mut Workspace,
    ) {
        self.linearise(state, drive, &self.data.held, out);
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
    pub(super) fn add_contact_force(&self, state: &State, force: &mut [f64]) {
        if state.multiplier.is_empty() {
            return;
        }
        let mut all = Evaluation::default();
        self.linearise(state, &state.drive, &[], &mut all);
        let mut contact = vec![0.0; force.len()];
        let coupling = &all.coupling;
        coupling.apply_transposed(&state.multiplier, &mut contact, &mut Workspace::new());
        add_scaled(force, 1.0, &contact);
    }

    /// The metric of the contact pressure.
    pub(super) fn compliance(&self, coupling: &SparseRows) -> DenseMatrix {
        let parts = ComplianceParts {
            vertex_inverse: &self.data.compliance,
            traces: Traces {
                vertices: &self.plan.contact_vertices,
                directions: &self.data.contact_normals,
            },
            node_blocks: &NodeBlocks::invert(self.data.space.components, Vec::new()),
            vertex_count: self.data.space.vertices,
        };
        compliance(&parts, coupling)
    }

    pub(super) fn obstacle_results(&self, state: &State) -> BTreeMap<String, ObstacleResult> {
        let units = &self.plan.units;
        let trace = self.trace(state);
        let body = self.deformed(&trace);
        let obstacles = self.obstacles(&state.drive);
        let list = self.interfaces.list.iter().zip(&obstacles);
        list.map(|(interface, obstacle)| {
            let found = resultant(
                &body,
                &interface.surface,
                obstacle,
                obstacle.reference_point(),
                &state.multiplier[interface.range()],
                &state.active[interface.range()],
            );
            let result = ObstacleResult {
                force: found.force.map(|x| x * units.force()),
                moment: found.moment.map(|x| x * units.energy()),
                contact_area: found.area * units.area(),
                max_pressure: found.max_pressure * units.stress,
                max_pressure_deformed: None,
                centre_of_pressure: found.centre.map(|x| x * units.length),
                stick_vertices: 0,
                slip_vertices: 0,
                force_error: None,
            };
            (interface.name.clone(), result)
        })
        .collect()
    }

    /// Contact pressure, gap or state on uploaded vertices; none for other fields
    /// and without obstacles.
    pub(super) fn contact_field(&self, state: &State, name: FieldName) -> Option<Vec<f64>> {
        if self.interfaces.list.is_empty() {
            return None;
        }
        match name {
            FieldName::ContactPressure => {
                let scaled: Vec<f64> = state
                    .multiplier
                    .iter()
                    .map(|l| l * self.plan.units.stress)
                    .collect();
                Some(self.on_surface(&scaled, 0.0, f64::max))
            }
            FieldName::Gap => Some(self.on_surface(&self.gaps(state), 0.0, f64::min)),
            FieldName::ContactState => {
                let flags = state.active.iter().map(|&a| f64::from(u8::from(a)));
                let flags: Vec<f64> = flags.collect();
                Some(self.on_surface(&flags, NOT_A_CANDIDATE, f64::max))
            }
            FieldName::Displacement
            | FieldName::Pressure
            | FieldName::Stress
            | FieldName::Jacobian
            | FieldName::ErrorEstimate
            | FieldName::ContactPressureDeformed => None,
        }
    }

    /// Weighted gap over nodal weight: a length.
    fn gaps(&self, state: &State) -> Vec<f64> {
        let trace = self.trace(state);
        let body = self.deformed(&trace);
        let obstacles = self.obstacles(&state.drive);
        let mut gaps = Vec::with_capacity(state.multiplier.len());
        for (interface, obstacle) in self.interfaces.list.iter().zip(&obstacles) {
            let (weighted, _) = evaluate_gaps(&body, &interface.surface, obstacle);
            let weights = interface.surface.weights.iter();
            let length = self.plan.units.length;
            gaps.extend(weighted.iter().zip(weights).map(|(g, w)| g / w * length));
        }
        gaps
    }

    /// Multiplier values on uploaded vertices; `merge` joins several obstacles.
    fn on_surface(&self, values: &[f64], elsewhere: f64, merge: fn(f64, f64) -> f64) -> Vec<f64> {
        let mut out = vec![None; self.mesh.vertex_count()];
        for interface in &self.interfaces.list {
            let vertices = interface.surface.vertices.iter();
            for (&vertex, &value) in vertices.zip(&values[interface.range()]) {
                let uploaded = self.mesh.used_vertices()[vertex as usize];
                let slot: &mut Option<f64> = &mut out[uploaded as usize];
                *slot = Some(slot.map_or(value, |old| merge(old, value)));
            }
        }
        out.into_iter()
            .map(|value| value.unwrap_or(elsewhere))
            .collect()
    }
}
