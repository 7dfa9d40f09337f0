//! The server itself, in the process of a test.

use std::path::Path;

use signorini_client::formats::msh;
use signorini_client::scene_file;
use signorini_client::solve::{Event, Events, Increment};
use signorini_client::{Client, ClientError, NewSession, WireMesh};
use signorini_proto::v1;
use signorini_server::{Config, Listener, serve};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

use super::example;

/// A server on a free port, for one test.
pub(crate) struct Server {
    pub(crate) client: Client,
    pub(crate) url: String,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Server {
    pub(crate) async fn start() -> Self {
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

    pub(crate) async fn stop(self) {
        drop(self.client);
        self.stop.send(()).unwrap();
        self.task.await.unwrap();
    }
}

pub(crate) async fn connect(url: &str) -> Client {
    Client::connect(&url.parse().unwrap()).await.unwrap()
}

/// An example with its mesh named, and the mesh.
pub(crate) fn load(name: &str) -> (v1::Scene, WireMesh) {
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

pub(crate) async fn session(server: &Server, name: &str) -> (v1::Session, Vec<v1::LoadStep>) {
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
pub(crate) async fn result(events: &mut Events) -> Increment {
    loop {
        match events.next().await.unwrap().unwrap() {
            Event::Increment(increment) => return *increment,
            Event::Iteration(_)
            | Event::Heartbeat(_)
            | Event::ConnectionLost { .. }
            | Event::Reconnected { .. } => {}
            Event::Rejected { refusal, .. } => unreachable!("{refusal}"),
        }
    }
}

pub(crate) fn lowered(depth: f64) -> Vec<v1::ObstacleTarget> {
    let translation = vec![0.0, 0.0, depth];
    vec![v1::ObstacleTarget {
        name: "floor".to_owned(),
        translation,
        ..Default::default()
    }]
}

pub(crate) fn reason(error: &ClientError) -> &str {
    error.refusal().map_or("", |refusal| &refusal.reason)
}
