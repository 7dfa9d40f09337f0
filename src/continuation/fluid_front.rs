//! Equilibrium with fluids where they come to: after each solution the fronts advance, until none
//! does. A fluid that reaches what must stay dry, or another fluid, leaks: there is nothing to
//! solve any more; so does one that has advanced until the body has no equilibrium, as where it lifts
//! what a dead load holds down, and one whose blow-off is sought under which the body has none, as
//! where it is pushed out. Wet nodes only become more within a part; what was squeezed out dries before it.
//! Cost: the solutions of all rounds, one without fluids.

use crate::fluid::front::{Advance, Front};
use crate::force_control;
use crate::model::Model;
use crate::model::drive::Drive;
use crate::model::ending::{Ending, Leak, Site};
use crate::model::fluids::Met;
use crate::model::open_gap;
use crate::model::state::State;
use crate::report::{Cause, Termination};
use crate::scene::Film;
use crate::sqp::increment;
use crate::sqp::run::Run;
use crate::sqp::verdict::Verdict;

/// Solves under `drive` with fluids as far as they come.
pub(super) fn solve(run: &mut Run<'_>, drive: &Drive) -> Ending {
    if run.state.wet.is_empty() {
        return force_control::solve(run, drive);
    }
    squeeze(&run.model, run.state, drive);
    let mut advanced = sought(run.state, drive);
    loop {
        if let Some(leak) = leak(&run.model, run.state, drive) {
            return leaking(run, leak);
        }
        let mut ending = force_control::solve(run, drive);
        run.counters.fluid_rounds += 1;
        if ending.termination != Termination::Converged {
            ending.leak = advanced;
            return ending;
        }
        if advance(&run.model, run.state, drive) == Advance::default() {
            return ending;
        }
        advanced = pressing(drive);
    }
}

/// Does `act` with every fluid that has a pressure under `drive`: its number, what it meets, and
/// the nodes that it wets.
fn with_fronts(
    (model, state): (&Model<'_>, &mut State),
    drive: &Drive,
    act: &mut dyn FnMut(usize, &Front<'_>, &mut [bool]),
) {
    let problem = &model.plan.problem;
    let pressing = (0..problem.fluid_surfaces.len()).filter(|&k| drive.fluids[k].pressure > 0.0);
    for index in pressing {
        let met = Met::at(model, state, index);
        let front = met.front(model.plan, index, drive);
        act(index, &front, &mut state.wet[index]);
    }
}

/// Lets every fluid advance at the present contact; how far.
fn advance(model: &Model<'_>, state: &mut State, drive: &Drive) -> Advance {
    let mut all = Advance::default();
    with_fronts((model, state), drive, &mut |_, front, wet| {
        let own = front.advance(wet);
        all.flooded += own.flooded;
        all.entered += own.entered;
    });
    all
}

/// Dries what is pressed on all sides, of fluids whose film does not stay.
fn squeeze(model: &Model<'_>, state: &mut State, drive: &Drive) {
    let fluids = &model.plan.problem.resolved.fluids;
    with_fronts((model, state), drive, &mut |index, front, wet| {
        if fluids[index].film == Film::SqueezedOut {
            front.squeeze(wet);
        }
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

/// The first fluid, in the order of the scene, that is where it must not be.
fn leak(model: &Model<'_>, state: &State, drive: &Drive) -> Option<Leak> {
    let surfaces = &model.plan.problem.fluid_surfaces;
    let pressed = |index: &usize| drive.fluids[*index].pressure > 0.0;
    let mut leaks = (0..surfaces.len()).filter(pressed).filter_map(|index| {
        let surface = &surfaces[index];
        let is_taken = |node| is_wet_by_others(model, state, (index, node));
        let place = surface.leak(&state.wet[index], is_taken)?;
        Some(leak_at(index, Some(surface.nodes[place])))
    });
    leaks.next()
}

/// Whether another fluid than that of number `own` is at a node.
fn is_wet_by_others(model: &Model<'_>, state: &State, (own, node): (usize, u32)) -> bool {
    let surfaces = model.plan.problem.fluid_surfaces.iter();
    let mut others = surfaces.zip(&state.wet).enumerate();
    others.any(|(index, (surface, wet))| {
        let place = surface.nodes.binary_search(&node);
        index != own && place.is_ok_and(|place| wet[place])
    })
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

/// The fluid whose blow-off is sought and whose pressure rises, as one that leaks.
fn sought(state: &State, drive: &Drive) -> Option<Leak> {
    let mut ends = drive.fluids.iter().zip(&state.drive.fluids);
    let rising = ends.position(|(end, start)| end.to_blow_off && end.pressure > start.pressure);
    rising.map(|fluid| leak_at(fluid, None))
}

/// The fluid of the highest pressure as one that leaks.
fn pressing(drive: &Drive) -> Option<Leak> {
    let pressures = drive.fluids.iter().map(|fluid| fluid.pressure).enumerate();
    let (fluid, _) = pressures.max_by(|a, b| a.1.total_cmp(&b.1))?;
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
