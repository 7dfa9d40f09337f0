//! Defects inside a solve, made on purpose: the step fails, session and server live.

mod common;

use std::sync::mpsc;
use std::sync::{Mutex, PoisonError};

use common::{Block, Server, open, press};
use signorini_proto::v1 as wire;
use signorini_server::Config;

/// Points of failure belong to the whole process.
static ALONE: Mutex<()> = Mutex::new(());

async fn force_after(server: &Server, session: &str, steps: &[(i64, f64)]) -> Vec<u64> {
    let mut stream = server.open(open(session)).await;
    let mut force = Vec::new();
    for (sequence, depth) in steps {
        stream.step(*sequence, press(*depth, 1)).await;
        let report = stream.result().await.report.unwrap();
        assert_eq!(report.termination(), wire::Termination::Converged);
        let found = report.obstacles["ball"].force.iter();
        force = found.map(|value| value.to_bits()).collect();
    }
    force
}

async fn started() -> (Server, Block, String) {
    let config = Config {
        solver_slots: 1,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    (server, block, session)
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn a_panic_inside_a_step_fails_that_step_and_the_session_lives() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (server, block, session) = started().await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 1)).await;
    let good = stream.result().await.report.unwrap();
    fail::cfg("increment", "1*panic(on purpose)").unwrap();
    stream.step(2, press(0.03, 1)).await;
    let failed = stream.result().await;
    fail::remove("increment");
    assert!(failed.last);
    let report = failed.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::InternalError);
    assert_eq!(report.obstacles["ball"].force, good.obstacles["ball"].force);
    stream.step(3, press(0.04, 1)).await;
    let next = stream.result().await.report.unwrap();
    assert_eq!(next.termination(), wire::Termination::Converged);
    // The session went back to the state of step 1 and forgot what led there.
    let other = server.session(block.scene()).await;
    let straight = force_after(&server, &other, &[(1, 0.02), (2, 0.04)]).await;
    for (one, other) in next.obstacles["ball"].force.iter().zip(straight) {
        assert!((one - f64::from_bits(other)).abs() < 1e-7);
    }
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn memory_that_the_system_refuses_fails_the_step_and_the_session_lives() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (server, _, session) = started().await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 1)).await;
    let good = stream.result().await.report.unwrap();
    fail::cfg("memory", "return").unwrap();
    stream.step(2, press(0.03, 2)).await;
    let failed = stream.result().await;
    fail::remove("memory");
    assert!(failed.last);
    let report = failed.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::InternalError);
    assert_eq!(report.obstacles["ball"].force, good.obstacles["ball"].force);
    stream.step(3, press(0.04, 1)).await;
    let next = stream.result().await.report.unwrap();
    assert_eq!(next.termination(), wire::Termination::Converged);
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn a_step_whose_solver_thread_does_not_stop_is_answered_without_it() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (server, _, session) = started().await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 1)).await;
    let good = stream.result().await.report.unwrap();
    let (entered, waiting) = mpsc::channel();
    let (release, released) = mpsc::channel::<()>();
    let (entered, released) = (Mutex::new(entered), Mutex::new(released));
    fail::cfg_callback("increment", move || {
        entered.lock().unwrap().send(()).unwrap();
        // Ends when the test lets go.
        released.lock().unwrap().recv().ok();
    })
    .unwrap();
    stream.step(2, press(0.05, 1)).await;
    tokio::task::spawn_blocking(move || waiting.recv().unwrap())
        .await
        .unwrap();
    assert_eq!(server.cancel(&session).await, 2);
    let finished = stream.result().await;
    let report = finished.report.unwrap();
    assert_eq!((finished.sequence, finished.last), (2, true));
    assert_eq!(report.termination(), wire::Termination::Cancelled);
    assert_eq!(report.obstacles["ball"].force, good.obstacles["ball"].force);
    fail::remove("increment");
    drop(release);
    // What the thread still did is undone: pressing as deep as before changes nothing.
    stream.step(3, press(0.02, 1)).await;
    let next = stream.result().await.report.unwrap();
    assert_eq!(next.termination(), wire::Termination::Converged);
    for (one, other) in next.obstacles["ball"]
        .force
        .iter()
        .zip(&good.obstacles["ball"].force)
    {
        assert!((one - other).abs() < 1e-7);
    }
}
