//! One increment on a comparison element: linear mixed scenes, with contact where the
//! trace is P1.
//!
//! ```text
//! f - A u - B^T p - C(u)^T l = 0,   B u - S p = 0,   g(u) >= 0, l >= 0, l g(u) = 0
//! ```
//!
//! One program per increment, more where an obstacle is curved; what rounding
//! leaves is solved once more.

use crate::compare::element::body::EnrichedBody;
use crate::linalg::Workspace;
use crate::linalg::vector::dot;
use crate::mesh::Mesh;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::{Start, State};
use crate::plan::Plan;
use crate::report::{Cause, FieldData, FieldName, StepReport, Termination};
use crate::session::body::{Advanced, Body, Increment, Shared};
use crate::sqp::learned::Learned;

/// Residual below which an iterate that did not converge is kept.
const MEANINGFUL: f64 = 1e-3;

impl Body for EnrichedBody {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn shared(&self) -> Shared {
        Shared {
            bytes: self.data.bytes(),
            seconds: self.data.seconds(),
            parts: self.data.parts(),
        }
    }

    fn bytes(&self) -> u64 {
        8 * self.load.len() as u64
    }

    /// Comes to the end of the increment or nowhere.
    fn advance<'a>(&'a self, mut run: Increment<'a>, goal: &Drive, before: &State) -> Advanced {
        let mut ending = self.solve(&mut run, goal);
        self.centre_pressure(run.state);
        self.name_cause(run.state, &mut ending);
        let is_good = is_good(&ending);
        if !is_good {
            run.state.clone_from(before);
            self.describe(&mut run, &mut ending);
        }
        Advanced {
            ending,
            part: if is_good { 1.0 } else { 0.0 },
            start: Start::at(before),
            slip_start: None,
            counters: run.counters,
            work: run.work,
        }
    }

    /// Nothing is left out on such an element.
    fn complete<'a>(&'a self, at: Increment<'a>) -> Workspace {
        at.work
    }

    /// Nothing: no step pushes obstacles on such an element.
    fn exerted(&self, _: &State) -> Vec<[f64; 6]> {
        vec![[0.0; 6]; self.plan.obstacles.len()]
    }

    fn report(&self, state: &State, advanced: &mut Advanced) -> StepReport {
        let Advanced {
            ending,
            counters,
            work,
            ..
        } = advanced;
        self.step_report(state, ending, counters, work)
    }

    /// No eigenvalue is estimated for it.
    fn count_preparation(&self, _report: &mut StepReport) {}

    fn field(&self, (state, _): (&State, &Learned), name: FieldName) -> Option<FieldData> {
        self.field_of(state, name)
    }
}

impl EnrichedBody {
    /// Why an iteration that got stuck at `state` did.
    fn name_cause(&self, state: &State, ending: &mut Ending) {
        let touches = state.status.iter().any(|status| status.is_closed());
        let stuck = matches!(
            ending.cause,
            Some(Cause::Stagnation | Cause::IterationLimit)
        );
        if stuck && self.plan.is_floating() && !touches {
            ending.cause = Some(Cause::NoEquilibrium);
        } else if stuck && self.data.pressure.is_enclosed {
            ending.cause = Some(Cause::EnclosedVolume);
        }
    }

    /// An enclosed incompressible body fixes its pressure up to a constant: the
    /// mean is set to zero.
    fn centre_pressure(&self, state: &mut State) {
        let pressure = &self.data.pressure;
        if pressure.is_enclosed {
            let volume = pressure.weights.iter().sum::<f64>();
            let mean = dot(&pressure.weights, &state.pressure) / volume;
            state.pressure.iter_mut().for_each(|p| *p -= mean);
        }
    }
}

/// Whether the new state is of use.
fn is_good(ending: &Ending) -> bool {
    let is_unbounded = matches!(
        ending.cause,
        Some(Cause::NoEquilibrium | Cause::EnclosedVolume | Cause::NotFinite)
    );
    match ending.termination {
        Termination::Converged => true,
        Termination::NotConverged => ending.residuals.largest() < MEANINGFUL && !is_unbounded,
        Termination::Cancelled | Termination::DeadlineExceeded | Termination::InternalError => {
            false
        }
    }
}
