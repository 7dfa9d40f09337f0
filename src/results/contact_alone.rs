//! The report of an increment that was answered on contact alone: what multipliers and the trace
//! of the displacement say, and the names of what is left out. Numbers among these are not a
//! number. Cost: one probe a quadrature point of a pressed face.

use crate::model::Model;
use crate::model::counters::Counters;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::report::StepReport;
use crate::results::step::counted;
use crate::results::touching::Touching;

/// What needs the body inside, by the names of the report and of its obstacles.
const LEFT_OUT: [&str; 8] = [
    "warnings",
    "strain_energy",
    "volume_ratio",
    "supports",
    "probes",
    "error_estimate",
    "force_error",
    "geometry_error",
];

/// The report, without what only the session knows.
pub(crate) fn report(
    model: &Model<'_>,
    state: &State,
    ending: &Ending,
    counters: &Counters,
) -> StepReport {
    StepReport {
        active_vertices: model.interfaces.contacts_at_work(state) as u32,
        strain_energy: f64::NAN,
        volume_ratio: f64::NAN,
        max_penetration: ending.max_penetration * model.plan.problem.units.length,
        obstacles: Touching::of(model, state).results(|_, _, _| {}),
        unknowns: model.plan.unknowns(),
        instruction_set: model.prepared.grid.instruction_set().name().to_owned(),
        left_out: LEFT_OUT.to_vec(),
        ..counted(state, ending, counters)
    }
}
