//! Streams over connections that break.
#![cfg(feature = "embedded")]

use std::time::Duration;

use crate::common::proxy::Proxy;
use crate::common::server::{Server, connect, load, lowered, reason, result, session};
use prost::Message as _;
use signorini_client::solve::{Attach, Event, Events, Increment, Solve, WatchOptions};
use signorini_client::{Client, ClientError, NewSession};
use signorini_proto::v1;

const FIELDS: [v1::FieldName; 3] = [
    v1::FieldName::Displacement,
    v1::FieldName::Pressure,
    v1::FieldName::ContactPressure,
];
const INCREMENTS: i32 = 4;
const MOVES: i32 = 8;
/// A result that is lost would be waited for without an end.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// A session of its own on the server that keeps fields.
async fn session_with_fields(client: &Client, id: &str) -> v1::Session {
    let (mut scene, mesh) = load("hertz-plane.toml");
    client.upload_mesh(mesh).await.unwrap();
    scene.output.get_or_insert_default().fields = FIELDS.map(i32::from).to_vec();
    scene.steps[0].increments = Some(INCREMENTS);
    let new = NewSession {
        scene,
        session_id: id.to_owned(),
        ..Default::default()
    };
    client.create_session(new).await.unwrap().0
}

/// Sends a load step and many moves at once.
async fn send_all(solve: &mut Solve) {
    let (scene, _) = load("hertz-plane.toml");
    let step = v1::LoadStep {
        increments: Some(INCREMENTS),
        ..scene.steps[0].clone()
    };
    solve.updates.load_step(step).await.unwrap();
    for index in 1..=MOVES {
        let depth = 0.05 + 1e-3 * f64::from(index);
        solve.updates.obstacle_update(lowered(depth)).await.unwrap();
    }
}

/// What a result says, without the time that it took and what the session shares.
fn content(mut increment: Increment) -> Increment {
    increment.report = v1::StepReport {
        seconds: None,
        memory_bytes: 0,
        reused: Vec::new(),
        factorisations: 0,
        eigenvalue_applications: 0,
        compliance_columns: 0,
        ..increment.report
    };
    increment
}

/// The bits of everything in a result.
fn bits(increment: &Increment) -> (Vec<u8>, Vec<Vec<u64>>) {
    let fields = increment.fields.iter();
    let values = fields.map(|field| field.values.iter().map(|value| value.to_bits()).collect());
    (increment.report.encode_to_vec(), values.collect())
}

/// Everything up to the last result, and how often the connection was replaced.
async fn all(events: &mut Events, after: impl FnMut(usize)) -> (Vec<Increment>, usize) {
    let gathered = tokio::time::timeout(LONGEST_WAIT, gather(events, after)).await;
    gathered.expect("all results")
}

async fn gather(events: &mut Events, mut after: impl FnMut(usize)) -> (Vec<Increment>, usize) {
    let count = (INCREMENTS + MOVES) as usize;
    let (mut results, mut reconnected) = (Vec::new(), 0);
    while results.len() < count {
        match events.next().await.unwrap().unwrap() {
            Event::Increment(increment) => {
                results.push(content(*increment));
                after(results.len());
            }
            Event::Reconnected { attempts } => {
                assert!(attempts >= 1);
                reconnected += 1;
            }
            Event::Iteration(_) | Event::Heartbeat(_) | Event::ConnectionLost { .. } => {}
            Event::Rejected { refusal, .. } => unreachable!("{refusal}"),
        }
    }
    (results, reconnected)
}

fn assert_gapless(results: &[Increment]) {
    let events: Vec<i64> = results.iter().map(|result| result.event).collect();
    assert_eq!(events, (1..=results.len() as i64).collect::<Vec<_>>());
    let last: Vec<i64> = results
        .iter()
        .filter(|result| result.last)
        .map(|result| result.sequence)
        .collect();
    assert_eq!(last, (1..=i64::from(MOVES) + 1).collect::<Vec<_>>());
}

