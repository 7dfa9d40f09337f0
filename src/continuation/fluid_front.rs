//! Equilibrium with fluids where they come to: after each solution the fronts advance, until none
//! does. A fluid that reaches what must stay dry, or another fluid, leaks: there is nothing to
//! solve any more; so does one that has advanced until the body has no equilibrium, as where it lifts
//! what a dead load holds down, and one whose blow-off is sought under which the body has none, as
//! where it is pushed out. Wet nodes only become more within a part; what was squeezed out dries before it.
//! Where bodies slide on each other the film between them slides along: its shares are found anew after each
//! equilibrium until they stay, a fixed point of few more solutions, so that the end does not depend on
//! where parts began.
//! Cost: the solutions of all rounds, one without fluids.

use crate::fluid::front::{Advance, Front};
use crate::fluid::surface::FluidSurface;
use crate::force_control;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Leak, Site};
use crate::model::fluids::{Met, barred};
use crate::model::open_gap;
use crate::model::state::State;
use crate::report::{Cause, Termination};
use crate::scene::Film;
use crate::sqp::increment;
use crate::sqp::run::Run;
use crate::sqp::verdict::Verdict;

constants! {
    /// Change of a share of a film between bodies that is rounding, without unit: a ten-millionth of the
    /// length of a part of a face; chosen.
    const SLIDE: f64 = 1e-7;
    /// Times that films are taken along at most: each takes about a tenth of the change before it;
    /// chosen.
    const MOST_SLIDES: u32 = 20;
}

/// Solves under `drive` with fluids as far as they come.
pub(super) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    if run.state.wet.is_empty() {
        return force_control::solve(run, drive);
    }
    squeeze(&run.model, run.state, drive);
    let drives = rising(run.state, drive);
    let mut advanced = sought(run.state, drive, drives);
    let mut slides = 0;
    loop {
        if let Some(leak) = leak((&run.model, run.state), drive, drives) {
            return leaking(run, leak);
        }
        let mut ending = force_control::solve(run, drive);
        run.counters.fluid_rounds += 1;
        if ending.termination != Termination::Converged {
            ending.leak = advanced;
            return ending;
        }
        if advance(&run.model, run.state, drive) != Advance::default() {
            advanced = pressing(drive, drives);
            continue;
        }
        if !slide(&run.model, run.state, drive) {
            return ending;
        }
        if slides == MOST_SLIDES {
            ending.termination = Termination::NotConverged;
            ending.cause = Some(Cause::IterationLimit);
            return ending;
        }
        slides += 1;
    }
}

/// Takes the films between bodies along to where those are; whether any has changed by more than
/// rounding.
fn slide(model: &Model<'_>, state: &mut State, drive: &Drive) -> bool {
    let fluids = (0..state.film.len()).filter(|&k| drive.fluids[k].pressure > 0.0);
    let found = fluids.map(|index| {
        let met = Met::at(model, state, index);
        let front = met.front(model.plan, index, drive);
        (index, front.film(&state.wet[index]))
    });
    let found: Vec<(usize, Vec<f64>)> = found.collect();
    let mut has_slid = false;
    for (index, film) in found {
        let pairs = film.iter().zip(&state.film[index]);
        let change = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        if change > SLIDE {
            state.film[index] = film;
            has_slid = true;
        }
    }
    has_slid
}

