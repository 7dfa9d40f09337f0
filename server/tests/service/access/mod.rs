//! Who may do what: roles, owners, transport security, and all of it changing while the server runs.

mod live;
mod owners;
mod product;
mod reload;
mod roles;
mod strangers;
mod transport;

use std::path::{Path, PathBuf};
use std::time::Duration;

use prost::Message;
use signorini_proto::v1 as wire;
use signorini_server::{Config, NewToken, Role, TokenFile};
use tonic::client::Grpc;
use tonic::transport::Channel;
use tonic::{Request, Status, Streaming};
use tonic_prost::ProstCodec;

use crate::common::{Block, Server, folder};

const CREATE: &str = "/signorini.v1.SessionService/CreateSession";
const GET: &str = "/signorini.v1.SessionService/GetSession";
const LIST: &str = "/signorini.v1.SessionService/ListSessions";
const UPLOAD: &str = "/signorini.v1.MeshService/UploadMesh";
const HEALTH: &str = "/grpc.health.v1.Health/Check";

/// In which a server takes up a changed file.
const SOON: Duration = Duration::from_secs(5);

/// A token file of a test.
struct Tokens {
    path: PathBuf,
    file: TokenFile,
}

impl Tokens {
    fn new(test: &str) -> Self {
        let path = folder(test).join("tokens.toml");
        let file = TokenFile::default();
        file.write(&path).unwrap();
        Self { path, file }
    }

    fn folder(&self) -> &Path {
        self.path.parent().unwrap()
    }

    fn add(&mut self, name: &str, role: Role) -> String {
        let added = self.file.add(name.parse().unwrap(), role, NewToken::Bearer);
        self.file.write(&self.path).unwrap();
        added.unwrap().unwrap()
    }

    fn add_certificate(&mut self, name: &str, role: Role) {
        let name = name.parse().unwrap();
        self.file.add(name, role, NewToken::Certificate).unwrap();
        self.file.write(&self.path).unwrap();
    }

    fn revoke(&mut self, name: &str) {
        assert!(self.file.revoke(name.parse().unwrap(), None) > 0);
        self.file.write(&self.path).unwrap();
    }

    fn config(&self) -> Config {
        Config {
            tokens: self.path.to_str().unwrap().to_owned(),
            ..Config::embedded()
        }
    }
}

/// A client that shows a token, or none.
#[derive(Clone)]
struct Client {
    channel: Channel,
    token: Option<String>,
}

impl Client {
    fn of(server: &Server, token: &str) -> Self {
        Self {
            channel: server.channel.clone(),
            token: Some(token.to_owned()),
        }
    }

    /// Sends messages to a method, whatever its kind.
    async fn call<Q, A>(&self, path: &str, messages: Vec<Q>) -> Result<Streaming<A>, Status>
    where
        Q: Message + 'static,
        A: Message + Default + 'static,
    {
        let mut client = Grpc::new(self.channel.clone());
        let ready = client.ready().await;
        ready.map_err(|error| Status::unavailable(error.to_string()))?;
        let mut request = Request::new(tokio_stream::iter(messages));
        if let Some(token) = &self.token {
            let shown = format!("Bearer {token}").parse().unwrap();
            request.metadata_mut().insert("authorization", shown);
        }
        let (path, codec) = (path.parse().unwrap(), ProstCodec::<Q, A>::default());
        Ok(client.streaming(request, path, codec).await?.into_inner())
    }

    /// The first answer, if any.
    async fn first<Q, A>(&self, path: &str, message: Q) -> Result<Option<A>, Status>
    where
        Q: Message + 'static,
        A: Message + Default + 'static,
    {
        self.call(path, vec![message]).await?.message().await
    }

    async fn upload(&self, block: &Block) -> Result<wire::UploadMeshResponse, Status> {
        let mut answers = self.call(UPLOAD, block.messages()).await?;
        Ok(answers.message().await?.unwrap())
    }

    /// Creates a session of that identifier; its name.
    async fn create(&self, block: &Block, id: &str) -> Result<String, Status> {
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            session_id: id.to_owned(),
            ..Default::default()
        };
        let made: Option<wire::CreateSessionResponse> = self.first(CREATE, request).await?;
        Ok(made.unwrap().session.unwrap().name)
    }

    async fn sessions(&self) -> Result<Vec<String>, Status> {
        let request = wire::ListSessionsRequest::default();
        let found: Option<wire::ListSessionsResponse> = self.first(LIST, request).await?;
        let sessions = found.unwrap().sessions.into_iter();
        Ok(sessions.map(|one| one.name).collect())
    }

    async fn is_healthy(&self) -> bool {
        self.first::<(), ()>(HEALTH, ()).await.is_ok()
    }
}

/// Waits until `is_so`, no longer than a server takes to look at its files.
async fn soon(what: &str, mut is_so: impl AsyncFnMut() -> bool) {
    let end = tokio::time::Instant::now() + SOON;
    while !is_so().await {
        assert!(tokio::time::Instant::now() < end, "{what} does not come");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}
