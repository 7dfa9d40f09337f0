//! An in-process server on a free port, a client, and a block to press on.

#![allow(dead_code, reason = "every test file uses its part")]

use signorini_proto::array;
use signorini_proto::digest::{GroupArrays, MeshArrays, hex, mesh_digest};
use signorini_proto::v1::mesh_service_client::MeshServiceClient;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use signorini_proto::v1::{
    self as wire, solve_request, solve_response::Message, upload_mesh_request::Part,
};
use signorini_server::{Config, Listener, ServeError, serve};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Streaming;
use tonic::transport::Channel;
use tonic_types::StatusExt;

/// A server of this process.
pub(crate) struct Server {
    pub(crate) url: String,
    pub(crate) metrics_url: Option<String>,
    pub(crate) channel: Channel,
    stop: Option<oneshot::Sender<()>>,
    serving: JoinHandle<Result<(), ServeError>>,
}

impl Server {
    pub(crate) async fn start() -> Self {
        Self::with(Config::embedded()).await
    }

    pub(crate) async fn with(config: Config) -> Self {
        let listener = Listener::bind(&config).await.unwrap();
        let (url, metrics_url) = (listener.url().to_owned(), listener.metrics_url());
        let (stop, stopped) = oneshot::channel::<()>();
        let shutdown = async {
            stopped.await.ok();
        };
        let serving = tokio::spawn(serve(listener, config, shutdown));
        let endpoint = tonic::transport::Endpoint::new(url.clone()).unwrap();
        let channel = endpoint.connect().await.unwrap();
        Self {
            url,
            metrics_url,
            channel,
            stop: Some(stop),
            serving,
        }
    }

    pub(crate) fn meshes(&self) -> MeshServiceClient<Channel> {
        MeshServiceClient::new(self.channel.clone())
    }

    pub(crate) fn sessions(&self) -> SessionServiceClient<Channel> {
        SessionServiceClient::new(self.channel.clone())
    }

    pub(crate) fn signal_stop(&mut self) {
        drop(self.stop.take());
    }

    pub(crate) async fn stopped(self) -> Result<(), ServeError> {
        self.serving.await.unwrap()
    }

    /// Uploads a mesh and returns its name.
    pub(crate) async fn upload(&self, block: &Block) -> String {
        let parts = tokio_stream::iter(block.messages());
        let response = self.meshes().upload_mesh(parts).await.unwrap().into_inner();
        response.mesh.unwrap().name
    }

    /// Uploads a block, opens a session for its scene and returns its name.
    pub(crate) async fn session(&self, scene: wire::Scene) -> String {
        let request = wire::CreateSessionRequest {
            scene: Some(scene),
            ..Default::default()
        };
        let response = self
            .sessions()
            .create_session(request)
            .await
            .unwrap()
            .into_inner();
        response.session.unwrap().name
    }

    pub(crate) async fn describe(&self, name: &str) -> wire::Session {
        let request = wire::GetSessionRequest { name: name.into() };
        self.sessions()
            .get_session(request)
            .await
            .unwrap()
            .into_inner()
            .session
            .unwrap()
    }

    /// Opens a stream; `opened` is read already.
    pub(crate) async fn open(&self, open: wire::Open) -> Stream {
        let mut stream = self.stream(open).await;
        let Message::Opened(_) = stream.next().await else {
            panic!("`opened` comes first");
        };
        stream
    }

    pub(crate) async fn stream(&self, open: wire::Open) -> Stream {
        let (updates, outbound) = mpsc::channel(16);
        let first = solve_request::Message::Open(open);
        updates
            .send(wire::SolveRequest {
                message: Some(first),
            })
            .await
            .unwrap();
        let call = self.sessions().solve(ReceiverStream::new(outbound)).await;
        Stream {
            updates: Some(updates),
            answers: call.unwrap().into_inner(),
        }
    }
}

/// One open `Solve` stream.
pub(crate) struct Stream {
    updates: Option<mpsc::Sender<wire::SolveRequest>>,
    answers: Streaming<wire::SolveResponse>,
}

impl Stream {
    pub(crate) async fn send(&self, message: solve_request::Message) {
        let request = wire::SolveRequest {
            message: Some(message),
        };
        self.updates.as_ref().unwrap().send(request).await.unwrap();
    }

    pub(crate) async fn step(&self, sequence: i64, step: wire::LoadStep) {
        let update = wire::LoadStepUpdate {
            sequence,
            step: Some(step),
            max_wall_time: None,
        };
        self.send(solve_request::Message::LoadStep(update)).await;
    }

    /// Moves the obstacle `ball` down to `depth`.
    pub(crate) async fn press(&self, sequence: i64, depth: f64) {
        let update = wire::ObstacleUpdate {
            sequence,
            obstacles: vec![target(depth)],
            ..Default::default()
        };
        self.send(solve_request::Message::ObstacleUpdate(update))
            .await;
    }

    pub(crate) fn half_close(&mut self) {
        self.updates = None;
    }