/// Does `act` with every fluid that has a pressure under `drive`: its number, what it meets, and
/// the nodes that it wets; `act` says whether any has changed.
fn with_fronts(
    (model, state): (&Model<'_>, &mut State),
    drive: &Drive,
    act: &mut dyn FnMut(usize, &Front<'_>, &mut [bool]) -> bool,
) {
    let problem = &model.plan.problem;
    let pressing = (0..problem.fluid_surfaces.len()).filter(|&k| drive.fluids[k].pressure > 0.0);
    for index in pressing {
        let met = Met::at(model, state, index);
        let front = met.front(model.plan, index, drive);
        let has_changed = act(index, &front, &mut state.wet[index]);
        if let Some(film) = state.film.get_mut(index).filter(|_| has_changed) {
            *film = front.film(&state.wet[index]);
        }
    }
}

/// Lets every fluid advance at the present contact; how far.
fn advance(model: &Model<'_>, state: &mut State, drive: &Drive) -> Advance {
    let mut all = Advance::default();
    with_fronts((model, state), drive, &mut |_, front, wet| {
        let own = front.advance(wet);
        all.flooded += own.flooded;
        all.entered += own.entered;
        all.followed += own.followed;
        own != Advance::default()
    });
    all
}

/// Dries what is pressed on all sides, of fluids whose film does not stay, and what has left a wet
/// part of another body; wets what has come to one.
fn squeeze(model: &Model<'_>, state: &mut State, drive: &Drive) {
    let fluids = &model.plan.problem.resolved.fluids;
    with_fronts((model, state), drive, &mut |index, front, wet| {
        if fluids[index].film == Film::SqueezedOut {
            front.squeeze(wet);
        }
        front.settle(wet);
        true
    });
}

/// A leak that is not bracketed yet.
fn leak_at(fluid: usize, node: Option<u32>) -> Leak {
    Leak {
        fluid,
        node,
        pressures: [0.0; 2],
        is_pushed_out: false,
        conductance: None,
    }
}

/// The fluid that is where it must not be: of several, as where two meet, the one that `drives`, else
/// the first in the order of the scene.
fn leak(
    (model, state): (&Model<'_>, &State),
    drive: &Drive,
    drives: Option<usize>,
) -> Option<Leak> {
    let surfaces = &model.plan.problem.fluid_surfaces;
    let pressing = (0..surfaces.len()).filter(|&index| drive.fluids[index].pressure > 0.0);
    let leaks = pressing.filter_map(|index| {
        let place = FluidSurface::leak(&state.wet[index], &barred(model, state, index))?;
        Some(leak_at(index, Some(surfaces[index].nodes[place])))
    });
    let all: Vec<Leak> = leaks.collect();
    let driving = all.iter().find(|leak| Some(leak.fluid) == drives);
    driving.or(all.first()).copied()
}

/// The end of a part in which a fluid leaks.
fn leaking(run: &mut Run<'_>, leak: Leak) -> Ending {
    let (now, tolerance) = (run.evaluate(), run.model.conditions.tolerance);
    let at = (&now, run.state.force_scale);
    let verdict = Verdict::failed(Cause::Leaks);
    let site = site(run, leak);
    let conductance = open_gap::conductance(&run.model, run.state, leak.fluid);
    let leak = Leak {
        conductance,
        ..leak
    };
    Ending {
        leak: Some(leak),
        site,
        ..increment::ending(run.state, at, verdict, tolerance)
    }
}

/// The fluid that drives a part: of those whose pressure rises the one whose blow-off is sought, else
/// that of the largest rise.
fn rising(state: &State, drive: &Drive) -> Option<usize> {
    let ends = drive.fluids.iter().zip(&state.drive.fluids).enumerate();
    let rises = ends.map(|(index, (end, start))| (index, end, end.pressure - start.pressure));
    let most = rises
        .filter(|(_, _, rise)| *rise > 0.0)
        .max_by(|(_, a, rise), (_, b, other)| {
            let sought = a.to_blow_off.cmp(&b.to_blow_off);
            sought.then(rise.total_cmp(other))
        });
    most.map(|(index, ..)| index)
}

/// The fluid `drives` as one that leaks where the body has no equilibrium: its blow-off is sought, and
/// nothing else moves that may be the cause.
fn sought(state: &State, drive: &Drive, drives: Option<usize>) -> Option<Leak> {
    let fluid = drives.filter(|&fluid| drive.fluids[fluid].to_blow_off)?;
    let others = Drive {
        fluids: state.drive.fluids.clone(),
        ..drive.clone()
    };
    let is_led = others.pushes.is_empty() && others.poses != state.drive.poses;
    (!is_led && others.is_loaded_like(&state.drive)).then(|| leak_at(fluid, None))
}

/// The fluid that drives the part, else that of the highest pressure, as one that leaks.
fn pressing(drive: &Drive, drives: Option<usize>) -> Option<Leak> {
    let pressures = drive.fluids.iter().map(|fluid| fluid.pressure).enumerate();
    let highest = pressures.max_by(|a, b| a.1.total_cmp(&b.1));
    let fluid = drives.or(highest.map(|(fluid, _)| fluid))?;
    Some(leak_at(fluid, None))
}

/// Takes the leak back of a part that failed for another reason than a fluid.
pub(super) fn keep_leaks(ending: &mut Ending) {
    if !matches!(ending.cause, Some(Cause::Leaks | Cause::NoEquilibrium)) {
        ending.leak = None;
    }
}

/// Where a fluid leaks.
pub(super) fn site(run: &Run<'_>, leak: Leak) -> Option<Site> {
    let space = &run.model.prepared.space;
    leak.node.map(|node| Site {
        point: Some(space.node_place(run.model.mesh, node)),
        ..Site::default()
    })
}
