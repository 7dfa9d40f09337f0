//! Updates that a session accepted, in sequence; the first one is the current.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use signorini::report::{CancelToken, StepReport, Termination};
use signorini::scene::Step;
use signorini_proto::v1 as wire;
use tokio::sync::mpsc;
use tokio::task::AbortHandle;
use tokio::time::Instant;

use super::clock::SlotClock;
use super::work::Event;
use crate::convert::step::Update;
use crate::watch::traces::UpdateTrace;

/// A step that was told to stop and has not after this time is answered without
/// its solver thread.
const PATIENCE: Duration = Duration::from_millis(150);

/// A step that was answered so counts as left behind when its solver thread has still not stopped
/// after this time: a factorisation or a hierarchy that ends soon troubles nobody.
const STUCK: Duration = Duration::from_secs(5);

/// How often the time of a step that waits for a slot is looked at.
const SHORTEST_LOOK: Duration = Duration::from_millis(50);

/// What the increments of a step took so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spent {
    pub(super) sqp_iterations: u64,
    pub(super) krylov_iterations: u64,
    /// Wall time, s.
    pub(super) seconds: f64,
}

/// One accepted update.
pub(super) struct Accepted {
    pub(super) sequence: i64,
    pub(super) step: Step,
    pub(super) cancel: CancelToken,
    pub(super) cancelled_at: Option<Instant>,
    /// Results so far.
    pub(super) results: u32,
    /// The `SolveRequest` that brought it, encoded.
    pub(super) encoded: Bytes,
    /// Change of the journal that holds it.
    pub(super) mark: u64,
    /// From its first increment on.
    pub(super) trace: Option<UpdateTrace>,
    spent: Spent,
    max_wall_time: Option<Duration>,
    /// Time that it had a slot.
    pub(super) slot_clock: Arc<SlotClock>,
    /// It had a slot as long as any step may.
    pub(super) is_too_long: bool,
    ceiling: Option<AbortHandle>,
    deadline: Option<AbortHandle>,
    stream_deadline: Option<AbortHandle>,
    patience: Option<AbortHandle>,
}

impl Accepted {
    fn new(update: Update) -> Self {
        Self {
            sequence: update.sequence,
            step: update.step,
            cancel: CancelToken::new(),
            cancelled_at: None,
            results: 0,
            encoded: update.encoded,
            mark: 0,
            trace: None,
            spent: Spent::default(),
            max_wall_time: update.max_wall_time,
            slot_clock: Arc::default(),
            is_too_long: false,
            ceiling: None,
            deadline: None,
            stream_deadline: None,
            patience: None,
        }
    }

    /// Number of the step, from 1: every update is one, also one that stops before
    /// it begins, so the sequence counts them.
    pub(super) fn step_number(&self) -> u32 {
        u32::try_from(self.sequence).unwrap_or(u32::MAX)
    }

    /// Counts an increment that a solver finished.
    pub(super) fn spend(&mut self, report: &StepReport) {
        self.spent.sqp_iterations += u64::from(report.sqp_iterations);
        self.spent.krylov_iterations += u64::from(report.krylov_iterations);
        self.spent.seconds += report.seconds.total;
    }

    pub(super) fn spent(&self) -> Spent {
        self.spent
    }

    /// Asks the step to stop.
    pub(super) fn cancel(&mut self) {
        self.cancelled_at.get_or_insert_with(Instant::now);
        self.cancel.cancel();
    }

    /// Asks the step to stop because its time is up.
    pub(super) fn expire(&mut self) {
        self.cancelled_at.get_or_insert_with(Instant::now);
        self.cancel.expire();
    }

    /// The stream that asks for it ends then; replaces that of an earlier stream.
    pub(super) fn stream_ends_at(
        &mut self,
        deadline: Option<Instant>,
        events: &mpsc::UnboundedSender<Event>,
    ) {
        if let Some(earlier) = self.stream_deadline.take() {
            earlier.abort();
        }
        self.stream_deadline = deadline.map(|deadline| {
            let left = deadline.saturating_duration_since(Instant::now());
            post_after(left, events, Event::Deadline(self.sequence))
        });
    }

    /// Starts the step's clock, once.
    pub(super) fn start_clock(
        &mut self,
        scene_limit: Option<f64>,
        events: &mpsc::UnboundedSender<Event>,
    ) {
        let scene_limit = scene_limit.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let limit = self.max_wall_time.into_iter().chain(scene_limit).min();
        if let (Some(limit), None) = (limit, &self.deadline) {
            self.deadline = Some(post_after(limit, events, Event::Deadline(self.sequence)));
        }
    }

