//! An in-process server on a free port, a client, and a block to press on.

#![allow(dead_code, reason = "every test file uses its part")]
#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "what a test does not expect is a failure"
)]

mod block;
mod page;
mod process;
mod results;
mod tool;

use signorini_proto::array;
use signorini_proto::v1::mesh_service_client::MeshServiceClient;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use signorini_proto::v1::{self as wire, solve_request, solve_response::Message};
use signorini_server::{Config, Listener, ServeError, serve};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Streaming;
use tonic::transport::Channel;
use tonic_types::StatusExt;

pub(crate) use block::Block;
#[allow(unused_imports, reason = "every test file uses its part")]
pub(crate) use page::{answer, answer_to, page, sample};
#[allow(unused_imports, reason = "every test file uses its part")]
pub(crate) use process::{Process, folder};
#[allow(unused_imports, reason = "every test file uses its part")]
pub(crate) use results::bare;
#[allow(unused_imports, reason = "every test file uses its part")]
pub(crate) use tool::Tool;

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
        let mut server = Self::listening(config).await;
        let endpoint = tonic::transport::Endpoint::new(server.url.clone()).unwrap();
        server.channel = endpoint.connect().await.unwrap();
        server
    }

    /// A server that nobody has connected to.
    pub(crate) async fn listening(config: Config) -> Self {
        let listener = Listener::bind(&config).await.unwrap();
        let (url, metrics_url) = (listener.url().to_owned(), listener.metrics_url());
        let (stop, stopped) = oneshot::channel::<()>();
        let shutdown = async {
            stopped.await.ok();
        };
        let serving = tokio::spawn(serve(listener, config, shutdown));
        let channel = tonic::transport::Endpoint::from_static("http://nobody").connect_lazy();
        Self {
            url,
            metrics_url,
            channel,
            stop: Some(stop),
            serving,
        }
    }

    /// A server of another process, which may still be starting.
    pub(crate) async fn beside(url: &str) -> Self {
        let endpoint = tonic::transport::Endpoint::new(url.to_owned()).unwrap();
        let deadline = tokio::time::Instant::now() + std::time::Duration::from_secs(30);
        let channel = loop {
            match endpoint.connect().await {
                Ok(channel) => break channel,
                Err(error) => assert!(tokio::time::Instant::now() < deadline, "{error}"),
            }
            tokio::time::sleep(std::time::Duration::from_millis(10)).await;
        };
        Self {
            url: url.to_owned(),
            metrics_url: None,
            channel,
            stop: None,
            serving: tokio::spawn(async { Ok(()) }),
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
    pub(crate) async fn open(&self, open: wire::SolveOpen) -> Stream {
        let mut stream = self.stream(open).await;
        let Message::Opened(_) = stream.next().await else {
            panic!("`opened` comes first");
        };
        stream
    }

    /// A server to which this one's clients may connect anew.
    pub(crate) async fn connect(&self) -> Channel {
        let endpoint = tonic::transport::Endpoint::new(self.url.clone()).unwrap();
        endpoint.connect().await.unwrap()
    }

    /// As [`Server::open`], with the status of a server that is gone.
    pub(crate) async fn try_open(&self, open: wire::SolveOpen) -> Result<Stream, tonic::Status> {
        let (updates, messages) = mpsc::channel(16);
        let message = Some(solve_request::Message::Open(open));
        updates.send(wire::SolveRequest { message }).await.unwrap();
        let call = self.sessions().solve(ReceiverStream::new(messages)).await?;
        let mut stream = Stream {
            updates: Some(updates),
            answers: call.into_inner(),
        };
        match stream.try_next().await? {
            Message::Opened(_) => Ok(stream),
            other => panic!("{other:?} before `opened`"),
        }
    }

    /// A kept result with the bytes of its fields.
    pub(crate) async fn read(
        &self,
        session: &str,
        sequence: i64,
        increment: i32,
    ) -> (wire::StepFinished, Vec<u8>) {
        use wire::read_step_response::Message;
        let request = wire::ReadStepRequest {
            name: session.into(),
            sequence,
            increment,
            ..Default::default()
        };
        let call = self.sessions().read_step(request).await.unwrap();
        let (mut answers, mut result, mut bytes) = (call.into_inner(), None, Vec::new());
        while let Some(answer) = answers.message().await.unwrap() {
            match answer.message.unwrap() {
                Message::StepFinished(one) => result = Some(one),
                Message::Field(chunk) => bytes.extend_from_slice(&chunk.data),
            }
        }
        (result.unwrap(), bytes)
    }

    /// Follows a session; `opened` is read already.
    pub(crate) async fn watch(&self, request: wire::WatchRequest) -> Watcher {
        let call = self.sessions().watch(request).await;
        let mut watcher = Watcher(call.unwrap().into_inner());
        let Ok(Some(wire::watch_response::Message::Opened(_))) = watcher.next().await else {
            panic!("`opened` comes first");
        };
        watcher
    }

    /// Cancels what runs in a session, from a connection of its own.
    pub(crate) async fn cancel(&self, session: &str) -> i64 {
        let request = wire::CancelStepRequest {
            name: session.into(),
            sequence: 0,
        };
        let mut client = SessionServiceClient::new(self.connect().await);
        client
            .cancel_step(request)
            .await
            .unwrap()
            .into_inner()
            .sequence
    }

    pub(crate) async fn stream(&self, open: wire::SolveOpen) -> Stream {
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

/// One open `Watch` stream.
pub(crate) struct Watcher(Streaming<wire::WatchResponse>);

impl Watcher {
    /// The next message; `None` at the end.
    pub(crate) async fn next(
        &mut self,
    ) -> Result<Option<wire::watch_response::Message>, tonic::Status> {
        let response = self.0.message().await?;
        Ok(response.map(|response| response.message.unwrap()))
    }

    /// All results up to the first one that ends its update.
    pub(crate) async fn update(&mut self) -> Vec<wire::StepFinished> {
        let mut results = Vec::new();
        loop {
            let message = self.next().await.unwrap().unwrap();
            if let wire::watch_response::Message::StepFinished(one) = message {
                results.push(one);
                if results.last().is_some_and(|one| one.last) {
                    return results;
                }
            }
        }
    }

    /// All results until the stream ends, and how it ended.
    pub(crate) async fn results(&mut self) -> (Vec<wire::StepFinished>, Option<tonic::Status>) {
        let mut results = Vec::new();
        loop {
            match self.next().await {
                Ok(Some(wire::watch_response::Message::StepFinished(one))) => results.push(one),
                Ok(Some(_)) => {}
                Ok(None) => return (results, None),
                Err(status) => return (results, Some(status)),
            }
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

    /// As [`Stream::step`], with the end of the stream as a status.
    pub(crate) async fn try_step(
        &self,
        sequence: i64,
        step: wire::LoadStep,
    ) -> Result<(), tonic::Status> {
        let update = wire::LoadStepUpdate {
            sequence,
            step: Some(step),
            max_wall_time: None,
        };
        let message = Some(solve_request::Message::LoadStep(update));
        let request = wire::SolveRequest { message };
        let sent = self.updates.as_ref().unwrap().send(request).await;
        sent.map_err(|_| tonic::Status::unavailable("the stream is gone"))
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

pub(crate) fn open(session: &str) -> wire::SolveOpen {
    wire::SolveOpen {
        session: session.into(),
        ..Default::default()
    }
}

pub(crate) fn watch(session: &str, until: wire::WatchEnd) -> wire::WatchRequest {
    wire::WatchRequest {
        name: session.into(),
        last_seen_event: Some(0),
        until: until.into(),
        ..Default::default()
    }
}

/// Whole time of the server's clocks.
pub(crate) fn duration(milliseconds: i64) -> Option<prost_types::Duration> {
    Some(prost_types::Duration {
        seconds: milliseconds / 1000,
        nanos: (milliseconds % 1000 * 1_000_000) as i32,
    })
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
    let info = status.get_details_error_info();
    info.unwrap_or_else(|| panic!("{status:?} has no reason"))
        .reason
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
