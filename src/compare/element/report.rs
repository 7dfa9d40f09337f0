//! From a state to the report of an increment, in the caller's units.

use std::collections::BTreeMap;

use crate::compare::element::body::EnrichedBody;
use crate::linalg::vector::{add_scaled, dot};
use crate::linalg::{LinearOperator, Workspace};
use crate::model::counters::Counters;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::report::{ProbeResult, StepReport, SupportResult};
use crate::results::step::{counted, given_to_supports};

impl EnrichedBody {
    /// The report, without what only the session knows.
    pub(crate) fn step_report(
        &self,
        state: &State,
        ending: &Ending,
        counters: &Counters,
        work: &mut Workspace,
    ) -> StepReport {
        let resolved = &self.plan.resolved;
        StepReport {
            active_vertices: self.interfaces.contacts_at_work(state) as u32,
            strain_energy: self.strain_energy(state, work) * self.plan.units.energy(),
            volume_ratio: self.volume_ratio(state, work),
            max_penetration: ending.max_penetration * self.plan.units.length,
            obstacles: self.obstacle_results(state),
            supports: self.supports(state, work),
            probes: self.probes(state),
            errors: resolved
                .manufactured
                .as_ref()
                .map(|field| self.errors(state, field)),
            unknowns: self.plan.unknowns(),
            instruction_set: "portable".to_owned(),
            ..counted(state, ending, counters)
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
    fn supports(&self, state: &State, work: &mut Workspace) -> BTreeMap<String, SupportResult> {
        let space = &self.data.space;
        let mut reaction = self.internal_force(state, work);
        add_scaled(&mut reaction, -state.drive.load, &self.load);
        self.add_contact_force(state, &mut reaction);
        // Bubbles are numbered behind the vertices.
        let nodal = &reaction[..space.p1_unknowns()];
        given_to_supports(&self.plan, space.components, nodal)
    }

    /// Values at the probes by name, in the caller's units.
    fn probes(&self, state: &State) -> BTreeMap<String, ProbeResult> {
        let units = &self.plan.units;
        let probes = self.plan.resolved.probes.iter();
        probes
            .map(|probe| {
                let located = &probe.place;
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
