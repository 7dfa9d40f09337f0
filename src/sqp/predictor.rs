//! Where the programs of an increment of rubber start: at the state before, or at
//! that state moved on as the last two parts moved it,
//!
//! ```text
//! x(0) + r x[0, -1] + r (r + 1) x[0, -1, -1 - 1/q],   x = (u, p, l)
//! ```
//!
//! the parabola through the last three equilibria (Newton's divided differences; the
//! line through two where there are no more). What drives the body moved on by 1/q
//! and 1 between them and goes r further in the same direction; another direction has
//! no such start. Boundary and interior go on together, so that no cell beside a
//! moving support is turned inside out. Where supports share a rigid motion
//! ([`super::carry`]) the states are compared in the frame that it carries, and the
//! prediction is carried along, so that a turn needs no small increments.
//!
//! The residual decides. A predicted state is taken where its residual is less than
//! that of the plain start after the motion of its supports to first order, and
//! where its gaps hold: into a contact that spreads the state has a kink, and the
//! programs that mend it cost more than the prediction saves (decision 21). Cost: two
//! evaluations, a product with the tangent where supports move, and two changes of
//! the state kept.

use super::carry::Carry;
use super::constraints::prescribe;
use super::counters::{Counters, timed};
use super::drive::Drive;
use super::evaluate::{Context, Evaluation, evaluate, ratio};
use super::increment::remaining_motion;
use super::search::JACOBIAN_SHARE;
use super::state::{Snapshot, State};
use super::tangent::Tangent;
use crate::linalg::Workspace;
use crate::linalg::vector::{add_scaled, norm};

/// Residual of the gaps, over its scale, up to which contact counts as followed.
const GAPS_HOLD: f64 = 0.05;

/// Share of the contact pressure that a prediction must leave.
const FADED: f64 = 0.1;

/// Distance of a support, over the body's length, that a prediction leaves by rounding.
const ROUND_OFF: f64 = 1e-12;

/// Difference of two states.
#[derive(Clone, Debug)]
struct Change {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    multiplier: Vec<f64>,
}

impl Change {
    fn between(displacement: &[f64], before: &Snapshot, state: &State) -> Self {
        let change = |new: &[f64], old: &[f64]| -> Vec<f64> {
            new.iter().zip(old).map(|(new, old)| new - old).collect()
        };
        Self {
            displacement: change(&state.displacement, displacement),
            pressure: change(&state.pressure, &before.pressure),
            multiplier: change(&state.multiplier, &before.multiplier),
        }
    }

    fn add_to(&self, state: &mut State, weight: f64) {
        add_scaled(&mut state.displacement, weight, &self.displacement);
        add_scaled(&mut state.pressure, weight, &self.pressure);
        add_scaled(&mut state.multiplier, weight, &self.multiplier);
    }

    fn bytes(&self) -> u64 {
        let numbers = self.displacement.len() + self.pressure.len() + self.multiplier.len();
        8 * numbers as u64
    }
}

/// How the state moved over the last parts that converged.
#[derive(Clone, Debug)]
pub(crate) struct Trend {
    from: Drive,
    to: Drive,
    last: Change,
    /// The change before in the same direction, and how many times longer the last
    /// drive was.
    earlier: Option<(f64, Change)>,
}

impl Trend {
    /// Of a state that went on from `before`, where it had the trend `known`; the
    /// same where nothing drove it on.
    pub(super) fn noted(
        context: &Context<'_>,
        known: Option<Self>,
        before: &Snapshot,
        state: &State,
    ) -> Option<Self> {
        let scene = context.plan.scene();
        let [from, to] = [&before.drive, &state.drive].map(|drive| drive.felt_by(scene));
        if from == to {
            return known;
        }
        let earlier = known.filter(|known| known.to == from);
        let mut earlier = earlier.and_then(|known| {
            let longer = to.continues(&known.from, &known.to);
            let longer = longer.filter(|&longer| longer > 0.0);
            longer.map(|longer| (longer, known.last))
        });
        let mut displacement = before.displacement.clone();
        if let Some(carry) = Carry::between(context, &before.drive, &state.drive) {
            carry.apply(context, &mut displacement);
            if let Some((_, change)) = &mut earlier {
                let components = context.prepared.space.components;
                carry.turn(components, &mut change.displacement);
            }
        }
        Some(Self {
            from,
            to,
            last: Change::between(&displacement, before, state),
            earlier,
        })
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let earlier = self
            .earlier
            .as_ref()
            .map_or(0, |(_, change)| change.bytes());
        self.last.bytes() + earlier
    }

    /// Continues `state`, driven from `here`, towards `drive`; whether that is in the
    /// same direction and leaves contact pressure where there is some: that of a body
    /// at the end of contact is rounding, and no measure of itself.
    fn continue_to(&self, state: &mut State, here: &Drive, drive: &Drive) -> bool {
        let Some(further) = drive.continues(&self.from, &self.to) else {
            return false;
        };
        if self.to != *here {
            return false;
        }
        let before = norm(&state.multiplier);
        self.last.add_to(state, further);
        if let Some((longer, earlier)) = &self.earlier {
            let bend = further * (further + 1.0) * longer / (1.0 + longer);
            self.last.add_to(state, bend);
            earlier.add_to(state, -bend * longer);
        }
        let pressures = state.multiplier.iter_mut();
        pressures.for_each(|pressure| *pressure = pressure.max(0.0));
        before == 0.0 || norm(&state.multiplier) > FADED * before
    }
}