    pub(crate) async fn next(&mut self) -> Message {
        self.answers
            .message()
            .await
            .unwrap()
            .unwrap()
            .message
            .unwrap()
    }

    /// The next message or the status that ended the stream.
    pub(crate) async fn try_next(&mut self) -> Result<Message, tonic::Status> {
        self.answers
            .message()
            .await
            .map(|message| message.unwrap().message.unwrap())
    }

    /// The end of the stream: `None` when it ended well.
    pub(crate) async fn end(&mut self) -> Option<tonic::Status> {
        loop {
            match self.answers.message().await {
                Ok(Some(_)) => {}
                Ok(None) => return None,
                Err(status) => return Some(status),
            }
        }
    }

    /// The next result, iterations left out.
    pub(crate) async fn result(&mut self) -> wire::StepFinished {
        loop {
            match self.next().await {
                Message::StepFinished(finished) => return finished,
                Message::Iteration(_) | Message::Heartbeat(_) | Message::Field(_) => {}
                other => panic!("{other:?} instead of a result"),
            }
        }
    }

    pub(crate) async fn rejection(&mut self) -> wire::UpdateRejected {
        loop {
            match self.next().await {
                Message::UpdateRejected(rejected) => return rejected,
                Message::Iteration(_) | Message::Heartbeat(_) => {}
                other => panic!("{other:?} instead of a rejection"),
            }
        }
    }

    /// The next field, put together.
    pub(crate) async fn field(&mut self) -> (wire::FieldName, Vec<i64>, Vec<f64>) {
        let mut values = Vec::new();
        loop {
            let Message::Field(chunk) = self.next().await else {
                panic!("a slice of a field is due");
            };
            assert_eq!(chunk.offset_elements, values.len() as i64);
            values.extend(array::decode::<f64>(&chunk.data).unwrap());
            if chunk.last {
                return (chunk.field(), chunk.shape, values);
            }
        }
    }
}

pub(crate) fn open(session: &str) -> wire::Open {
    wire::Open {
        session: session.into(),
        ..Default::default()
    }
}

pub(crate) fn target(depth: f64) -> wire::ObstacleTarget {
    wire::ObstacleTarget {
        name: "ball".into(),
        translation: vec![0.0, 0.0, -depth],
        ..Default::default()
    }
}

/// A step that moves the ball to `depth`.
pub(crate) fn press(depth: f64, increments: i32) -> wire::LoadStep {
    wire::LoadStep {
        increments: Some(increments),
        obstacles: vec![target(depth)],
        ..Default::default()
    }
}

/// The reason in a status.
pub(crate) fn reason(status: &tonic::Status) -> String {
    status.get_details_error_info().unwrap().reason
}

/// Paths of all violations in a status.
pub(crate) fn paths(status: &tonic::Status) -> Vec<String> {
    let request = status.get_details_bad_request().unwrap();
    request
        .field_violations
        .into_iter()
        .map(|violation| violation.field)
        .collect()
}

/// The reason in the status of a rejected update.
pub(crate) fn rejection_reason(rejected: &wire::UpdateRejected) -> String {
    use prost::Message as _;
    let any = &rejected.status.as_ref().unwrap().details[0];
    tonic_types::pb::ErrorInfo::decode(&any.value[..])
        .unwrap()
        .reason
}

/// A unit cube of `n`^3 boxes, six tetrahedra each; facet groups `bottom` and `top`.
pub(crate) struct Block {
    pub(crate) coordinates: Vec<f64>,
    pub(crate) cells: Vec<i32>,
    pub(crate) facets: Vec<i32>,
    pub(crate) bottom: Vec<i32>,
    pub(crate) top: Vec<i32>,
    pub(crate) body: Vec<i32>,
}

impl Block {
    pub(crate) fn new(n: i32) -> Self {
        let mut block = Self {
            coordinates: Vec::new(),
            cells: Vec::new(),
            facets: Vec::new(),
            bottom: Vec::new(),
            top: Vec::new(),
            body: (0..6 * n * n * n).collect(),
        };
        for k in 0..=n {
            for j in 0..=n {
                for i in 0..=n {
                    block
                        .coordinates
                        .extend([i, j, k].map(|c| f64::from(c) / f64::from(n)));
                }
            }
        }
        for k in 0..n {
            for j in 0..n {
                for i in 0..n {
                    block.add_box(n, [i, j, k]);
                }
            }
        }
        block
    }

    fn add_box(&mut self, n: i32, corner: [i32; 3]) {
        const PATHS: [[usize; 3]; 6] = [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [2, 1, 0],
            [1, 0, 2],
        ];
        let vertex = |at: [i32; 3]| at[0] + (n + 1) * (at[1] + (n + 1) * at[2]);
        for (number, path) in PATHS.iter().enumerate() {
            let mut at = corner;
            let mut cell = vec![(vertex(at), at)];
            for axis in path {
                at[*axis] += 1;
                cell.push((vertex(at), at));
            }
            let facet: Vec<_> = cell.iter().filter(|(_, at)| at[2] == corner[2]).collect();
            self.add_facet(&facet, corner[2] == 0, Side::Bottom);
            let facet: Vec<_> = cell
                .iter()
                .filter(|(_, at)| at[2] == corner[2] + 1)
                .collect();
            self.add_facet(&facet, corner[2] + 1 == n, Side::Top);
            // Odd permutations of the axes turn a cell inside out.
            if number >= 3 {
                cell.swap(2, 3);
            }
            self.cells.extend(cell.iter().map(|(vertex, _)| vertex));
        }
    }

