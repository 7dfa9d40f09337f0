//! The client library against the server itself.
#![cfg(feature = "embedded")]

mod common;

use std::path::Path;

use common::example;
use signorini_client::formats::msh;
use signorini_client::scene_file;
use signorini_client::solve::{Attach, Event, Events, Increment};
use signorini_client::{Client, ClientError, NewSession, WireMesh};
use signorini_proto::v1;
use signorini_server::{Config, Listener, serve};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// A server on a free port, for one test.
struct Server {
    client: Client,
    url: String,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Server {
    async fn start() -> Self {
        let config = Config::embedded();
        let listener = Listener::bind(&config).await.unwrap();
        let url = listener.url().to_owned();
        let (stop, stopped) = oneshot::channel::<()>();
        let task = tokio::spawn(async move {
            let shutdown = async {
                let _stopped = stopped.await;
            };
            serve(listener, config, shutdown).await.unwrap();
        });
        let client = connect(&url).await;
        Self {
            client,
            url,
            stop,
            task,
        }
    }

    async fn stop(self) {
        drop(self.client);
        self.stop.send(()).unwrap();
        self.task.await.unwrap();
    }
}

async fn connect(url: &str) -> Client {
    Client::connect(&url.parse().unwrap()).await.unwrap()
}

/// An example with its mesh named, and the mesh.
fn load(name: &str) -> (v1::Scene, WireMesh) {
    let path = example(name);
    let text = std::fs::read_to_string(&path).unwrap();
    let file = scene_file::read(&text, &path, &[]).unwrap();
    let mesh = wire(&file.mesh);
    let scene = v1::Scene {
        mesh: mesh.name(),
        ..file.scene
    };
    (scene, mesh)
}

fn wire(path: &Path) -> WireMesh {
    let mesh = msh::read(&std::fs::read(path).unwrap()).unwrap();
    WireMesh::new(&mesh).unwrap()
}

async fn session(server: &Server, name: &str) -> (v1::Session, Vec<v1::LoadStep>) {
    let (scene, mesh) = load(name);
    server.client.upload_mesh(mesh).await.unwrap();
    let steps = scene.steps.clone();
    let new = NewSession {
        scene,
        ..Default::default()
    };
    let (session, _) = server.client.create_session(new).await.unwrap();
    (session, steps)
}

/// The next result; statistics on the way are passed over.
async fn result(events: &mut Events) -> Increment {
    loop {
        match events.next().await.unwrap().unwrap() {
            Event::Increment(increment) => return *increment,
            Event::Iteration(_) | Event::Heartbeat(_) => {}
            Event::Rejected { refusal, .. } => unreachable!("{refusal}"),
        }
    }
}

fn lowered(depth: f64) -> Vec<v1::ObstacleTarget> {
    let translation = vec![0.0, 0.0, depth];
    vec![v1::ObstacleTarget {
        name: "floor".to_owned(),
        translation,
        ..Default::default()
    }]
}

fn reason(error: &ClientError) -> &str {
    error.refusal().map_or("", |refusal| &refusal.reason)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_sent_once_listed_and_deleted() {
    let server = Server::start().await;
    let (_, mesh) = load("cube-bend.toml");
    let first = server.client.upload_mesh(mesh.clone()).await.unwrap();
    let second = server.client.upload_mesh(mesh.clone()).await.unwrap();
    assert!(!first.already_present && second.already_present);
    assert_eq!(
        (first.mesh.vertex_count, first.mesh.cell_count),
        (343, 1296)
    );
    let listed = server.client.list_meshes().await.unwrap();
    assert_eq!(
        listed
            .iter()
            .map(|mesh| mesh.digest.as_str())
            .collect::<Vec<_>>(),
        [mesh.digest()]
    );
    server.client.delete_mesh(mesh.digest()).await.unwrap();
    assert_eq!(server.client.find_mesh(mesh.digest()).await.unwrap(), None);
    let error = server.client.delete_mesh(mesh.digest()).await.unwrap_err();
    assert_eq!(reason(&error), "MESH_NOT_FOUND");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn results_come_with_the_fields_that_were_asked_for() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let fields = vec![v1::FieldName::Displacement, v1::FieldName::ContactPressure];
    let attach = Attach {
        fields: fields.clone(),
        ..Default::default()
    };
    let mut solve = server.client.solve(&session.name, attach).await.unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    let increment = result(&mut solve.events).await;
    assert!(increment.last);
    assert_eq!(increment.report.termination(), v1::Termination::Converged);
    assert_eq!(
        increment
            .fields
            .iter()
            .map(|field| field.name)
            .collect::<Vec<_>>(),
        fields
    );
    assert_eq!(
        (
            increment.fields[0].components,
            increment.fields[0].values.len()
        ),
        (3, 7146)
    );
    assert_eq!(increment.fields[1].values.len(), 378);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn obstacle_updates_follow_a_step_without_a_factorisation() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    solve.updates.load_step(steps[0].clone()).await.unwrap();
    let mut force = result(&mut solve.events).await.report.obstacles["floor"].force[2];
    for index in 1..=5 {
        let sequence = solve
            .updates
            .obstacle_update(lowered(0.05 + 1e-3 * f64::from(index)))
            .await
            .unwrap();
        let increment = result(&mut solve.events).await;
        assert_eq!(increment.sequence, sequence);
        assert_eq!(increment.report.factorisations, 0);
        let next = increment.report.obstacles["floor"].force[2];
        assert!(next > force, "{next} follows {force}");
        force = next;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_bad_update_is_rejected_and_its_sequence_is_free_again() {
    let server = Server::start().await;
    let (session, steps) = session(&server, "hertz-plane.toml").await;
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    let mut bad = steps[0].clone();
    bad.obstacles[0].name = "roof".to_owned();
    let sequence = solve.updates.load_step(bad).await.unwrap();
    let Some(Event::Rejected {
        sequence: rejected,
        refusal,
    }) = solve.events.next().await.unwrap()
    else {
        unreachable!()
    };
    assert_eq!(
        (rejected, refusal.reason.as_str()),
        (sequence, "SCENE_INVALID")
    );
    assert!(
        refusal
            .violations
            .iter()
            .any(|violation| violation.path.contains("roof")),
        "{refusal:?}"
    );
    solve.updates.rejected(rejected);
    assert_eq!(
        solve.updates.load_step(steps[0].clone()).await.unwrap(),
        sequence
    );
    let increment = result(&mut solve.events).await;
    assert_eq!(increment.report.termination(), v1::Termination::Converged);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_scenes_name_their_keys_and_unknown_meshes_their_reason() {
    let server = Server::start().await;
    let (mut scene, mesh) = load("hertz-plane.toml");
    let error = server.client.plan(scene.clone()).await.unwrap_err();
    assert_eq!(reason(&error), "MESH_NOT_FOUND");
    server.client.upload_mesh(mesh).await.unwrap();
    scene.supports[0].on = vec!["roof".to_owned()];
    let error = server.client.plan(scene).await.unwrap_err();
    assert_eq!(reason(&error), "SCENE_INVALID");
    assert_eq!(
        error.refusal().unwrap().violations[0].path,
        "support.top.on"
    );
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_connection_cancels_and_the_first_gets_the_result() {
    let server = Server::start().await;
    let (session, mut steps) = session(&server, "hertz-plane.toml").await;
    steps[0].increments = Some(100_000);
    let mut solve = server
        .client
        .solve(&session.name, Attach::default())
        .await
        .unwrap();
    let sequence = solve.updates.load_step(steps[0].clone()).await.unwrap();
    let first = result(&mut solve.events).await;
    assert!(!first.last);
    let other = connect(&server.url).await;
    assert_eq!(other.cancel_step(&session.name, 0).await.unwrap(), sequence);
    let mut last = result(&mut solve.events).await;
    while !last.last {
        last = result(&mut solve.events).await;
    }
    assert_eq!(last.report.termination(), v1::Termination::Cancelled);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_session_on_the_same_scene_shares_what_was_prepared() {
    let server = Server::start().await;
    let mut reused = Vec::new();
    for _ in 0..2 {
        let (session, steps) = session(&server, "hertz-plane.toml").await;
        let mut solve = server
            .client
            .solve(&session.name, Attach::default())
            .await
            .unwrap();
        solve.updates.load_step(steps[0].clone()).await.unwrap();
        reused.push(result(&mut solve.events).await.report.reused);
    }
    assert_eq!(server.client.list_sessions().await.unwrap().len(), 2);
    assert!(reused[0].is_empty() && !reused[1].is_empty(), "{reused:?}");
    server.stop().await;
}