/// A state under the new drive, and what the motion of its supports makes of it.
struct Start {
    now: Evaluation,
    moved: Option<Evaluation>,
}

impl Start {
    fn of(
        context: &Context<'_>,
        state: &mut State,
        counters: &mut Counters,
        work: &mut Workspace,
    ) -> Self {
        let now = evaluated(context, state, counters, work);
        let moved = remaining_motion(context, state, &state.drive).and_then(|motion| {
            let tangent = Tangent::new(context, state, work)?;
            Some(tangent.after(&motion, context, state, &now, work))
        });
        Self { now, moved }
    }

    /// Norms of force, volume and gap.
    fn sizes(&self, active: &[bool]) -> [f64; 3] {
        let at = self.moved.as_ref().unwrap_or(&self.now);
        [norm(&at.force), norm(&at.constraint), at.gap_norm(active)]
    }

    fn force_scale(&self, active: &[bool]) -> f64 {
        let [force, ..] = self.sizes(active);
        self.now.force_scale(force)
    }
}

/// Moves `state` to where the programs towards `drive` start; what holds there, and
/// the scale of force without a prediction: a body that is predicted to come to rest
/// has none of its own.
pub(super) fn start(
    context: &Context<'_>,
    state: &mut State,
    drive: &Drive,
    counters: &mut Counters,
    work: &mut Workspace,
) -> (Evaluation, f64) {
    let mut before = state.snapshot();
    let carry = Carry::between(context, &before.drive, drive);
    let is_predicted = predict(context, state, &before, carry.as_ref(), drive);
    state.drive = drive.clone();
    if !is_predicted {
        let plain = evaluated(context, state, counters, work);
        let force = norm(&plain.force);
        return (plain, force);
    }
    let predicted = Start::of(context, state, counters, work);
    let after = state.snapshot();
    before.drive = drive.clone();
    state.restore(&before);
    let plain = Start::of(context, state, counters, work);
    let force = plain.force_scale(&state.active);
    if !is_better(state, &predicted, &plain) {
        return (plain.now, force);
    }
    state.restore(&after);
    let [_, constraint, gap] = plain.sizes(&state.active);
    state.scales.see(constraint, gap);
    if let (Some(carry), Some(softest)) = (&carry, &mut state.softest) {
        carry.turn(context.prepared.space.components, softest.motion_mut());
    }
    (predicted.now, force)
}

/// Moves the fields of `state`, which are those of `before`, on towards `drive`;
/// whether there is a way to.
fn predict(
    context: &Context<'_>,
    state: &mut State,
    before: &Snapshot,
    carry: Option<&Carry>,
    drive: &Drive,
) -> bool {
    let [here, there] = [&state.drive, drive].map(|drive| drive.felt_by(context.plan.scene()));
    let trend = state.trend.take();
    let goes_on = |trend: &Trend| trend.continue_to(state, &here, &there);
    let is_continued = trend.as_ref().is_some_and(goes_on);
    state.trend = trend;
    if !is_continued {
        state.restore(before);
    }
    if let Some(carry) = carry {
        carry.apply(context, &mut state.displacement);
    }
    settle(context, state, drive);
    is_continued || carry.is_some()
}

/// Puts supports where they shall be if only rounding is between.
fn settle(context: &Context<'_>, state: &mut State, drive: &Drive) {
    let mut goal = state.displacement.clone();
    let prepared = context.prepared;
    prescribe(context.plan, context.mesh, prepared, drive, &mut goal);
    let held = prepared.held.iter().map(|&index| index as usize);
    let mut distances = held.map(|index| (goal[index] - state.displacement[index]).abs());
    if distances.all(|distance| distance <= ROUND_OFF) {
        state.displacement = goal;
    }
}

fn evaluated(
    context: &Context<'_>,
    state: &State,
    counters: &mut Counters,
    work: &mut Workspace,
) -> Evaluation {
    timed(&mut counters.seconds.contact, || {
        evaluate(context, state, &state.drive, work)
    })
}

/// Whether the predicted start is the right side out, its gaps hold, and the largest
/// of its residuals is less, over the scales of both starts.
fn is_better(state: &State, predicted: &Start, plain: &Start) -> bool {
    let floor = JACOBIAN_SHARE * plain.now.least_jacobian.unwrap_or(0.0);
    let [after, before] = [predicted, plain].map(|start| start.sizes(&state.active));
    let force = [predicted, plain].map(|start| start.force_scale(&state.active));
    let mut seen = state.scales;
    seen.see(after[1].max(before[1]), after[2].max(before[2]));
    let scales = [force[0].max(force[1]), seen.constraint, seen.gap];
    let largest = |sizes: [f64; 3]| {
        let pairs = sizes.into_iter().zip(scales);
        let ratios = pairs.map(|(size, scale)| ratio(size, scale));
        ratios.fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
    };
    predicted
        .now
        .least_jacobian
        .is_some_and(|least| least > floor)
        && ratio(after[2], seen.gap) <= GAPS_HOLD
        && largest(after) < largest(before)
}