    /// Ends the step when it had a slot for `limit`; started once.
    pub(super) fn start_ceiling(
        &mut self,
        limit: Option<Duration>,
        events: &mpsc::UnboundedSender<Event>,
    ) {
        let (Some(limit), None) = (limit, &self.ceiling) else {
            return;
        };
        let (clock, events, sequence) =
            (Arc::clone(&self.slot_clock), events.clone(), self.sequence);
        let watch = tokio::spawn(async move {
            while let Some(left) = limit.checked_sub(clock.used()) {
                tokio::time::sleep(left.max(SHORTEST_LOOK)).await;
            }
            // A session that is gone has no step.
            let _gone = events.send(Event::Ceiling(sequence));
        });
        self.ceiling = Some(watch.abort_handle());
    }

    /// Starts, once, the time that a step which shall stop gets to do so.
    pub(super) fn start_patience(&mut self, events: &mpsc::UnboundedSender<Event>) {
        if self.patience.is_none() {
            let event = Event::OutOfPatience(self.sequence);
            self.patience = Some(post_after(PATIENCE, events, event));
        }
    }

    /// Whether `newest`, which ended so, is the last result of this step: all increments are done,
    /// one has failed, or a fluid is about to leak.
    pub(super) fn is_last(&self, newest: &wire::StepReport, termination: Termination) -> bool {
        let leaks = |fluid: &wire::FluidResult| fluid.tightness() == wire::Tightness::Leaks;
        termination != Termination::Converged
            || self.results >= self.step.increments
            || newest.fluids.values().any(leaks)
    }
}

impl Drop for Accepted {
    fn drop(&mut self) {
        let (ceiling, deadline) = (&self.ceiling, &self.deadline);
        let clocks = [ceiling, deadline, &self.stream_deadline, &self.patience];
        for clock in clocks.into_iter().flatten() {
            clock.abort();
        }
    }
}

/// Tells later whether a step that is left behind at that sequence still is.
pub(super) fn look_again(sequence: i64, events: &mpsc::UnboundedSender<Event>) {
    // Not aborted: the step has ended for its client.
    let _look = post_after(STUCK, events, Event::Stuck(sequence));
}

fn post_after(time: Duration, events: &mpsc::UnboundedSender<Event>, event: Event) -> AbortHandle {
    let events = events.clone();
    let clock = tokio::spawn(async move {
        tokio::time::sleep(time).await;
        // A session that is gone has no step.
        let _gone = events.send(event);
    });
    clock.abort_handle()
}

/// The accepted updates of a session.
#[derive(Default)]
pub(super) struct UpdateQueue {
    waiting: VecDeque<Accepted>,
    last_accepted: i64,
}

impl UpdateQueue {
    pub(super) fn last_accepted(&self) -> i64 {
        self.last_accepted
    }

    pub(super) fn len(&self) -> usize {
        self.waiting.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The updates up to `sequence` are finished already.
    pub(super) fn resume_after(&mut self, sequence: i64) {
        self.last_accepted = sequence;
    }

    /// The largest sequence that is accepted for good: the disk has it.
    pub(super) fn durably_accepted(&self, durable: u64) -> i64 {
        let waits = self.waiting.iter().find(|one| one.mark > durable);
        waits.map_or(self.last_accepted, |one| one.sequence - 1)
    }

    /// Appends the next update and returns it.
    pub(super) fn push(&mut self, update: Update) -> Option<&mut Accepted> {
        self.last_accepted = update.sequence;
        let place = self.waiting.len();
        self.waiting.push_back(Accepted::new(update));
        self.waiting.get_mut(place)
    }

    /// The unfinished update of this sequence.
    pub(super) fn find(&mut self, sequence: i64) -> Option<&mut Accepted> {
        self.waiting
            .iter_mut()
            .find(|accepted| accepted.sequence == sequence)
    }

    pub(super) fn current(&mut self) -> Option<&mut Accepted> {
        self.waiting.front_mut()
    }

    /// As [`Self::current`], to look at.
    pub(super) fn first(&self) -> Option<&Accepted> {
        self.waiting.front()
    }

    /// Sequence of the current update; 0 without one.
    pub(super) fn current_sequence(&self) -> i64 {
        self.waiting.front().map_or(0, |accepted| accepted.sequence)
    }

    /// Removes the current update: it is finished.
    pub(super) fn finish(&mut self) -> Option<Accepted> {
        self.waiting.pop_front()
    }

    /// Removes the current update, which consumes no sequence, and all after it.
    pub(super) fn refuse(&mut self) -> Vec<Accepted> {
        if let Some(first) = self.waiting.front() {
            self.last_accepted = first.sequence - 1;
        }
        self.waiting.drain(..).collect()
    }

    /// Removes all but the current update.
    pub(super) fn keep_current(&mut self) -> Vec<Accepted> {
        let later = self.waiting.split_off(self.waiting.len().min(1));
        self.last_accepted -= later.len() as i64;
        later.into()
    }

    /// Asks one update to stop, 0 for the current; returns its sequence.
    pub(super) fn cancel(&mut self, sequence: i64) -> Option<i64> {
        let wanted = match sequence {
            0 => self.current_sequence(),
            sequence => sequence,
        };
        self.find(wanted)?.cancel();
        Some(wanted)
    }
}
