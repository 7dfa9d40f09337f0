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
//! ([`crate::sqp::rigid_predictor`]) the states are compared in the frame that it carries, and the
//! prediction is carried along, so that a turn needs no small increments.
//!
//! The residual decides. A predicted state is taken where its residual is less than
//! that of the plain start after the motion of its supports to first order, and
//! where its gaps hold: into a contact that spreads the state has a kink, and the
//! programs that mend it cost more than the prediction saves (decision 21). A plain start
//! leaves the way of its tools out of the change of the area ([`crate::contact::Advancing`]).
//! Cost: two evaluations, a product with the tangent where supports move, two changes of
//! the state kept, and for a plain start the gaps once more.

use super::left_tools::release;
use super::rigid_predictor::RigidPredictor;
use super::run::Run;
use super::search::JACOBIAN_SHARE;
use super::trend::Trend;
use crate::linalg::vector::{norm, ratio, worst};
use crate::model::Model;
use crate::model::counters::timed;
use crate::model::drive::Drive;
use crate::model::evaluate::Evaluation;
use crate::model::prescribed::{prescribe, remaining_motion};
use crate::model::state::State;
use crate::model::tangent::Tangent;

constants! {
    /// Residual of the gaps, over its scale, up to which contact counts as followed.
    const GAPS_HOLD: f64 = 0.05;
    /// Distance of a support, over the body's length, that a prediction leaves by rounding.
    const ROUND_OFF: f64 = 1e-12;
}

/// A state under the new drive, and what the motion of its supports makes of it.
struct Start {
    /// Residuals with the supports where the last state left them.
    now: Evaluation,
    /// Residuals after the linearised motion of the supports; none where none of them
    /// moves.
    moved: Option<Evaluation>,
}

impl Start {
    /// Evaluates the state under the new drive and, where supports move, after their
    /// motion by the tangent.
    fn of(run: &mut Run<'_>) -> Self {
        let now = run.evaluate();
        let motion = remaining_motion(&run.model, run.state, &run.state.drive);
        let moved = motion.and_then(|motion| {
            let (model, work) = (&run.model, &mut run.work);
            let tangent = Tangent::new(model, run.state, &mut run.learned.linearised, work)?;
            let mut moved = tangent.after(&motion, (model, run.state), &now, work);
            motion.move_gaps(&now.coupling, &mut moved.gap, work);
            Some(moved)
        });
        Self { now, moved }
    }

    /// Norms of force, volume and gap.
    fn sizes(&self, state: &State) -> [f64; 3] {
        let at = self.moved.as_ref().unwrap_or(&self.now);
        [norm(&at.force), norm(&at.constraint), at.gap_norm(state)]
    }

    /// Norm of the force that counts as one under the new drive, non-dimensional.
    fn force_scale(&self, state: &State) -> f64 {
        let [force, ..] = self.sizes(state);
        self.now.force_scale(force)
    }
}

/// Moves the state to where the programs towards `drive` start; what holds there, and
/// the scale of force without a prediction: a body that is predicted to come to rest
/// has none of its own.
pub(crate) fn start(run: &mut Run<'_>, drive: &Drive) -> (Evaluation, f64) {
    let mut before = run.state.clone();
    let rigid = RigidPredictor::between(&run.model, &before.drive, drive);
    let is_predicted = predict(run, &before, rigid.as_ref(), drive);
    run.state.drive = drive.clone();
    if !is_predicted {
        let plain = run.evaluate();
        let plain = advanced(run, plain, before.drive);
        let force = norm(&plain.force);
        return (plain, force);
    }
    let predicted = Start::of(run);
    // The plain start is judged by the same measures, with the supports moved as far:
    // a prediction must beat it, or the increment starts from the last state.
    let after = run.state.clone();
    let last = std::mem::replace(&mut before.drive, drive.clone());
    run.state.clone_from(&before);
    let plain = Start::of(run);
    let force = plain.force_scale(run.state);
    if !is_better(run.state, &predicted, &plain) {
        return (advanced(run, plain.now, last), force);
    }
    run.state.clone_from(&after);
    // Scales are those of the plain start: a good prediction leaves residuals of
    // rounding, which are no measure of themselves.
    let [_, constraint, gap] = plain.sizes(run.state);
    run.state.scales.see(constraint, gap);
    // The softest motion is carried along with the body that it belongs to.
    if let (Some(rigid), Some(mode)) = (&rigid, &mut run.learned.lowest_mode) {
        let components = run.model.prepared.space.components;
        rigid.turn(components, &mut mode.motion);
    }
    (predicted.now, force)
}

/// What holds once tools that have left exert nothing, as a step sees it whose tools have moved on
/// from `last`.
fn advanced(run: &mut Run<'_>, now: Evaluation, last: Drive) -> Evaluation {
    let mut now = if release(&run.model, run.state, &now) {
        run.evaluate()
    } else {
        now
    };
    timed(&mut run.counters.seconds.contact, || {
        now.advance_from(last, (&run.model, run.state), run.work);
    });
    now
}

/// Moves the fields of the state, which are those of `before`, on towards `drive`;
/// whether there is a way to.
fn predict(
    run: &mut Run<'_>,
    before: &State,
    rigid: Option<&RigidPredictor>,
    drive: &Drive,
) -> bool {
    let plan = run.model.plan;
    let [here, there] = [&run.state.drive, drive].map(|drive| drive.felt_by(plan));
    let goes_on = |trend: &Trend| trend.continue_to(plan, run.state, [&here, &there]);
    let is_continued = run.learned.trend.as_ref().is_some_and(goes_on);
    if !is_continued {
        run.state.clone_from(before);
    }
    if let Some(rigid) = rigid {
        rigid.apply(&run.model, &mut run.state.displacement);
    }
    settle(&run.model, run.state, drive);
    is_continued || rigid.is_some()
}

/// Puts supports where they shall be if only rounding is between.
fn settle(model: &Model<'_>, state: &mut State, drive: &Drive) {
    let mut goal = state.displacement.clone();
    prescribe(model, drive, &mut goal);
    let mut distances = goal
        .iter()
        .zip(&state.displacement)
        .map(|(a, b)| (a - b).abs());
    if distances.all(|distance| distance <= ROUND_OFF) {
        state.displacement = goal;
    }
}

/// Whether the predicted start is the right side out, its gaps hold, and the largest
/// of its residuals is less, over the scales of both starts.
fn is_better(state: &State, predicted: &Start, plain: &Start) -> bool {
    let floor = JACOBIAN_SHARE * plain.now.least_jacobian.unwrap_or(0.0);
    let [after, before] = [predicted, plain].map(|start| start.sizes(state));
    let force = [predicted, plain].map(|start| start.force_scale(state));
    let mut seen = state.scales;
    seen.see(after[1].max(before[1]), after[2].max(before[2]));
    let scales = [force[0].max(force[1]), seen.constraint, seen.gap];
    let largest = |sizes: [f64; 3]| {
        let pairs = sizes.into_iter().zip(scales);
        let ratios: Vec<f64> = pairs.map(|(size, scale)| ratio(size, scale)).collect();
        worst(&ratios)
    };
    predicted
        .now
        .least_jacobian
        .is_some_and(|least| least > floor)
        && ratio(after[2], seen.gap) <= GAPS_HOLD
        && largest(after) < largest(before)
}
