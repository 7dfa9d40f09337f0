//! Whose turn it is: no step of one client keeps those of others waiting, and none
//! runs for ever.

mod common;

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use common::{Block, Server, Stream, open, page, press, sample};
use signorini_proto::v1 as wire;
use signorini_server::Config;

/// Points of failure belong to the whole process.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes every iteration of every solve slow until it is dropped.
struct Slow;

impl Slow {
    fn new(milliseconds: u32) -> Self {
        fail::cfg("iteration", &format!("sleep({milliseconds})")).unwrap();
        Self
    }
}

impl Drop for Slow {
    fn drop(&mut self) {
        fail::remove("iteration");
    }
}

fn config() -> Config {
    Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    }
}

async fn pauses(server: &Server) -> u64 {
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    sample(&page, "signorini_slot_pauses_total")
}

/// A session of a connection of its own.
async fn session(server: &Server, block: &Block) -> (Server, Stream) {
    let own = Server::beside(&server.url).await;
    let name = own.session(block.scene()).await;
    let stream = own.open(open(&name)).await;
    (own, stream)
}

fn bits(finished: &wire::StepFinished) -> Vec<u64> {
    let report = finished.report.as_ref().unwrap();
    let force = report.obstacles["ball"].force.iter();
    force.map(|value| value.to_bits()).collect()
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn a_step_that_gives_its_slot_away_ends_with_the_same_bits() {
    let _alone = alone();
    let one = Config {
        solver_slots: 1,
        ..config()
    };
    let (server, block) = (Server::with(one).await, Block::new(2));
    server.upload(&block).await;
    let (_undisturbed, mut stream) = session(&server, &block).await;
    stream.step(1, press(0.04, 1)).await;
    let wanted = bits(&stream.result().await);
    assert_eq!(pauses(&server).await, 0);

    let _slow = Slow::new(30);
    let (_first, mut disturbed) = session(&server, &block).await;
    let (_second, mut other) = session(&server, &block).await;
    disturbed.step(1, press(0.04, 1)).await;
    other.step(1, press(0.01, 1)).await;
    assert_eq!(bits(&disturbed.result().await), wanted);
    other.result().await;
    assert!(pauses(&server).await > 0);
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn three_endless_steps_of_one_client_let_the_update_of_another_pass() {
    let _alone = alone();
    let (server, block) = (Server::with(config()).await, Block::new(2));
    server.upload(&block).await;
    let bad = Server::beside(&server.url).await;
    let _slow = Slow::new(20);
    let mut endless = Vec::new();
    for _ in 0..3 {
        let name = bad.session(block.scene()).await;
        let stream = bad.open(open(&name)).await;
        stream.step(1, press(0.04, 1000)).await;
        endless.push((name, stream));
    }
    tokio::time::sleep(Duration::from_secs(2)).await;
    let (_good, mut stream) = session(&server, &block).await;
    let asked = Instant::now();
    stream.press(1, 0.01).await;
    let report = stream.result().await.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
    // Alone it takes some thirty iterations of 20 ms.
    let took = asked.elapsed();
    assert!(took < Duration::from_secs(10), "{took:?}");
    for (name, _) in &endless {
        let described = server.describe(name).await;
        assert_eq!(described.last_finished_sequence, 0, "{name}");
        assert_eq!(server.cancel(name).await, 1);
    }
    for (_, mut stream) in endless {
        while !stream.result().await.last {}
    }
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn a_step_ends_with_its_last_good_state_when_it_had_a_slot_as_long_as_any_may() {
    let _alone = alone();
    let short = Config {
        maximum_step_seconds: 1,
        ..config()
    };
    let (server, block) = (Server::with(short).await, Block::new(2));
    server.upload(&block).await;
    let (_own, mut stream) = session(&server, &block).await;
    stream.press(1, 0.01).await;
    let good = bits(&stream.result().await);
    let slow = Slow::new(300);
    stream.press(2, 0.04).await;
    let finished = stream.result().await;
    assert_eq!(bits(&finished), good);
    let report = finished.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::DeadlineExceeded);
    assert_eq!(report.cause(), wire::Cause::ServerTimeLimit);
    drop(slow);
    stream.press(3, 0.04).await;
    let report = stream.result().await.report.unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
    assert_eq!(report.cause(), wire::Cause::Unspecified);
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    let series = "signorini_failures_total{cause=\"server_time_limit\"}";
    assert_eq!(sample(&page, series), 1);
}

/// Sends a long update on a connection that leaves then; whether it was accepted.
async fn abandon(server: &Server, name: &str) -> bool {
    let own = Server::beside(&server.url).await;
    let mut stream = own.open(open(name)).await;
    stream.step(1, press(0.04, 1000)).await;
    loop {
        if own.describe(name).await.last_accepted_sequence == 1 {
            return true;
        }
        let wait = Duration::from_millis(20);
        if let Ok(rejected) = tokio::time::timeout(wait, stream.rejection()).await {
            assert_eq!(rejected.sequence, 1);
            return false;
        }
    }
}

/// A session, as soon as what the sessions before it prepare leaves a place in the queue.
async fn opened(server: &Server, block: &Block) -> String {
    loop {
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            ..Default::default()
        };
        match server.sessions().create_session(request).await {
            Ok(response) => return response.into_inner().session.unwrap().name,
            Err(status) => assert_eq!(status.code(), tonic::Code::ResourceExhausted),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// Sessions of one connection, before anything runs.
async fn sessions(server: &Server, block: &Block, count: usize) -> Vec<String> {
    server.upload(block).await;
    let mut names = Vec::new();
    for _ in 0..count {
        names.push(opened(server, block).await);
    }
    names
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn what_waits_is_counted_by_client_over_all_its_connections() {
    let _alone = alone();
    let few = Config {
        solver_slots: 1,
        maximum_queued: 4,
        ..config()
    };
    let (server, block) = (Server::with(few).await, Block::new(2));
    let names = sessions(&server, &block, 12).await;
    let _slow = Slow::new(100);
    let mut accepted = 0;
    for name in &names {
        accepted += u32::from(abandon(&server, name).await);
    }
    // One has the slot or gives it back just now, four wait.
    assert!((4..=6).contains(&accepted), "{accepted}");
}

#[tokio::test]
#[allow(clippy::await_holding_lock, reason = "one test at a time")]
async fn work_that_nobody_waits_for_has_one_share_beside_those_who_wait() {
    let _alone = alone();
    let one = Config {
        solver_slots: 1,
        ..config()
    };
    let (server, block) = (Server::with(one).await, Block::new(2));
    let names = sessions(&server, &block, 12).await;
    let _slow = Slow::new(20);
    for name in &names {
        assert!(abandon(&server, name).await);
    }
    let (_own, mut stream) = session(&server, &block).await;
    stream.press(1, 0.01).await;
    stream.result().await;
    let iterations = async || {
        let page = page(server.metrics_url.as_ref().unwrap()).await;
        sample(&page, "signorini_iterations_total")
    };
    let before = iterations().await;
    let mut own = 0;
    for sequence in 2..5 {
        stream.press(sequence, 0.01 * sequence as f64).await;
        let report = stream.result().await.report.unwrap();
        own += u64::try_from(report.krylov_iterations).unwrap();
    }
    let all = iterations().await - before;
    // Half and half; a thirteenth with a share for each that is left behind.
    assert!(3 * own >= all, "{own} of {all}");
}
