//! What belongs to one client is not there for another.

use super::product::NAMING;
use prost::Message;
use signorini_proto::v1 as wire;
use signorini_server::{Config, Role};
use tonic::{Code, Status};

use super::{Client, GET, Tokens};
use crate::common::{Block, Server, reason};

/// A server with two solving clients and an administrator.
async fn three(test: &str, config: Config) -> (Server, Tokens, [Client; 3]) {
    let mut tokens = Tokens::new(test);
    let shown = [
        tokens.add("line-1", Role::Solve),
        tokens.add("line-2", Role::Solve),
        tokens.add("ops", Role::Admin),
    ];
    let config = Config {
        tokens: tokens.config().tokens,
        ..config
    };
    let server = Server::with(config).await;
    let clients = shown.map(|token| Client::of(&server, &token));
    (server, tokens, clients)
}

/// Why a method refuses the resource `name`, if it does.
pub(super) async fn refusal(client: &Client, path: &str, name: &str) -> Option<String> {
    // The name is the first field of all these requests.
    let request = wire::GetSessionRequest { name: name.into() };
    let answer = client.first::<_, ()>(path, request).await;
    answer.err().map(|status| reason(&status))
}

async fn open<A: Message + Default + 'static>(
    client: &Client,
    session: &str,
) -> Result<Option<A>, Status> {
    let open = wire::SolveOpen {
        session: session.into(),
        ..Default::default()
    };
    let message = Some(wire::solve_request::Message::Open(open));
    let request = wire::SolveRequest { message };
    client
        .first("/signorini.v1.SessionService/Solve", request)
        .await
}

#[tokio::test(flavor = "multi_thread")]
async fn sessions_and_meshes_of_another_client_are_not_there() {
    let (_server, _tokens, [mine, others, ops]) = three("owners", Config::embedded()).await;
    let block = Block::new(1);
    let mesh = mine.upload(&block).await.unwrap().mesh.unwrap().name;
    let session = mine.create(&block, "mine-1").await.unwrap();
    let (_, _, methods) = NAMING[0];
    for &method in methods {
        let path = format!("/signorini.v1.SessionService/{method}");
        let said = refusal(&others, &path, &session).await;
        assert_eq!(said.as_deref(), Some("SESSION_NOT_FOUND"), "{method}");
    }
    let refused = open::<()>(&others, &session).await.unwrap_err();
    assert_eq!(reason(&refused), "SESSION_NOT_FOUND");
    for method in ["GetMesh", "ReadMesh", "DeleteMesh"] {
        let path = format!("/signorini.v1.MeshService/{method}");
        let said = refusal(&others, &path, &mesh).await;
        assert_eq!(said.as_deref(), Some("MESH_NOT_FOUND"), "{method}");
    }
    let refused = others.create(&block, "").await.unwrap_err();
    assert_eq!(reason(&refused), "MESH_NOT_FOUND");
    let request = wire::ListMeshesRequest::default();
    let found = others.first("/signorini.v1.MeshService/ListMeshes", request);
    let found: wire::ListMeshesResponse = found.await.unwrap().unwrap();
    assert!(found.meshes.is_empty());
    assert!(others.sessions().await.unwrap().is_empty());
    assert_eq!(
        mine.sessions().await.unwrap(),
        std::slice::from_ref(&session)
    );
    assert_eq!(
        ops.sessions().await.unwrap(),
        std::slice::from_ref(&session)
    );
    assert_eq!(refusal(&ops, GET, &session).await, None);
    assert!(open::<()>(&mine, &session).await.unwrap().is_some());
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_sends_the_same_mesh_has_it_until_the_last_deletes_it() {
    let (_server, _tokens, [mine, others, _]) = three("same-mesh", Config::embedded()).await;
    let block = Block::new(1);
    let name = mine.upload(&block).await.unwrap().mesh.unwrap().name;
    // Naming the digest is not enough, the bytes have to come.
    let header = block.messages()[..1].to_vec();
    let named = others.call::<_, ()>(super::UPLOAD, header).await;
    let named = match named {
        Ok(mut answers) => answers.message().await.err(),
        Err(status) => Some(status),
    };
    assert_eq!(named.unwrap().code(), Code::InvalidArgument);
    let sent = others.upload(&block).await.unwrap();
    assert!(!sent.already_present && sent.mesh.unwrap().name == name);
    assert!(others.upload(&block).await.unwrap().already_present);
    let delete = "/signorini.v1.MeshService/DeleteMesh";
    let get = "/signorini.v1.MeshService/GetMesh";
    assert_eq!(refusal(&mine, delete, &name).await, None);
    assert!(refusal(&mine, get, &name).await.is_some());
    assert_eq!(refusal(&others, get, &name).await, None);
    assert_eq!(refusal(&others, delete, &name).await, None);
    assert!(refusal(&others, get, &name).await.is_some());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_has_its_own_limit_and_its_own_request_identifiers() {
    let config = Config {
        maximum_client_sessions: 1,
        ..Config::embedded()
    };
    let (_server, _tokens, [mine, others, _]) = three("client-limit", config).await;
    let block = Block::new(1);
    for client in [&mine, &others] {
        client.upload(&block).await.unwrap();
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            request_id: "the-same".to_owned(),
            ..Default::default()
        };
        let mut names = Vec::new();
        for _ in 0..2 {
            let made = client.first(super::CREATE, request.clone()).await;
            let made: wire::CreateSessionResponse = made.unwrap().unwrap();
            names.push(made.session.unwrap().name);
        }
        assert_eq!(names[0], names[1]);
        assert_eq!(client.sessions().await.unwrap(), names[..1]);
        let refused = client.create(&block, "").await.unwrap_err();
        assert_eq!(reason(&refused), "SESSION_LIMIT");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn owners_outlive_the_server_in_the_data_folder() {
    let mut tokens = Tokens::new("stored-owners");
    let shown = [
        tokens.add("line-1", Role::Solve),
        tokens.add("line-2", Role::Solve),
    ];
    let data = tokens.folder().join("data").to_str().unwrap().to_owned();
    let config = Config {
        data,
        ..tokens.config()
    };
    let block = Block::new(1);
    let mut server = Server::with(config.clone()).await;
    let mine = Client::of(&server, &shown[0]);
    let mesh = mine.upload(&block).await.unwrap().mesh.unwrap().name;
    let session = mine.create(&block, "kept-1").await.unwrap();
    server.signal_stop();
    server.stopped().await.unwrap();
    let mut server = Server::with(config.clone()).await;
    let [mine, others] = [&shown[0], &shown[1]].map(|token| Client::of(&server, token));
    let path = "/signorini.v1.MeshService/GetMesh";
    for _ in 0..2 {
        assert!(others.sessions().await.unwrap().is_empty());
        let said = refusal(&others, GET, &session).await;
        assert_eq!(said.as_deref(), Some("SESSION_NOT_FOUND"));
        assert!(refusal(&others, path, &mesh).await.is_some());
        // Awake in the second round.
        assert_eq!(
            mine.sessions().await.unwrap(),
            std::slice::from_ref(&session)
        );
        assert_eq!(refusal(&mine, GET, &session).await, None);
        assert_eq!(refusal(&mine, path, &mesh).await, None);
    }
    server.signal_stop();
    server.stopped().await.unwrap();
    // A server that asks nobody shows all of a folder to all.
    let open = Config {
        tokens: String::new(),
        ..config
    };
    let server = Server::with(open).await;
    assert_eq!(server.describe(&session).await.name, session);
}
