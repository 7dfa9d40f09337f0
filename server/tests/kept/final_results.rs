//! What a client has read stays as it was: through kills, cancels, exports and saves.

use std::time::Duration;

use crate::common::{
    Block, Process, Server, Stream, bare, folder, open, page, press, reason, sample,
};
use bytes::Bytes;
use prost::Message as _;
use redb::{Database, ReadableTable as _, TableDefinition};
use sha2::{Digest, Sha256};
use signorini_proto::v1::{self as wire, Termination};
use signorini_server::Config;
use tokio::time::timeout;

/// Increments of an update that ends before the server is killed.
const PARTS: i32 = 40;
/// Increments of the one that is cut.
const MANY: i32 = 200;
/// A client hears the end of an update within this time of readiness.
const SOON: Duration = Duration::from_secs(2);

fn seen(session: &str, event: i64) -> wire::SolveOpen {
    wire::SolveOpen {
        last_seen_event: Some(event),
        ..open(session)
    }
}

/// Results up to the last of an update.
async fn to_the_end(stream: &mut Stream) -> Vec<wire::StepFinished> {
    let mut results: Vec<wire::StepFinished> = Vec::new();
    while results.last().is_none_or(|one| !one.last) {
        let next = timeout(SOON, stream.result()).await;
        results.push(next.expect("the client hears the end of its update"));
    }
    results
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancel_right_after_a_restart_acts_behind_the_newest_result_that_was_read() {
    let mut process = Process::start(&folder("final-cancel"), "");
    let block = Block::new(4);
    process.connect().await.upload(&block).await;
    for read in [1, 4, 9] {
        let server = process.connect().await;
        let session = server.session(block.scene()).await;
        let mut stream = server.open(seen(&session, 0)).await;
        stream.step(1, press(0.05, MANY)).await;
        let mut results = Vec::new();
        for _ in 0..read {
            results.push(stream.result().await);
        }
        process.kill();
        process.restart();
        let server = process.connect().await;
        let mut stream = server.open(seen(&session, read)).await;
        assert_eq!(server.cancel(&session).await, 1);
        results.extend(to_the_end(&mut stream).await);
        let events: Vec<i64> = results.iter().map(|one| one.event).collect();
        assert_eq!(events, Vec::from_iter(1..=results.len() as i64));
        let last = results.last().and_then(|one| one.report.as_ref());
        let last = last.expect("a report").termination();
        assert!(
            matches!(last, Termination::Cancelled | Termination::Converged),
            "{last:?}"
        );
        // To the bit, its times included.
        for one in &results {
            let increment = one.report.as_ref().expect("a report").increment;
            let again = server.read(&session, 1, increment).await.0;
            assert_eq!(again, *one, "read {read}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancel_without_a_sequence_spares_an_update_whose_end_was_read() {
    let mut process = Process::start(&folder("final-zero"), "");
    let block = Block::new(4);
    process.connect().await.upload(&block).await;
    let server = process.connect().await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(seen(&session, 0)).await;
    for sequence in 1..=3 {
        let depth = 0.01 * sequence as f64;
        let parts = if sequence == 1 { PARTS } else { MANY };
        stream.step(sequence, press(depth, parts)).await;
    }
    let first = to_the_end(&mut stream).await;
    process.kill();
    process.restart();
    let server = process.connect().await;
    let mut stream = server.open(seen(&session, i64::from(PARTS))).await;
    assert!(server.cancel(&session).await > 1);
    let second = to_the_end(&mut stream).await;
    assert_eq!(second[0].event, i64::from(PARTS) + 1);
    for one in &first {
        let increment = one.report.as_ref().expect("a report").increment;
        assert_eq!(server.read(&session, 1, increment).await.0, *one);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_has_seen_more_than_there_is_is_told() {
    let server = Server::start().await;
    server.upload(&Block::new(1)).await;
    let session = server.session(Block::new(1).scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 1)).await;
    stream.result().await;
    drop(stream);
    let refused = loop {
        match server.try_open(seen(&session, 2)).await {
            Err(status) if reason(&status) == "SESSION_BUSY" => {}
            outcome => break outcome.err().expect("a refusal"),
        }
    };
    assert_eq!(refused.code(), tonic::Code::OutOfRange);
    assert_eq!(reason(&refused), "EVENT_NOT_FOUND");
    let request = wire::WatchRequest {
        last_seen_event: Some(2),
        ..crate::common::watch(&session, wire::WatchEnd::Idle)
    };
    let refused = match server.sessions().watch(request).await {
        Err(status) => status,
        Ok(call) => call.into_inner().message().await.unwrap_err(),
    };
    assert_eq!(reason(&refused), "EVENT_NOT_FOUND");
    assert!(server.try_open(seen(&session, 1)).await.is_ok());
}

/// What somebody does with the state between two steps.
#[derive(Clone, Copy)]
enum Look {
    Nothing,
    Exports,
    Saves,
}

/// Eight presses, after each of which somebody looks.
async fn looked_at(server: &Server, look: Look) -> Vec<wire::StepFinished> {
    server.upload(&Block::new(2)).await;
    let session = server.session(Block::new(2).scene()).await;
    let mut stream = server.open(open(&session)).await;
    let mut results = Vec::new();
    for sequence in 1..=8 {
        let depth = 0.01 + 0.003 * ((sequence * 5) % 7) as f64;
        stream.step(sequence, press(depth, 2)).await;
        results.extend(to_the_end(&mut stream).await.into_iter().map(bare));
        let name = session.clone();
        match look {
            Look::Nothing => {}
            Look::Exports => {
                let request = wire::ExportStateRequest { name };
                let call = server.sessions().export_state(request).await;
                let mut slices = call.expect("a state").into_inner();
                while slices.message().await.expect("a slice").is_some() {}
            }
            Look::Saves => {
                let request = wire::SaveStateRequest { name };
                let saved = server.sessions().save_state(request).await;
                saved.expect("a saved state");
            }
        }
    }
    results
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_exports_or_saves_changes_no_bit_of_what_follows() {
    let data = folder("final-looks").join("data");
    let kept = Config {
        data: data.to_str().expect("a name").to_owned(),
        ..Config::embedded()
    };
    for config in [Config::embedded(), kept] {
        let server = Server::with(config).await;
        let calm = looked_at(&server, Look::Nothing).await;
        for look in [Look::Exports, Look::Saves] {
            assert!(
                looked_at(&server, look).await == calm,
                "a look changes bits"
            );
        }
    }
}

/// A stored result, as the data folder has it.
#[derive(Clone, PartialEq, prost::Message)]
struct StoredResult {
    #[prost(int64, tag = "1")]
    sequence: i64,
    #[prost(bytes = "bytes", tag = "2")]
    report: Bytes,
    #[prost(bool, tag = "3")]
    last: bool,
    #[prost(bool, tag = "4")]
    is_due: bool,
    #[prost(int32, repeated, tag = "5")]
    asked: Vec<i32>,
    #[prost(uint64, tag = "6")]
    field_bytes: u64,
    #[prost(int64, tag = "7")]
    made: i64,
}

/// Says in the journal that the second result took an iteration more.
fn falsify(data: &std::path::Path, session: &str) {
    const RESULTS: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("results");
    let database = Database::open(data.join("journal.redb")).unwrap();
    let write = database.begin_write().unwrap();
    {
        let mut table = write.open_table(RESULTS).unwrap();
        let bytes = table
            .get((session, 2_i64))
            .unwrap()
            .unwrap()
            .value()
            .to_vec();
        let mut result = StoredResult::decode(&bytes[..bytes.len() - 8]).unwrap();
        let mut report = wire::StepReport::decode(result.report.clone()).unwrap();
        report.krylov_iterations += 1;
        result.report = report.encode_to_vec().into();
        let mut sealed = result.encode_to_vec();
        let seal = Sha256::digest(&sealed);
        sealed.extend(&seal[..8]);
        table.insert((session, 2_i64), sealed.as_slice()).unwrap();
    }
    write.commit().unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_that_a_replay_finds_otherwise_is_counted_and_stays_as_it_was_sent() {
    let data = folder("final-difference").join("data");
    let config = || Config {
        data: data.to_str().expect("a name").to_owned(),
        metrics_listen: "127.0.0.1:0".to_owned(),
        ..Config::embedded()
    };
    let mut server = Server::with(config()).await;
    server.upload(&Block::new(1)).await;
    let session = server.session(Block::new(1).scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 3)).await;
    to_the_end(&mut stream).await;
    drop(stream);
    server.signal_stop();
    server.stopped().await.unwrap();
    falsify(&data, &session);
    let server = Server::with(config()).await;
    while server.describe(&session).await.state() == wire::SessionState::Preparing {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let url = server.metrics_url.clone().expect("a page");
    let counted = sample(&page(&url).await, "signorini_replay_differences_total");
    assert_eq!(counted, 1);
    assert_eq!(server.read(&session, 1, 2).await.0.event, 2);
}
