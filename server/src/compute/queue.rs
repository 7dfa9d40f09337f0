//! The queue of jobs between those who submit them and the seats that run them.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ::metrics::Gauge;

use super::fair_queue::FairQueue;
use super::{Job, LONG, Length, Load};
use crate::config::Slots;
use crate::door::client_key::{Flow, Share};
use crate::watch::metrics::Metrics;

/// How long a slot waits for the next job of the session that it has served.
const LINGER: Duration = Duration::from_millis(5);

/// How often a paused job looks whether it has been stopped.
const LOOK: Duration = Duration::from_millis(20);

enum Work {
    Begin(Job),
    /// A job that paused, by its ticket.
    Resume(u64),
}

pub(super) struct Waiting {
    work: Work,
    since: Instant,
    length: Length,
    client: Share,
}

/// What a running job has of its slot.
pub(super) struct Turn {
    /// `None` for a job that was stopped while it paused.
    pub(super) slot: Option<usize>,
    pub(super) since: Instant,
    ran: Duration,
    length: Length,
}

/// A job that a seat is to run.
pub(super) struct Begun {
    pub(super) flow: Flow,
    pub(super) job: Job,
    pub(super) turn: Turn,
}

/// Jobs that no slot has taken yet, and the slots that have none.
pub(super) struct Backlog {
    pub(super) jobs: FairQueue<Share, Waiting>,
    free: Vec<usize>,
    /// Slots with long work.
    long: usize,
    /// Slots of each client that has any.
    held: HashMap<Share, usize>,
    /// Jobs that may go on after a pause, by their tickets, with their slots.
    resumed: HashMap<u64, usize>,
    tickets: u64,
    /// Seats, and those of them without a job.
    pub(super) seats: usize,
    pub(super) idle: usize,
    pub(super) threads: Vec<JoinHandle<()>>,
    closed: bool,
}

impl Backlog {
    /// Counts a slot that a client has now.
    fn occupy(&mut self, client: Share, length: Length) {
        self.long += usize::from(length == Length::Long);
        *self.held.entry(client).or_default() += 1;
    }

    /// Counts a slot that it has given back.
    fn release(&mut self, flow: &Flow, length: Length) {
        self.long -= usize::from(length == Length::Long);
        let client = client_of(flow);
        if let Some(held) = self.held.get_mut(&client) {
            *held -= 1;
            if *held == 0 {
                self.held.remove(&client);
            }
        }
    }
}

fn client_of(flow: &Flow) -> Share {
    let [client, ..] = *flow;
    client
}

/// The queue.
pub(super) struct JobQueue {
    backlog: Mutex<Backlog>,
    arrived: Condvar,
    pub(super) slots: Slots,
    residuals: Vec<Gauge>,
    metrics: Arc<Metrics>,
}

impl JobQueue {
    pub(super) fn new(slots: Slots, metrics: &Arc<Metrics>) -> Self {
        Self {
            backlog: Mutex::new(Backlog {
                jobs: FairQueue::default(),
                free: (0..slots.count).rev().collect(),
                long: 0,
                held: HashMap::new(),
                resumed: HashMap::new(),
                tickets: 0,
                seats: 0,
                idle: 0,
                threads: Vec::new(),
                closed: false,
            }),
            arrived: Condvar::new(),
            slots,
            residuals: (0..slots.count)
                .map(|slot| metrics.residual(slot))
                .collect(),
            metrics: Arc::clone(metrics),
        }
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Backlog> {
        // Jobs run outside the lock, so a poisoned state is whole.
        self.backlog.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn load(&self) -> Load {
        let state = self.lock();
        Load {
            slots: self.slots.count,
            busy: self.slots.count - state.free.len(),
            waiting: state.jobs.len(),
        }
    }

    pub(super) fn show_residual(&self, slot: usize, residual: f64) {
        if let Some(gauge) = self.residuals.get(slot) {
            gauge.set(residual);
        }
    }

    pub(super) fn push(&self, flow: Flow, length: Length, job: Job) {
        let mut state = self.lock();
        let waiting = Waiting {
            work: Work::Begin(job),
            since: Instant::now(),
            length,
            client: client_of(&flow),
        };
        state.jobs.push(&flow, waiting);
        self.metrics.queue_depth(state.jobs.len());
        drop(state);
        // A slot that lingers for another session must not swallow the only call.
        self.arrived.notify_all();
    }

    pub(super) fn stop(&self) {
        self.lock().closed = true;
        self.arrived.notify_all();
    }

    /// Slots that long work may have.
    fn most_long(&self) -> usize {
        self.slots.count - self.slots.short
    }

    /// Which of the waiting jobs may be served now.
    fn may(&self, state: &Backlog) -> impl Fn(&Waiting) -> bool + use<> {
        let room = state.long < self.most_long();
        let most = self.slots.of_client;
        let full = state.held.iter().filter(|(_, held)| **held >= most);
        let full: HashSet<Share> = full.map(|(client, _)| *client).collect();
        move |waiting| (room || waiting.length == Length::Short) && !full.contains(&waiting.client)
    }

    /// The next job for a seat; `last` is the job that it has run.
    pub(super) fn next(&self, last: Option<(Flow, Turn)>) -> Option<Begun> {
        let mut state = self.lock();
        if let Some((flow, turn)) = last {
            state = self.end(state, &flow, &turn);
        }
        loop {
            if let Some(begun) = self.take(&mut state) {
                return Some(begun);
            }
            if state.closed && state.jobs.len() == 0 {
                // The other seats wait for work that this one may just have ended.
                self.arrived.notify_all();
                return None;
            }
            state.idle += 1;
            state = self
                .arrived
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
            state.idle -= 1;
        }
    }

    /// Counts a job that has run and gives its slot back, after a moment in which
    /// the same session may bring the next one.
    fn end<'a>(
        &self,
        mut state: MutexGuard<'a, Backlog>,
        flow: &Flow,
        turn: &Turn,
    ) -> MutexGuard<'a, Backlog> {
        let Some(slot) = turn.slot else {
            return state;
        };
        state
            .jobs
            .finished(flow, turn.since.elapsed().as_secs_f64());
        state.release(flow, turn.length);
        let awaited =
            |state: &mut Backlog| !state.closed && state.jobs.would_be_next(flow, self.may(state));
        let waited = self.arrived.wait_timeout_while(state, LINGER, awaited);
        state = waited.unwrap_or_else(PoisonError::into_inner).0;
        state.free.push(slot);
        state
    }

