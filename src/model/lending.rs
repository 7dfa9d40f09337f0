//! Functions of contacts between bodies of finite strain that meet next to nothing: found where an
//! increment begins ([`crate::pairs::support`]), noted in the state, and lent to their neighbours by
//! the surfaces of that increment.
//!
//! ```text
//! Lam_m = sum_k S_km Lam_k of before,   at the node of m's own function
//! ```
//!
//! Pressures and tractions stay what they were where a function keeps its multiplier or gets one; one
//! that lends has none. What no slip explains is a mean over a function, and goes along. Linear bodies
//! have what they are at rest for good. Cost: one search of partners an increment.

use super::Model;
use super::friction::{Frame, Friction};
use super::interfaces::{Interface, Interfaces};
use super::state::State;
use crate::contact::Deformed;
use crate::geometry::vector3::dot;
use crate::pairs::Support;
use crate::saddle::Status;

/// What the multipliers of `base` have to press on where the body is.
fn supports(base: &Model<'_>, state: &State) -> Vec<Support> {
    let body = base.deformed(&state.displacement);
    let before = base.interfaces.lending(base, state);
    let before = before.as_ref().unwrap_or(base.interfaces);
    let mut all = vec![Support::Enough; state.multiplier.len()];
    for (interface, old) in base.interfaces.list.iter().zip(&before.list) {
        if let Some(pair) = interface.pair() {
            let pressures = carried([old, interface], &interface.own(&state.multiplier));
            let own = pair.supports(&body, (&interface.surface, &pressures));
            for (place, support) in interface.places().zip(own) {
                all[place] = support;
            }
        }
    }
    all
}

impl Interfaces {
    /// Those of the increment that has led to `state`, or leads on from it; none where they are these.
    pub(crate) fn lending(&self, base: &Model<'_>, state: &State) -> Option<Self> {
        if state.supports.is_empty() {
            return None;
        }
        let body = base.deformed(&state.displacement);
        let mut lending = self.clone();
        for interface in &mut lending.list {
            interface.lend(&body, &interface.own(&state.supports));
        }
        Some(lending)
    }
}

/// Notes which multipliers lend from now on, and moves what they carry; `base` has none lend. Says
/// whether any has changed.
pub(crate) fn lend_anew(base: &Model<'_>, state: &mut State) -> bool {
    let has_pairs = !base.plan.problem.pairs.is_empty();
    if !base.is_rubber() || !has_pairs {
        return false;
    }
    let found = supports(base, state);
    let lends = found.iter().any(|support| support.lends());
    let kept = if lends { found.clone() } else { Vec::new() };
    if kept == state.supports {
        return false;
    }
    let before = base.interfaces.lending(base, state);
    let before = before.as_ref().unwrap_or(base.interfaces);
    let from = state.clone();
    state.supports = kept;
    let after = base.interfaces.lending(base, state);
    let after = after.as_ref().unwrap_or(base.interfaces);
    for (old, new) in before.list.iter().zip(&after.list) {
        if new.pair().is_some() {
            press([old, new], &from, (state, &found));
        }
    }
    if let Some(friction) = &base.interfaces.friction {
        rub(friction, [before, after], (base, &from), state);
    }
    true
}

/// Values of the multipliers of `new`, from those of `old`, that of its own function for each.
fn carried([old, new]: [&Interface; 2], values: &[f64]) -> Vec<f64> {
    let coefficients = old.surface.shares.spread(values);
    let own = (0..new.surface.multipliers() as u32).map(|m| {
        let function = new.surface.shares.function(m);
        function.map_or(0.0, |k| coefficients[k as usize])
    });
    own.collect()
}

/// Moves the pressures of a contact to multipliers with enough to press on: what has lent and meets
/// nothing any more would press on nothing, and no motion could take that off.
fn press(both: [&Interface; 2], from: &State, (state, supports): (&mut State, &[Support])) {
    let new = both[1];
    let values = carried(both, &new.own(&from.multiplier));
    for (place, value) in new.places().zip(values) {
        let presses = supports[place] == Support::Enough;
        let value = if presses { value } else { 0.0 };
        state.multiplier[place] = value;
        let status = &mut state.status[place];
        *status = match (value > 0.0, *status) {
            (false, _) => Status::Open,
            (true, Status::Open) => Status::Stick,
            (true, status) => status,
        };
    }
}

/// Moves the tractions of contacts between bodies, and what no slip explains.
fn rub(
    friction: &Friction,
    all: [&Interfaces; 2],
    (base, from): (&Model<'_>, &State),
    state: &mut State,
) {
    let width = friction.components.count();
    for own in &friction.pairs {
        let both = all.map(|all| &all.list[own.interface]);
        let [old, new] = both;
        let places = friction.tractions_of(&own.points);
        let frames = frames(both, &base.deformed(&from.displacement));
        let tractions = moved(both, &frames, &from.multiplier[places.clone()]);
        let means = own.points.clone().zip(&old.surface.weights);
        let means: Vec<f64> = means
            .flat_map(|(point, weight)| {
                let residue = &from.slip.residue[3 * point..3 * point + width];
                residue.iter().map(move |residue| residue / weight)
            })
            .collect();
        let means = moved(both, &frames, &means);
        let pressures = new.own(&state.multiplier).into_owned();
        for (k, place) in places.enumerate() {
            let (m, axis) = (k / width, k % width);
            let is_pressed = pressures[m] > 0.0;
            let status = &mut state.status[place];
            state.multiplier[place] = if is_pressed { tractions[k] } else { 0.0 };
            *status = match (is_pressed, *status) {
                (false, _) => Status::Open,
                (true, Status::Open) => Status::Stick,
                (true, status) => status,
            };
            let point = own.points.start + m;
            state.slip.residue[3 * point + axis] = means[k] * new.surface.weights[m];
        }
    }
}

/// Tangents of the multipliers of both in space; none in the plane.
fn frames(both: [&Interface; 2], body: &Deformed<'_>) -> Option<[Vec<Frame>; 2]> {
    let [old, new] = both.map(|one| one.pair()?.frames(body, &one.surface));
    Some([old?, new?])
}

/// Values along tangents of the multipliers of `new`, from those of `old`, as vectors in space.
fn moved(both: [&Interface; 2], frames: &Option<[Vec<Frame>; 2]>, values: &[f64]) -> Vec<f64> {
    let Some([old, new]) = frames else {
        return carried(both, values);
    };
    let axes = [0, 1, 2].map(|i: usize| {
        let pairs = old.iter().zip(values.chunks_exact(2));
        let along = pairs.map(|(frame, own)| own[0] * frame[0][i] + own[1] * frame[1][i]);
        carried(both, &along.collect::<Vec<f64>>())
    });
    let vector = |m: usize| [0, 1, 2].map(|i: usize| axes[i][m]);
    let along = new.iter().enumerate();
    along
        .flat_map(|(m, frame)| frame.map(|tangent| dot(tangent, vector(m))))
        .collect()
}
