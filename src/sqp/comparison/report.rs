//! From a state to the report of an increment, in the caller's units.

use std::collections::BTreeMap;

use super::super::counters::Counters;
use super::super::increment::Ending;
use super::super::results::given_to_supports;
use super::super::state::State;
use super::body::Body;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Workspace};
use crate::report::{ProbeResult, StepReport, SupportResult};

impl Body<'_> {
    /// The report, without what only the session knows.
    pub(super) fn report(
        &self,
        load: &[f64],
        state: &State,
        ending: &Ending,
        counters: &Counters,
        work: &mut Workspace,
    ) -> StepReport {
        let resolved = &self.plan.resolved;
        StepReport {
            step: 0,
            increment: 0,
            time: 0.0,
            load: state.drive.load,
            termination: ending.termination,
            cause: ending.cause,
            sqp_iterations: counters.sqp_iterations,
            krylov_iterations: counters.krylov_iterations,
            preconditioner_applications: counters.applications,
            eigenvalue_applications: 0,
            compliance_columns: 0,
            contact_products: counters.contact_products,
            active_set_changes: counters.set_changes,
            cut_backs: 0,
            factorisations: 0,
            active_vertices: state.active.iter().filter(|&&a| a).count() as u32,
            strain_energy: self.strain_energy(state, work) * self.plan.units.energy(),
            volume_ratio: self.volume_ratio(state, work),
            min_jacobian: None,
            penalty: 0.0,
            min_jacobian_bound: None,
            stability: None,
            max_penetration: ending.max_penetration * self.plan.units.length,
            residuals: ending.residuals,
            tolerance: ending.tolerance,
            obstacles: self.obstacle_results(state),
            supports: self.supports(load, state, work),
            probes: self.probes(state),
            error_estimate: None,
            errors: resolved
                .manufactured
                .as_ref()
                .map(|field| self.errors(state, field)),
            seconds: counters.seconds,
            unknowns: self.plan.unknowns(),
            memory_bytes: 0,
            reused: Vec::new(),
            instruction_set: "portable".to_owned(),
            verification: None,
        }
    }

    /// 1/2 int sigma : eps = 1/2 u.(A u) + 1/2 p.(S p).
    fn strain_energy(&self, state: &State, work: &mut Workspace) -> f64 {
        let mut product = work.scratch(state.displacement.len());
        let matrix = &self.data.stiffness.matrix;
        matrix.apply(&state.displacement, &mut product, work);
        let mut energy = 0.5 * dot(&state.displacement, &product);
        work.give(product);
        if let Some(stabilisation) = &self.data.pressure.stabilisation {
            let mut product = work.scratch(state.pressure.len());
            stabilisation.apply(&state.pressure, &mut product, work);
            energy += 0.5 * dot(&state.pressure, &product);
            work.give(product);
        }
        energy
    }

    /// 1 + int div u / V; pressure functions sum to one.
    fn volume_ratio(&self, state: &State, work: &mut Workspace) -> f64 {
        let mut rows = work.scratch(state.pressure.len());
        let matrix = &self.data.pressure.coupling.matrix;
        matrix.apply(&state.displacement, &mut rows, work);
        let change: f64 = rows.iter().sum();
        work.give(rows);
        1.0 - change / self.data.geometry.volumes.iter().sum::<f64>()
    }

    /// Reactions at held vertices, given to the support that holds them; bubbles
    /// have no part in a resultant, since P1 has the constants.
    fn supports(
        &self,
        load: &[f64],
        state: &State,
        work: &mut Workspace,
    ) -> BTreeMap<String, SupportResult> {
        let space = &self.data.space;
        let mut reaction = self.internal_force(state, work);
        add_scaled(&mut reaction, -state.drive.load, load);
        self.add_contact_force(state, &mut reaction);
        // Bubbles are numbered behind the vertices.
        let nodal = &reaction[..space.p1_unknowns()];
        given_to_supports(self.plan, space.components, nodal)
    }

    fn probes(&self, state: &State) -> BTreeMap<String, ProbeResult> {
        let units = &self.plan.units;
        let names = self.plan.scene.probes.iter();
        names
            .zip(&self.plan.resolved.probes)
            .map(|(probe, located)| {
                let cell = located.cell as usize;
                let l = &located.barycentric[..self.data.space.components + 1];
                let displacement = self.displacement_at(state, cell, l);
                let result = ProbeResult {
                    displacement: displacement.map(|x| x * units.length),
                    pressure: Some(self.pressure_at(state, cell, l) * units.stress),
                };
                (probe.name.clone(), result)
            })
            .collect()
    }
}
