use std::sync::mpsc;
use std::time::Instant;

use super::*;
use crate::door::client_key::{ClientIdentity, ClientKey, Strand};

const WAIT: Duration = Duration::from_secs(20);

fn slots(count: usize, short: usize, threads: usize) -> SolverThreads {
    started(Slots {
        count,
        short,
        of_client: count,
        threads,
    })
}

fn started(slots: Slots) -> SolverThreads {
    SolverThreads::start(slots, &Metrics::new().unwrap()).unwrap()
}

fn flow(user: u32, session: u64) -> Flow {
    let client = ClientKey {
        identity: ClientIdentity::User(user),
        strand: Strand::Unknown,
    };
    client.flow(session)
}

/// Submits a job and returns where its value comes.
fn start<T: Send + 'static>(
    solvers: &SolverThreads,
    flow: Flow,
    length: Length,
    work: impl FnOnce(&Slot) -> T + Send + 'static,
) -> mpsc::Receiver<Result<T, Panicked>> {
    let (sender, receiver) = mpsc::channel();
    let done = move |outcome| {
        // Whoever asked may have seen enough.
        drop(sender.send(outcome));
    };
    solvers.submit(flow, length, work, done);
    receiver
}

/// Works until `until` says so, pausing at every iteration; returns the pauses.
fn iterate(slot: &Slot, until: &dyn Fn() -> bool) -> Duration {
    let mut paused = Duration::ZERO;
    while !until() {
        std::thread::sleep(Duration::from_millis(2));
        paused += slot.pause(until);
    }
    paused
}

/// A job that works until the returned sender is used or dropped.
fn endless(
    solvers: &SolverThreads,
    flow: Flow,
) -> (mpsc::Sender<()>, mpsc::Receiver<Result<Duration, Panicked>>) {
    let (stop, stopped) = mpsc::channel();
    let stopped = Mutex::new(stopped);
    let is_over = move || {
        !matches!(
            stopped.lock().unwrap().try_recv(),
            Err(mpsc::TryRecvError::Empty)
        )
    };
    let job = start(solvers, flow, Length::Short, move |slot| {
        iterate(slot, &is_over)
    });
    (stop, job)
}

#[test]
fn a_panic_is_reported_and_the_slot_goes_on() {
    let solvers = slots(1, 0, 1);
    let broken = start(&solvers, flow(0, 0), Length::Short, |_| -> u32 {
        panic!("broken")
    });
    let whole = start(&solvers, flow(0, 0), Length::Short, |_| 7);
    assert_eq!(broken.recv().unwrap(), Err(Panicked("broken".into())));
    assert_eq!(whole.recv().unwrap(), Ok(7));
    solvers.close();
}

#[test]
fn jobs_run_in_the_pool_of_their_slot() {
    let solvers = slots(1, 0, 3);
    let threads = start(&solvers, flow(0, 0), Length::Short, |_| {
        rayon::current_num_threads()
    });
    assert_eq!(threads.recv().unwrap(), Ok(3));
    solvers.close();
}

#[test]
fn a_job_without_end_lets_those_of_others_pass_and_goes_on() {
    let solvers = slots(1, 0, 1);
    let (stop, endless) = endless(&solvers, flow(1, 1));
    for number in 0..5 {
        let short = start(&solvers, flow(2, 2), Length::Short, move |_| number);
        assert_eq!(short.recv_timeout(WAIT).unwrap(), Ok(number));
    }
    drop(stop);
    let paused = endless.recv_timeout(WAIT).unwrap().unwrap();
    assert!(paused > Duration::ZERO);
    solvers.close();
}

