//! A second attempt where the plan's own method fails: the increment from its start once
//! more, by the next of the methods that are built in.
//!
//! ```text
//! plan's own -> another metric -> another method -> a factor of the saddle point
//! ```
//!
//! Only failures of a method lead up: what is true of the body, as a limit of its load, is
//! true for every method. An attempt that fails leaves nothing behind but counts. The rung
//! that solved an increment is where the next one of its step begins; it is learnt, so
//! that a checkpoint forgets it on both sides.

use std::sync::Arc;

use super::approach::approach;
use super::enclosure::is_full;
use super::run::{Retry, Run};
use super::rung::Rung;
use super::watch::Watch;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::Ending;
use crate::model::state::State;
use crate::report::{Cause, Fallback, Termination};

/// Moves the state to `goal` by the plan's own method or the first rung that does; returns
/// how it ended and the part reached. Where none does, that is the attempt that came
/// furthest, the first one of equals. The state is at `start`.
pub(crate) fn climb(run: &mut Run<'_>, goal: &Drive, start: &State) -> (Ending, f64) {
    let known = run.learned.rung.clone();
    let mut rungs = behind(&run.model.plan.rungs(), known.as_deref());
    let mut end = match &known {
        Some(rung) => approach_on(run, rung, (goal, retry(&rungs))),
        None => {
            run.retry = retry(&rungs);
            approach(run, goal)
        }
    };
    let is_final = rungs.is_empty() || !is_failure_of_the_method(run, &end.0);
    if is_final || is_full(&run.model, run.state, goal) {
        return end;
    }
    let mut best = run.state.clone();
    while !rungs.is_empty() {
        let rung = Arc::new(Rung::new(&run.model, rungs.remove(0)));
        run.state.clone_from(start);
        run.learned.forget(run.model.plan);
        run.counters.failed_programs = 0;
        let next = approach_on(run, &rung, (goal, retry(&rungs)));
        if next.0.termination == Termination::Converged {
            run.learned.rung = Some(rung);
            return next;
        }
        if next.0.is_stopped() {
            return next;
        }
        if next.1 > end.1 {
            best.clone_from(run.state);
            end = next;
        }
    }
    run.state.clone_from(&best);
    end
}

/// The rungs behind the one that is known.
fn behind(rungs: &[Fallback], known: Option<&Rung>) -> Vec<Fallback> {
    let place = known.and_then(|known| rungs.iter().position(|&rung| rung == known.fallback));
    rungs[place.map_or(0, |place| place + 1)..].to_vec()
}

/// What follows a failure where `rungs` are left.
fn retry(rungs: &[Fallback]) -> Retry {
    match rungs.is_empty() {
        true => Retry::Parts,
        false => Retry::AnotherMethod,
    }
}

/// Whether a program was not solved and that was the end.
fn is_failure_of_the_method(run: &Run<'_>, ending: &Ending) -> bool {
    let is_numerical = ending.cause.is_some_and(Cause::is_numerical)
        || matches!(ending.cause, Some(Cause::LimitPoint | Cause::CoarseContact));
    // That obstacles close a volume is read from contact everywhere, which may not be.
    let pressure = run.model.prepared.pressure.as_ref();
    let is_guessed = ending.cause == Some(Cause::EnclosedVolume)
        && pressure.is_some_and(|block| !block.is_enclosed);
    let failed = ending.termination == Termination::NotConverged;
    failed && (is_numerical || is_guessed) && run.counters.failed_programs > 0
}

/// The way to `goal` on a rung.
fn approach_on(run: &mut Run<'_>, rung: &Rung, (goal, retry): (&Drive, Retry)) -> (Ending, f64) {
    let mut inner = Run {
        model: Model {
            plan: &rung.plan,
            interfaces: &rung.interfaces,
            ..run.model.clone()
        },
        state: &mut *run.state,
        learned: &mut *run.learned,
        watch: Watch {
            observer: &mut *run.watch.observer,
            cancel: run.watch.cancel,
            seconds_left: run.watch.seconds_left,
            record: run.watch.record.clone(),
        },
        counters: run.counters,
        work: std::mem::take(&mut run.work),
        retry,
        patience: run.patience,
    };
    let (mut ending, part) = approach(&mut inner, goal);
    if ending.termination == Termination::Converged {
        ending.fallback = Some(rung.fallback);
    }
    let Run { counters, work, .. } = inner;
    (run.counters, run.work) = (counters, work);
    (ending, part)
}

#[cfg(test)]
mod tests;
