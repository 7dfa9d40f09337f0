//! A server of this process and clients of it.

use std::path::Path;

use signorini_client::formats::msh;
use signorini_client::scene_file::{self, Override};
use signorini_client::solve::{Attach, Event, Events, Increment, Solve};
use signorini_client::{Client, NewSession, WireMesh};
use signorini_proto::v1;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use signorini_server::{Config, Listener, serve};
use tonic::transport::{Channel, Endpoint};

/// A server that runs until the process ends.
pub(crate) struct Server {
    pub(crate) url: String,
    pub(crate) client: Client,
}

impl Server {
    pub(crate) async fn start(config: Config) -> Self {
        let listener = Listener::bind(&config).await.unwrap();
        let url = listener.url().to_owned();
        tokio::spawn(serve(listener, config, std::future::pending()));
        let client = Client::connect(&url.parse().unwrap()).await.unwrap();
        Self { url, client }
    }

    pub(crate) async fn connect(&self) -> Client {
        Client::connect(&self.url.parse().unwrap()).await.unwrap()
    }

    /// A connection of its own, as the generated client has it.
    pub(crate) async fn channel(&self) -> Channel {
        let endpoint = Endpoint::from_shared(self.url.clone()).unwrap();
        let endpoint = endpoint
            .tcp_nodelay(true)
            .initial_stream_window_size(1 << 20)
            .initial_connection_window_size(4 << 20);
        endpoint.connect().await.unwrap()
    }

    pub(crate) async fn sessions(&self) -> SessionServiceClient<Channel> {
        SessionServiceClient::new(self.channel().await)
    }

    /// Uploads the mesh of a scene and creates a session for it.
    pub(crate) async fn session(&self, scene: &Scene) -> String {
        self.client.upload_mesh(scene.mesh.clone()).await.unwrap();
        let new = NewSession {
            scene: scene.message.clone(),
            ..Default::default()
        };
        self.client.create_session(new).await.unwrap().0.name
    }
}

/// Opens the stream of a session and presses the ball to 0.05 in equal parts;
/// returns with the first result.
pub(crate) async fn pressed(client: &Client, session: &str, increments: i32) -> Solve {
    let mut solve = client.solve(session, Attach::default()).await.unwrap();
    solve
        .updates
        .load_step(press(0.05, increments))
        .await
        .unwrap();
    result(&mut solve.events).await;
    solve
}

/// A scene with its mesh.
#[derive(Clone)]
pub(crate) struct Scene {
    pub(crate) message: v1::Scene,
    pub(crate) mesh: WireMesh,
}

impl Scene {
    /// The sphere pressed into a block: 1, 2 (small) from the tests' meshes, or
    /// the example's own mesh.
    pub(crate) fn sphere(level: u32) -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mesh = root.join(format!("../tests/meshes/indent_l{level}.msh"));
        let changes = match mesh.exists() {
            true => vec![format!("mesh={}", mesh.display()).parse().unwrap()],
            false => Vec::new(),
        };
        Self::read("hertz-sphere.toml", &changes)
    }

    /// The example of that name, on the mesh of `SIGNORINI_BENCH_MESH` if that is set.
    pub(crate) fn large(name: &str) -> Self {
        let mesh = std::env::var("SIGNORINI_BENCH_MESH").ok();
        let change = mesh.map(|mesh| format!("mesh={mesh}").parse().unwrap());
        Self::read(name, change.as_slice())
    }

    /// The example of that name with changed keys.
    fn read(name: &str, changes: &[Override]) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("examples")
            .join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        let file = scene_file::read(&text, &path, changes).unwrap();
        let mesh = msh::read(&std::fs::read(&file.mesh).unwrap()).unwrap();
        let mesh = WireMesh::new(&mesh).unwrap();
        let message = v1::Scene {
            mesh: mesh.name(),
            ..file.scene
        };
        Self { message, mesh }
    }

    /// With another tolerance.
    pub(crate) fn tolerance(mut self, tolerance: f64) -> Self {
        let solver = self.message.solver.get_or_insert_default();
        solver.tolerance = Some(tolerance);
        self
    }
}

/// The ball at `depth`.
pub(crate) fn ball(depth: f64) -> Vec<v1::ObstacleTarget> {
    vec![v1::ObstacleTarget {
        name: "ball".to_owned(),
        translation: vec![0.0, 0.0, -depth],
        ..Default::default()
    }]
}

/// A step that moves the ball to `depth` in equal parts.
pub(crate) fn press(depth: f64, increments: i32) -> v1::LoadStep {
    v1::LoadStep {
        increments: Some(increments),
        obstacles: ball(depth),
        ..Default::default()
    }
}

/// The next result.
pub(crate) async fn result(events: &mut Events) -> Increment {
    loop {
        match events.next().await.unwrap().expect("the stream goes on") {
            Event::Increment(increment) => return *increment,
            Event::Rejected { refusal, .. } => panic!("{refusal}"),
            Event::Iteration(_)
            | Event::Heartbeat(_)
            | Event::ConnectionLost { .. }
            | Event::Reconnected { .. } => {}
        }
    }
}