#[test]
fn two_jobs_without_end_share_the_slot_for_long_work_and_the_other_stays_free() {
    let solvers = slots(2, 1, 1);
    let all: Vec<_> = (1..=2)
        .map(|session| endless(&solvers, flow(1, session)))
        .collect();
    std::thread::sleep(3 * LONG);
    // This one never pauses, so nobody would have made room for it.
    let asked = Instant::now();
    let short = start(&solvers, flow(1, 3), Length::Short, |_| Instant::now());
    let begun = short.recv_timeout(WAIT).unwrap().unwrap();
    assert!(begun - asked < LONG, "{:?}", begun - asked);
    let long = start(&solvers, flow(1, 4), Length::Long, |_| ());
    long.recv_timeout(WAIT).unwrap().unwrap();
    for (stop, job) in all {
        drop(stop);
        assert!(job.recv_timeout(WAIT).unwrap().unwrap() > Duration::ZERO);
    }
    solvers.close();
}

#[test]
fn a_job_that_is_stopped_while_it_pauses_ends_without_a_slot() {
    let solvers = slots(1, 0, 1);
    let (stop, paused) = endless(&solvers, flow(1, 1));
    let (release, released) = mpsc::channel::<()>();
    let (entered, has_entered) = mpsc::channel();
    let blocking = start(&solvers, flow(2, 2), Length::Short, move |_| {
        entered.send(()).unwrap();
        released.recv().unwrap_err();
    });
    has_entered.recv_timeout(WAIT).unwrap();
    drop(stop);
    paused.recv_timeout(WAIT).unwrap().unwrap();
    drop(release);
    blocking.recv_timeout(WAIT).unwrap().unwrap();
    solvers.close();
}

#[test]
fn a_paused_job_that_is_stopped_at_the_end_leaves_no_seat_waiting() {
    let solvers = Arc::new(slots(1, 0, 1));
    let (stop, paused) = endless(&solvers, flow(1, 1));
    let (stop_other, other) = endless(&solvers, flow(3, 3));
    let (release, released) = mpsc::channel::<()>();
    let (entered, has_entered) = mpsc::channel();
    let blocking = start(&solvers, flow(2, 2), Length::Short, move |_| {
        entered.send(()).unwrap();
        released.recv().unwrap_err();
    });
    has_entered.recv_timeout(WAIT).unwrap();
    // Its seat has nothing to do from here on.
    drop(stop_other);
    other.recv_timeout(WAIT).unwrap().unwrap();
    let (closed, has_closed) = mpsc::channel();
    let closing = Arc::clone(&solvers);
    let seats = solvers.queue.lock().threads.len();
    std::thread::spawn(move || {
        closing.close();
        closed.send(()).unwrap();
    });
    // It waits for the first of its threads once everybody has been told.
    while solvers.queue.lock().threads.len() == seats {
        std::thread::yield_now();
    }
    drop(stop);
    paused.recv_timeout(WAIT).unwrap().unwrap();
    drop(release);
    blocking.recv_timeout(WAIT).unwrap().unwrap();
    has_closed.recv_timeout(WAIT).unwrap();
}

#[test]
fn a_client_has_no_more_slots_than_it_may_and_others_have_the_rest() {
    let solvers = started(Slots {
        count: 2,
        short: 0,
        of_client: 1,
        threads: 1,
    });
    let (release, released) = mpsc::channel::<()>();
    let (entered, has_entered) = mpsc::channel();
    let first = start(&solvers, flow(1, 1), Length::Short, move |_| {
        entered.send(()).unwrap();
        released.recv().unwrap_err();
        Instant::now()
    });
    has_entered.recv_timeout(WAIT).unwrap();
    let second = start(&solvers, flow(1, 2), Length::Short, |_| Instant::now());
    // After that of the greedy one, and before it all the same.
    let other = start(&solvers, flow(2, 3), Length::Short, |_| ());
    other.recv_timeout(WAIT).unwrap().unwrap();
    drop(release);
    let ended = first.recv_timeout(WAIT).unwrap().unwrap();
    assert!(second.recv_timeout(WAIT).unwrap().unwrap() >= ended);
    solvers.close();
}
