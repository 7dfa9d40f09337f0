//! Every method with every role, and without any.

use prost::Message as _;
use prost_types::FileDescriptorSet;
use signorini_proto::FILE_DESCRIPTOR_SET;
use signorini_proto::v1::{self as wire, solve_request::Message};
use signorini_server::{Config, Role};
use tonic::Code;

use super::{Client, HEALTH, Tokens, soon};
use crate::common::{Block, Process, Server, open, reason};

const SOLVE: &str = "/signorini.v1.SessionService/Solve";
const REFLECTION: &str = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";

/// Methods that change something; a reader may call all others.
const CHANGING: [&str; 12] = [
    "UploadMesh",
    "DeleteMesh",
    "RefineMesh",
    "UploadSurface",
    "DeleteSurface",
    "CreateSession",
    "DeleteSession",
    "Solve",
    "CancelStep",
    "SaveState",
    "RestoreState",
    "ImportState",
];

#[tokio::test]
async fn a_refusal_for_want_of_a_role_and_a_cancel_in_a_stream_are_told_by_name() {
    let mut tokens = Tokens::new("audit");
    let reader = tokens.add("screen", Role::Read);
    let solver = tokens.add("line-1", Role::Solve);
    let process = Process::start(tokens.folder(), &format!("tokens = {:?}\n", tokens.path));
    let server = process.connect().await;
    let refused = Client::of(&server, &reader).upload(&Block::new(1)).await;
    assert_eq!(refused.unwrap_err().code(), Code::PermissionDenied);
    let (client, block) = (Client::of(&server, &solver), Block::new(1));
    client.upload(&block).await.unwrap();
    let session = client.create(&block, "line-1-a").await.unwrap();
    let cancel = wire::SolveCancel { sequence: 1 };
    let messages = [Message::Open(open(&session)), Message::Cancel(cancel)];
    let messages = messages.map(|message| wire::SolveRequest {
        message: Some(message),
    });
    let mut stream = client
        .call::<_, wire::SolveResponse>(SOLVE, messages.to_vec())
        .await
        .unwrap();
    while stream.message().await.unwrap().is_some() {}
    let log = std::fs::read_to_string(tokens.folder().join("log")).unwrap();
    for parts in [
        [
            "who=screen, ",
            "\"MeshService/UploadMesh\"",
            "\"PermissionDenied\"",
        ],
        [
            "who=line-1, ",
            "\"SessionService/Solve: cancel\"",
            "about=\"sessions/line-1-a\"",
        ],
    ] {
        let is_it = |line: &str| parts.iter().all(|part| line.contains(part));
        assert!(log.lines().any(is_it), "{parts:?} in\n{log}");
    }
}

/// Methods of the contract, and of reflection.
pub(super) fn methods() -> Vec<(String, Role)> {
    let mut all = vec![(REFLECTION.to_owned(), Role::Read)];
    for file in FileDescriptorSet::decode(FILE_DESCRIPTOR_SET).unwrap().file {
        for service in &file.service {
            for method in &service.method {
                let path = format!("/{}.{}/{}", file.package(), service.name(), method.name());
                let role = if CHANGING.contains(&method.name()) {
                    Role::Solve
                } else {
                    Role::Read
                };
                all.push((path, role));
            }
        }
    }
    all
}

/// How a call with an empty message is refused for its role; other refusals are none.
pub(super) async fn refused(client: &Client, path: &str) -> Option<String> {
    let status = client.first::<(), ()>(path, ()).await.err()?;
    let of_role = [Code::Unauthenticated, Code::PermissionDenied];
    of_role.contains(&status.code()).then(|| reason(&status))
}

#[tokio::test(flavor = "multi_thread")]
async fn every_method_asks_for_its_role_and_takes_those_above() {
    let mut tokens = Tokens::new("roles");
    let revoked = tokens.add("gone", Role::Admin);
    let [reader, solver, admin] =
        [Role::Read, Role::Solve, Role::Admin].map(|role| (role, tokens.add(role.name(), role)));
    tokens.revoke("gone");
    let server = Server::with(tokens.config()).await;
    let stranger = Client {
        token: None,
        ..Client::of(&server, "")
    };
    let unknown = format!("signorini_{}", "0".repeat(64));
    let no_tokens = ["", "x", &unknown, &revoked].map(|token| Client::of(&server, token));
    let methods = methods();
    assert!(methods.len() > CHANGING.len() + 10);
    for (path, needed) in &methods {
        for client in no_tokens.iter().chain([&stranger]) {
            let said = refused(client, path).await;
            assert_eq!(said.as_deref(), Some("UNAUTHENTICATED"), "{path}");
        }
        for (role, token) in [&reader, &solver, &admin] {
            let expected = (role < needed).then_some("PERMISSION_DENIED");
            let said = refused(&Client::of(&server, token), path).await;
            assert_eq!(said.as_deref(), expected, "{path} as {role}");
        }
    }
    assert!(stranger.is_healthy().await);
    let (_, solver) = solver;
    let unserved = Client::of(&server, &solver)
        .first::<(), ()>("/a.B/C", ())
        .await;
    assert_eq!(unserved.unwrap_err().code(), Code::PermissionDenied);
}

#[tokio::test]
async fn reflection_and_health_can_be_closed() {
    let server = Server::with(Config {
        reflection: false,
        health: false,
        ..Config::embedded()
    })
    .await;
    let client = Client {
        token: None,
        ..Client::of(&server, "")
    };
    for path in [REFLECTION, HEALTH] {
        let status = client.first::<(), ()>(path, ()).await.unwrap_err();
        assert_eq!(status.code(), Code::Unimplemented, "{path}");
    }
    assert_eq!(client.sessions().await.unwrap(), Vec::<String>::new());
}

#[tokio::test(flavor = "multi_thread")]
async fn thousands_of_mutated_tokens_are_refused_and_the_true_one_still_works() {
    let mut tokens = Tokens::new("mutated-tokens");
    let token = tokens.add("line-1", Role::Solve);
    let server = Server::with(tokens.config()).await;
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..2000 {
        let mut bytes = token.clone().into_bytes();
        match random.usize(..4) {
            0 => bytes.truncate(random.usize(..bytes.len())),
            1 => bytes.extend(std::iter::repeat_n(b'a', random.usize(1..4000))),
            _ => {}
        }
        for _ in 0..random.usize(1..4) {
            let place = random.usize(..=bytes.len());
            bytes.insert(place, random.u8(0x21..0x7f));
        }
        let text = String::from_utf8(bytes).unwrap();
        let refused = Client::of(&server, &text).sessions().await.unwrap_err();
        assert_eq!(refused.code(), Code::Unauthenticated, "{text}");
    }
    let client = Client::of(&server, &token);
    soon("an answer", async || client.sessions().await.is_ok()).await;
}