    /// Takes what is next while there is a slot: jobs that paused go on by
    /// themselves, the first other one is returned.
    fn take(&self, state: &mut Backlog) -> Option<Begun> {
        while !state.free.is_empty() {
            let (path, waiting) = state.jobs.pop(self.may(state))?;
            let slot = state.free.pop()?;
            self.metrics.queue_depth(state.jobs.len());
            state.occupy(waiting.client, waiting.length);
            match (waiting.work, Flow::try_from(path)) {
                (Work::Resume(ticket), _) => {
                    state.resumed.insert(ticket, slot);
                    self.arrived.notify_all();
                }
                (Work::Begin(job), Ok(flow)) => {
                    self.metrics.job_started(waiting.since.elapsed());
                    let turn = Turn {
                        slot: Some(slot),
                        since: Instant::now(),
                        ran: Duration::ZERO,
                        length: waiting.length,
                    };
                    return Some(Begun { flow, job, turn });
                }
                // Every job was pushed with a flow.
                (Work::Begin(_), Err(_)) => state.free.push(slot),
            }
        }
        None
    }

    pub(super) fn job_ended(&self) {
        self.metrics.job_ended();
    }

    /// See [`super::Slot::pause`].
    pub(super) fn pause(
        this: &Arc<Self>,
        flow: &Flow,
        turn: &mut Turn,
        stopped: &dyn Fn() -> bool,
    ) -> Duration {
        let mut state = this.lock();
        let ran = turn.since.elapsed();
        state.jobs.finished(flow, ran.as_secs_f64());
        state.release(flow, turn.length);
        turn.ran += ran;
        turn.since = Instant::now();
        if turn.ran >= LONG {
            turn.length = Length::Long;
        }
        let fits = turn.length == Length::Short || state.long < this.most_long();
        let is_next = fits && !state.jobs.comes_before(flow, this.may(&state));
        if is_next || !Self::has_seat(this, &mut state) {
            state.jobs.started(flow);
            state.occupy(client_of(flow), turn.length);
            return Duration::ZERO;
        }
        this.wait_for_slot(state, flow, turn, stopped);
        let paused = turn.since.elapsed();
        turn.since = Instant::now();
        paused
    }

    /// Gives the slot of `turn` away and waits for another one.
    fn wait_for_slot(
        &self,
        mut state: MutexGuard<'_, Backlog>,
        flow: &Flow,
        turn: &mut Turn,
        stopped: &dyn Fn() -> bool,
    ) {
        let ticket = state.tickets;
        state.tickets += 1;
        let waiting = Waiting {
            work: Work::Resume(ticket),
            since: Instant::now(),
            length: turn.length,
            client: client_of(flow),
        };
        state.jobs.push_front(flow, waiting);
        if let Some(slot) = turn.slot.take() {
            self.show_residual(slot, 0.0);
            state.free.push(slot);
        }
        self.metrics.paused();
        self.arrived.notify_all();
        loop {
            turn.slot = state.resumed.remove(&ticket);
            if turn.slot.is_some() {
                break;
            }
            if stopped() {
                // It ends within an iteration; that needs no slot.
                let own =
                    |one: &Waiting| matches!(one.work, Work::Resume(number) if number == ticket);
                state.jobs.remove(flow, own);
                // It may have been what kept seats of a closed queue waiting.
                self.arrived.notify_all();
                break;
            }
            let waited = self.arrived.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        self.metrics.resumed();
    }
}
