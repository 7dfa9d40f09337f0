//! One part of an increment, solved and judged: equilibrium as accurately as the scene
//! asks, of pushed obstacles and fluids too, the cause where there is none, the mean of a pressure that nothing fixes,
//! whether the equilibrium is a minimum, and whether friction admits others.

use std::time::Instant;

use super::fluid_front;
use crate::diagnosis::uniqueness::look_for_an_alternative;
use crate::diagnosis::{explain, refuse_inside_out};
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::mean_pressure::centre_pressure;
use crate::sqp::condensation::contact_alone::answer;
use crate::sqp::run::Run;
use crate::stability::certify;

/// Solves one part and says what kind of equilibrium it led to.
pub(super) fn solve_part(run: &mut Run<'_>, drive: &Drive) -> Ending {
    if let Some(ending) = answer(run, drive) {
        return ending;
    }
    let mut ending = fluid_front::solve(run, drive);
    explain(run, &mut ending);
    fluid_front::keep_leaks(&mut ending);
    centre_pressure(&run.model, run.state);
    refuse_inside_out(run, &mut ending);
    certify_timed(run, &mut ending);
    look_for_an_alternative(run, &mut ending);
    ending
}

/// [`certify`], its seconds but for those that its solves count themselves.
fn certify_timed(run: &mut Run<'_>, ending: &mut Ending) {
    let (start, before) = (Instant::now(), run.counters.seconds.of_solving());
    certify(run, ending);
    let seconds = &mut run.counters.seconds;
    seconds.stability += start.elapsed().as_secs_f64() - (seconds.of_solving() - before);
}