/// Takes what is left of a stream that ends well.
async fn assert_no_result_follows(events: &mut Events) {
    while let Some(event) = events.next().await.unwrap() {
        assert!(!matches!(event, Event::Increment(_)), "{event:?}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_whose_connection_breaks_misses_nothing_and_computes_nothing_twice() {
    let server = Server::start().await;
    let straight = session_with_fields(&server.client, "straight").await;
    let attach = Attach::default();
    let mut solve = server.client.solve(&straight.name, attach).await.unwrap();
    send_all(&mut solve).await;
    let (expected, _) = all(&mut solve.events, |_| {}).await;
    assert_gapless(&expected);

    let proxy = Proxy::start(&server.url).await;
    let client = connect(&proxy.url).await;
    let broken = session_with_fields(&client, "broken").await;
    let mut solve = client.solve(&broken.name, Attach::default()).await.unwrap();
    // Before the updates are there, inside of fields, while connecting, and
    // between results.
    proxy.cut();
    proxy.cut_after(&[70_000, 3, 150_001, 61_000, 90_000]);
    send_all(&mut solve).await;
    let (results, reconnected) = all(&mut solve.events, |count| {
        if [1, 2, 7, 9].contains(&count) {
            proxy.cut();
        }
    })
    .await;
    assert_gapless(&results);
    assert!(reconnected >= 4, "{reconnected} breaks");
    assert!(
        results
            .iter()
            .all(|result| result.fields.len() == FIELDS.len())
    );
    for (result, expected) in results.iter().zip(&expected) {
        assert_eq!(result.report, expected.report);
        assert!(bits(result) == bits(expected), "result {}", result.event);
    }
    let session = server.client.get_session("broken").await.unwrap();
    let moves = i64::from(MOVES);
    assert_eq!(session.last_finished_sequence, 1 + moves);
    // Nothing more comes, and no update ran a second time.
    drop(solve.updates);
    assert_no_result_follows(&mut solve.events).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancel_is_not_lost_with_its_connection() {
    let server = Server::start().await;
    let proxy = Proxy::start(&server.url).await;
    let client = connect(&proxy.url).await;
    let (session, mut steps) = session(&server, "hertz-plane.toml").await;
    steps[0].increments = Some(100_000);
    let mut solve = client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    result(&mut solve.events).await;
    proxy.close();
    solve.updates.canceller().cancel(0).await.unwrap();
    proxy.open();
    let mut last = result(&mut solve.events).await;
    while !last.last {
        last = result(&mut solve.events).await;
    }
    assert_eq!(last.report.termination(), v1::Termination::Cancelled);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_that_another_client_holds_meanwhile_is_waited_for() {
    let server = Server::start().await;
    let proxy = Proxy::start(&server.url).await;
    let client = connect(&proxy.url).await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let mut first = client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    proxy.close();
    // The server notices the break in its own time.
    let second = loop {
        let attach = Attach::default();
        match server.client.solve(&session.name, attach).await {
            Ok(solve) => break solve,
            Err(error) => assert_eq!(reason(&error), "SESSION_BUSY"),
        }
    };
    proxy.open();
    first.updates.load_step(steps[0].clone()).await.unwrap();
    drop(second);
    let increment = result(&mut first.events).await;
    assert_eq!((increment.sequence, increment.event), (1, 1));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn patience_ends_and_without_any_the_first_break_is_an_error() {
    let server = Server::start().await;
    let proxy = Proxy::start(&server.url).await;
    let client = connect(&proxy.url).await;
    let (session, _) = session(&server, "hertz-plane.toml").await;
    for (patience, told) in [(Duration::ZERO, 0), (Duration::from_millis(200), 1)] {
        proxy.open();
        let attach = Attach {
            patience,
            ..Default::default()
        };
        let mut solve = loop {
            match client.solve(&session.name, attach.clone()).await {
                Ok(solve) => break solve,
                Err(error) => assert!(
                    matches!(
                        error,
                        ClientError::Refused(_) | ClientError::Unreachable { .. }
                    ),
                    "{error:?}"
                ),
            }
        };
        proxy.close();
        let mut lost = 0;
        let error = loop {
            match solve.events.next().await {
                Ok(event) => {
                    lost += usize::from(matches!(event, Some(Event::ConnectionLost { .. })))
                }
                Err(error) => break error,
            }
        };
        assert_eq!(lost, told);
        assert!(
            matches!(
                error,
                ClientError::Broken { .. } | ClientError::Unreachable { .. }
            ),
            "{error:?}"
        );
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_service_says_is_not_tried_again() {
    let server = Server::start().await;
    let (session, _) = session(&server, "hertz-plane.toml").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    server.client.delete_session(&session.name).await.unwrap();
    let error = solve.events.next().await.unwrap_err();
    assert_eq!(reason(&error), "SESSION_DELETED");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watcher_sees_every_result_over_breaks_and_ends_when_all_are_there() {
    let server = Server::start().await;
    let proxy = Proxy::start(&server.url).await;
    let client = connect(&proxy.url).await;
    let session = session_with_fields(&server.client, "watched").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    send_all(&mut solve).await;
    result(&mut solve.events).await;
    let options = WatchOptions {
        until: v1::WatchEnd::Idle,
        ..Default::default()
    };
    // Inside of the second result, and further on.
    proxy.cut_after(&[100_000, 150_000]);
    let mut watch = client.watch(&session.name, options).await.unwrap();
    let (results, reconnected) = all(&mut watch.events, |_| {}).await;
    assert_gapless(&results);
    assert!(reconnected >= 2, "{reconnected} breaks");
    assert_no_result_follows(&mut watch.events).await;
    // The same results again, one call a step.
    let read = client.read_step("watched", 1, &[]).await.unwrap();
    let read: Vec<Increment> = read.into_iter().map(content).collect();
    assert!(read == results[..INCREMENTS as usize]);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stored_mesh_is_read_back_as_it_was_sent() {
    let server = Server::start().await;
    let (_, mesh) = load("hertz-plane.toml");
    let uploaded = server.client.upload_mesh(mesh.clone()).await.unwrap();
    let read = server.client.read_mesh(&uploaded.mesh.name).await.unwrap();
    let path = crate::common::example("meshes/hemi_l2.msh");
    let file = signorini_client::formats::msh::read(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(
        (read.coordinates, read.cells),
        (file.coordinates, file.cells)
    );
    assert_eq!(
        (read.facets.len(), read.groups.len()),
        (file.facets.len(), file.groups.len())
    );
    let error = server.client.read_mesh(&"0".repeat(64)).await.unwrap_err();
    assert_eq!(reason(&error), "MESH_NOT_FOUND");
    server.stop().await;
}
