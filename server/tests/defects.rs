//! Defects inside a solve, made on purpose: the step fails, session and server live.

mod common;

use std::sync::mpsc;
use std::sync::{Mutex, MutexGuard, PoisonError};

use common::{Block, Server, Stream, open, press};
use signorini_proto::v1 as wire;
use signorini_server::Config;

/// Points of failure belong to the whole process.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn bits(report: &wire::StepReport) -> Vec<u64> {
    let force = report.obstacles["ball"].force.iter();
    force.map(|value| value.to_bits()).collect()
}

/// A server with one slot, and a session on it that is pressed to 0.02.
async fn pressed() -> (Server, String, Stream, wire::StepReport) {
    let config = Config {
        solver_slots: 1,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 1)).await;
    let good = stream.result().await.report.unwrap();
    assert_eq!(good.termination(), wire::Termination::Converged);
    (server, session, stream, good)
}

/// The result of step 2 ended as said, with the state of step 1.
fn assert_ended(finished: &wire::StepFinished, good: &wire::StepReport, ending: wire::Termination) {
    let report = finished.report.as_ref().unwrap();
    assert_eq!((finished.sequence, finished.last), (2, true));
    assert_eq!(report.termination(), ending);
    assert_eq!(bits(report), bits(good));
}

/// Results of a step that names nothing, and of a deeper one behind it.
async fn onwards(stream: &mut Stream) -> [Vec<u64>; 2] {
    stream.step(3, wire::LoadStep::default()).await;
    let same = stream.result().await.report.unwrap();
    stream.step(4, press(0.04, 1)).await;
    let deeper = stream.result().await.report.unwrap();
    for report in [&same, &deeper] {
        assert_eq!(report.termination(), wire::Termination::Converged);
    }
    [bits(&same), bits(&deeper)]
}

/// Holds every solver thread at its next iteration until it is dropped.
struct Barrier {
    reached: Option<mpsc::Receiver<()>>,
    _release: mpsc::Sender<()>,
}

impl Barrier {
    fn new() -> Self {
        let (entered, reached) = mpsc::channel();
        let (release, released) = mpsc::channel::<()>();
        let (entered, released) = (Mutex::new(entered), Mutex::new(released));
        fail::cfg_callback("iteration", move || {
            // The test may have seen enough.
            entered.lock().unwrap().send(()).ok();
            released.lock().unwrap().recv().ok();
        })
        .unwrap();
        Self {
            reached: Some(reached),
            _release: release,
        }
    }

    /// Returns when a solver thread is held.
    async fn reached(&mut self) {
        let reached = self.reached.take().unwrap();
        let wait = move || reached.recv().unwrap();
        tokio::task::spawn_blocking(wait).await.unwrap();
    }
}

impl Drop for Barrier {
    fn drop(&mut self) {
        fail::remove("iteration");
    }
}

async fn after_a_cancel_while_it_waits() -> [Vec<u64>; 2] {
    let (server, session, mut stream, good) = pressed().await;
    let mut barrier = Barrier::new();
    let other = server.session(Block::new(2).scene()).await;
    let blocker = server.open(open(&other)).await;
    blocker.step(1, press(0.01, 1)).await;
    barrier.reached().await;
    stream.step(2, press(0.05, 1)).await;
    while server.cancel(&session).await != 2 {}
    assert_ended(&stream.result().await, &good, wire::Termination::Cancelled);
    drop(barrier);
    onwards(&mut stream).await
}

async fn after_a_cancel_that_the_thread_does_not_see() -> [Vec<u64>; 2] {
    let (server, session, mut stream, good) = pressed().await;
    let mut barrier = Barrier::new();
    stream.step(2, press(0.05, 1)).await;
    barrier.reached().await;
    assert_eq!(server.cancel(&session).await, 2);
    // The thread is held: the answer comes without it.
    assert_ended(&stream.result().await, &good, wire::Termination::Cancelled);
    drop(barrier);
    onwards(&mut stream).await
}

async fn after_a_panic() -> [Vec<u64>; 2] {
    let (_server, _, mut stream, good) = pressed().await;
    fail::cfg("iteration", "5*off->1*panic(on purpose)").unwrap();
    stream.step(2, press(0.05, 1)).await;
    let finished = stream.result().await;
    fail::remove("iteration");
    assert_ended(&finished, &good, wire::Termination::InternalError);
    onwards(&mut stream).await
}

async fn after_memory_was_refused() -> [Vec<u64>; 2] {
    let (_server, _, mut stream, good) = pressed().await;
    fail::cfg("memory", "return").unwrap();
    stream.step(2, press(0.05, 2)).await;
    let finished = stream.result().await;
    fail::remove("memory");
    assert_ended(&finished, &good, wire::Termination::InternalError);
    onwards(&mut stream).await
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn no_later_bit_depends_on_how_and_when_a_step_was_stopped() {
    let _alone = alone();
    let waiting = after_a_cancel_while_it_waits().await;
    assert_eq!(after_a_cancel_that_the_thread_does_not_see().await, waiting);
    assert_eq!(after_a_panic().await, waiting);
    assert_eq!(after_memory_was_refused().await, waiting);
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn a_step_that_is_left_behind_keeps_its_slot_until_its_thread_is_done() {
    let _alone = alone();
    let (server, session, mut stream, _) = pressed().await;
    let mut barrier = Barrier::new();
    stream.step(2, press(0.05, 1)).await;
    barrier.reached().await;
    server.cancel(&session).await;
    stream.result().await;
    let request = wire::DeleteSessionRequest { name: session };
    server.sessions().delete_session(request).await.unwrap();
    let other = server.session(Block::new(2).scene()).await;
    let mut next = server.open(open(&other)).await;
    next.step(1, press(0.01, 1)).await;
    drop(barrier);
    let report = next.result().await.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
}
