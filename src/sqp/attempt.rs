//! One part of an increment, solved and judged: equilibrium as accurately as the scene
//! asks, of pushed obstacles too, the cause where there is none, the mean of a pressure that nothing fixes,
//! whether the equilibrium is a minimum, and whether friction admits others.

use std::time::Instant;

use super::balance;
use super::certificate::certify;
use super::diagnosis::explain;
use super::run::Run;
use super::uniqueness::look_for_a_rival;
use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::State;

/// Solves one part and says what kind of equilibrium it led to.
pub(crate) fn attempt(run: &mut Run<'_>, drive: &Drive) -> Ending {
    let mut ending = balance::solve(run, drive);
    explain(run, &mut ending);
    centre_pressure(&run.model, run.state);
    certify_timed(run, &mut ending);
    look_for_a_rival(run, &mut ending);
    ending
}

/// [`certify`], its seconds but for those that its solves count themselves.
fn certify_timed(run: &mut Run<'_>, ending: &mut Ending) {
    let (start, before) = (Instant::now(), run.counters.seconds.of_solving());
    certify(run, ending);
    let seconds = &mut run.counters.seconds;
    seconds.stability += start.elapsed().as_secs_f64() - (seconds.of_solving() - before);
}

/// An enclosed incompressible body fixes its pressure up to a constant:
/// the mean is set to zero.
fn centre_pressure(model: &Model<'_>, state: &mut State) {
    let block = model.prepared.pressure.as_ref();
    let Some(block) = block.filter(|block| block.is_enclosed) else {
        return;
    };
    let mut weights = vec![0.0; state.pressure.len()];
    let ones = vec![1.0; weights.len()];
    let mass = block.metric.mass();
    mass.apply(&ones, &mut weights, &mut Workspace::new());
    let mean = dot(&weights, &state.pressure) / weights.iter().sum::<f64>();
    state.pressure.iter_mut().for_each(|p| *p -= mean);
}
