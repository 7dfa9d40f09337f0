//! Behind a proxy whose servers come and go: calls are made again, streams go on, and every call
//! names its session.
#![cfg(feature = "embedded")]

use std::time::Duration;

use crate::common::gateway::{Gateway, Mishap};
use crate::common::server::{Server, connect, load, lowered, reason, result};
use signorini_client::solve::{Attach, Event, Solve};
use signorini_client::{ClientError, NewSession, session_id};

const PAGES: [Mishap; 4] = [
    Mishap::Page(502),
    Mishap::Page(503),
    Mishap::Page(504),
    Mishap::Cancel,
];

#[tokio::test(flavor = "multi_thread")]
async fn every_call_of_a_session_names_it_from_the_mesh_to_the_end() {
    let server = Server::start().await;
    let gateway = Gateway::start(&server.url).await;
    let client = connect(&gateway.url).await;
    let (scene, mesh) = load("hertz-plane.toml");
    let id = session_id();
    let own = client.of_session(&id);
    own.upload_mesh(mesh).await.unwrap();
    let new = NewSession {
        scene: scene.clone(),
        session_id: id.clone(),
        ..Default::default()
    };
    let (session, _) = client.create_session(new).await.unwrap();
    assert_eq!(session.name, format!("sessions/{id}"));
    let mut solve = client.solve(&id, Attach::default()).await.unwrap();
    solve
        .updates
        .load_step(scene.steps[0].clone())
        .await
        .unwrap();
    result(&mut solve.events).await;
    client.watch(&id, Default::default()).await.unwrap();
    client.read_step(&session.name, 1, &[]).await.unwrap();
    client.cancel_step(&id, 0).await.unwrap();
    client.get_session(&id).await.unwrap();
    client.delete_session(&id).await.unwrap();
    let calls = gateway.calls();
    let methods: Vec<&str> = calls.iter().map(|(method, _)| method.as_str()).collect();
    let expected = [
        "GetMesh",
        "UploadMesh",
        "CreateSession",
        "Solve",
        "Watch",
        "ReadStep",
        "CancelStep",
        "GetSession",
        "DeleteSession",
    ];
    assert_eq!(methods, expected);
    for (method, session) in calls {
        assert_eq!(session.as_deref(), Some(id.as_str()), "{method}");
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_page_or_a_cut_in_place_of_an_answer_is_no_answer() {
    let server = Server::start().await;
    let gateway = Gateway::start(&server.url).await;
    let client = connect(&gateway.url).await;
    let (scene, mesh) = load("hertz-plane.toml");
    gateway.expect(&PAGES);
    client.upload_mesh(mesh).await.unwrap();
    // The answer is lost, the session is made: it is made once.
    gateway.expect(&PAGES);
    let new = NewSession {
        scene,
        ..Default::default()
    };
    let (session, _) = client.create_session(new.clone()).await.unwrap();
    for _ in 0..2 {
        gateway.expect(&PAGES);
        client.get_session(&session.name).await.unwrap();
    }
    gateway.expect(&PAGES);
    assert_eq!(client.list_sessions().await.unwrap().len(), 1);
    gateway.expect(&PAGES);
    client.delete_session(&session.name).await.unwrap();
    // What the service says is said at once.
    let calls = gateway.calls().len();
    let missing = client.get_session(&session.name).await.unwrap_err();
    assert_eq!(reason(&missing), "SESSION_NOT_FOUND");
    assert_eq!(gateway.calls().len(), calls + 1);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stream_goes_on_over_cuts_and_pages() {
    let server = Server::start().await;
    let gateway = Gateway::start(&server.url).await;
    let client = connect(&gateway.url).await;
    let (scene, mesh) = load("hertz-plane.toml");
    client.upload_mesh(mesh).await.unwrap();
    let new = NewSession {
        scene: scene.clone(),
        ..Default::default()
    };
    let (session, _) = client.create_session(new).await.unwrap();
    gateway.expect(&PAGES);
    let attach = Attach::default();
    let Solve {
        mut updates,
        mut events,
        ..
    } = client.solve(&session.name, attach).await.unwrap();
    updates.load_step(scene.steps[0].clone()).await.unwrap();
    let mut last = result(&mut events).await.event;
    for index in 1..=4 {
        updates
            .obstacle_update(lowered(0.05 + 1e-3 * f64::from(index)))
            .await
            .unwrap();
        gateway.expect(&PAGES);
        gateway.cut();
        let next = result(&mut events).await.event;
        assert!(next > last, "each once");
        last = next;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_proxy_without_a_server_is_told_as_such_when_the_patience_ends() {
    let server = Server::start().await;
    let gateway = Gateway::start(&server.url).await;
    let client = connect(&gateway.url).await;
    let (scene, mesh) = load("hertz-plane.toml");
    client.upload_mesh(mesh).await.unwrap();
    let new = NewSession {
        scene,
        ..Default::default()
    };
    let (session, _) = client.create_session(new).await.unwrap();
    let attach = Attach {
        patience: Duration::from_millis(300),
        ..Default::default()
    };
    let mut solve = client.solve(&session.name, attach).await.unwrap();
    gateway.expect(&[Mishap::Page(502); 100]);
    gateway.cut();
    let ended = loop {
        match solve.events.next().await {
            Ok(Some(Event::ConnectionLost { .. })) => {}
            Ok(other) => unreachable!("{other:?}"),
            Err(error) => break error,
        }
    };
    assert!(matches!(ended, ClientError::Gateway { .. }), "{ended}");
    server.stop().await;
}