    fn add_facet(&mut self, facet: &[&(i32, [i32; 3])], outside: bool, side: Side) {
        if facet.len() != 3 || !outside {
            return;
        }
        let index = (self.facets.len() / 3) as i32;
        self.facets.extend(facet.iter().map(|(vertex, _)| vertex));
        match side {
            Side::Bottom => self.bottom.push(index),
            Side::Top => self.top.push(index),
        }
    }

    fn groups(&self) -> [(&'static str, wire::GroupKind, &[i32]); 3] {
        [
            ("body", wire::GroupKind::Cells, &self.body),
            ("bottom", wire::GroupKind::Facets, &self.bottom),
            ("top", wire::GroupKind::Facets, &self.top),
        ]
    }

    pub(crate) fn digest(&self) -> String {
        let groups = self.groups().map(|(name, kind, members)| GroupArrays {
            name,
            dimension: if kind == wire::GroupKind::Cells { 3 } else { 2 },
            members,
        });
        hex(&mesh_digest(&MeshArrays {
            vertices_per_cell: 4,
            coordinates: &self.coordinates,
            cells: &self.cells,
            facets: &self.facets,
            groups: &groups,
        }))
    }

    pub(crate) fn header(&self) -> wire::MeshHeader {
        wire::MeshHeader {
            digest: self.digest(),
            cell_kind: wire::CellKind::Tetrahedron.into(),
            vertex_count: (self.coordinates.len() / 3) as i64,
            cell_count: (self.cells.len() / 4) as i64,
            facet_count: (self.facets.len() / 3) as i64,
            groups: Vec::from(self.groups().map(|(name, kind, members)| wire::MeshGroup {
                name: name.into(),
                kind: kind.into(),
                member_count: members.len() as i64,
            })),
        }
    }

    pub(crate) fn messages(&self) -> Vec<wire::UploadMeshRequest> {
        let mut parts = vec![Part::Header(self.header())];
        let mut add = |array: wire::MeshArray, group_index: i32, data: bytes::Bytes, size| {
            parts.extend(array::chunks(data, size).map(|chunk| {
                Part::Chunk(wire::MeshChunk {
                    array: array.into(),
                    group_index,
                    offset_elements: chunk.offset_elements,
                    data: chunk.data,
                })
            }));
        };
        add(
            wire::MeshArray::Coordinates,
            0,
            array::encode(&self.coordinates),
            8,
        );
        add(wire::MeshArray::Cells, 0, array::encode(&self.cells), 4);
        add(wire::MeshArray::Facets, 0, array::encode(&self.facets), 4);
        for (index, (_, _, members)) in (0..).zip(self.groups()) {
            add(
                wire::MeshArray::GroupMembers,
                index,
                array::encode(members),
                4,
            );
        }
        parts
            .into_iter()
            .map(|part| wire::UploadMeshRequest { part: Some(part) })
            .collect()
    }

    /// The block held at its bottom under a ball that touches its top.
    pub(crate) fn scene(&self) -> wire::Scene {
        wire::Scene {
            name: "block".into(),
            mesh: format!("meshes/{}", self.digest()),
            materials: vec![rubber()],
            supports: vec![wire::Support {
                name: "base".into(),
                on: vec!["bottom".into()],
                displacement: Some(wire::Components {
                    x: Some(0.0),
                    y: Some(0.0),
                    z: Some(0.0),
                }),
                normal: None,
            }],
            obstacles: vec![ball()],
            solver: Some(wire::SolverOptions {
                tolerance: Some(1e-8),
                ..Default::default()
            }),
            ..Default::default()
        }
    }
}

enum Side {
    Bottom,
    Top,
}

fn rubber() -> wire::Material {
    let law = wire::LinearElastic {
        modulus: Some(wire::linear_elastic::Modulus::ShearModulus(1.0)),
        poisson_ratio: Some(0.5),
    };
    wire::Material {
        group: "body".into(),
        model: Some(wire::material::Model::LinearElastic(law)),
        ..Default::default()
    }
}

fn ball() -> wire::Obstacle {
    let sphere = wire::Sphere {
        centre: vec![0.5, 0.5, 2.0],
        radius: Some(1.0),
    };
    wire::Obstacle {
        name: "ball".into(),
        on: vec!["top".into()],
        shape: Some(wire::Shape {
            kind: Some(wire::shape::Kind::Sphere(sphere)),
            inside: false,
        }),
        ..Default::default()
    }
}
