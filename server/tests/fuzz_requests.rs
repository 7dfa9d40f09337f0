//! No bytes of a request bring the server down: each is answered, or refused
//! with a reason, within a budget of memory, and good requests work afterwards.

#[allow(dead_code, reason = "campaigns of calls run by themselves")]
#[path = "../../client/tests/common/fuzz/mod.rs"]
mod fuzz;

mod common;
#[path = "fuzz_requests/uploads.rs"]
mod uploads;

use std::time::Duration;

use bytes::{Buf, BufMut, Bytes};
use common::{Block, Server, open, press};
use fuzz::memory::Budget;
use fuzz::{Campaign, Corpus, Form};
use prost::Message;
use signorini_proto::v1 as wire;
use signorini_server::Config;
use tonic::client::Grpc;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::transport::Channel;
use tonic::{Request, Status};
use tonic_types::StatusExt;
use uploads::{framed, import, surfaces, unframed};

/// Only ever reached by a server that hangs.
const HANGS: Duration = Duration::from_secs(30);
/// How long an answer of a stream that may go on is waited for.
const LOOK: Duration = Duration::from_millis(20);
/// Tags and lengths of nested messages, and names of the seeds.
const WORDS: [&str; 7] = [
    "\n\u{0}",
    "\u{1a}\u{2}",
    "*\u{0}",
    "R\u{4}",
    "\u{8}\u{1}",
    "\n\u{4}body",
    "\u{12}\u{3}top",
];

/// Messages as their bytes, whatever they are.
struct Raw;

impl Codec for Raw {
    type Encode = Bytes;
    type Decode = Bytes;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = Bytes;
    type Error = Status;

    fn encode(&mut self, item: Bytes, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        out.put(item);
        Ok(())
    }
}

impl Decoder for Raw {
    type Item = Bytes;
    type Error = Status;

    fn decode(&mut self, input: &mut DecodeBuf<'_>) -> Result<Option<Bytes>, Status> {
        Ok(Some(input.copy_to_bytes(input.remaining())))
    }
}

/// How often a method is tried, its path, and good requests for it.
struct Method {
    weight: usize,
    path: &'static str,
    corpus: Corpus,
}

fn method(weight: usize, path: &'static str, seeds: Vec<Vec<u8>>) -> Method {
    let corpus = Corpus::new(Form::Messages, seeds, &WORDS);
    Method {
        weight,
        path,
        corpus,
    }
}

fn creation(scene: wire::Scene, validate_only: bool) -> Vec<u8> {
    let request = wire::CreateSessionRequest {
        scene: Some(scene),
        validate_only,
        ttl: common::duration(60_000),
        ..Default::default()
    };
    request.encode_to_vec()
}

/// A scene that uses every list.
fn full_scene(block: &Block) -> wire::Scene {
    let mut scene = block.scene();
    scene.tractions = vec![wire::Traction {
        on: vec!["top".into()],
        value: vec![0.0, 0.0, -0.1],
        name: "wind".into(),
        values: None,
    }];
    scene.probes = vec![wire::Probe {
        name: "middle".into(),
        point: vec![0.5, 0.5, 0.5],
    }];
    scene.steps = vec![press(0.01, 2)];
    scene.output.get_or_insert_default().fields = vec![1, 2, 3];
    scene
}

fn named(name: &str) -> Vec<u8> {
    // All requests with a name have it as their first field.
    wire::GetSessionRequest { name: name.into() }.encode_to_vec()
}

/// Methods of states and surfaces, and `Watch`.
fn further_methods(session: &str, state: &[u8], surface: &str) -> Vec<Method> {
    let restore = wire::RestoreStateRequest {
        name: session.into(),
        save: 1,
    };
    let watch = common::watch(session, wire::WatchEnd::Idle).encode_to_vec();
    let uploads = surfaces().map(|messages| framed(&messages)).to_vec();
    vec![
        method(1, "SessionService/Watch", vec![watch]),
        method(1, "SessionService/ExportState", vec![named(session)]),
        method(
            2,
            "SessionService/ImportState",
            vec![framed(&import(state))],
        ),
        method(1, "SessionService/SaveState", vec![named(session)]),
        method(
            1,
            "SessionService/RestoreState",
            vec![restore.encode_to_vec()],
        ),
        method(3, "SurfaceService/UploadSurface", uploads),
        method(1, "SurfaceService/GetSurface", vec![named(surface)]),
        method(1, "SurfaceService/ListSurfaces", vec![Vec::new()]),
        method(1, "SurfaceService/DeleteSurface", vec![named(surface)]),
    ]
}

fn methods(session: &str, block: &Block) -> Vec<Method> {
    let mesh = format!("meshes/{}", block.digest());
    let plans = vec![
        creation(full_scene(block), true),
        creation(block.scene(), true),
    ];
    let read = wire::ReadStepRequest {
        name: session.into(),
        sequence: 1,
        increment: 1,
        fields: vec![1, 2],
        element_type: 2,
    };
    let cancel = wire::CancelStepRequest {
        name: session.into(),
        sequence: 1,
    };
    let page = wire::ListMeshesRequest {
        page_size: 10,
        page_token: mesh.clone(),
    };
    vec![
        method(10, "SessionService/CreateSession", plans),
        method(
            1,
            "SessionService/CreateSession",
            vec![creation(block.scene(), false)],
        ),
        method(
            6,
            "MeshService/UploadMesh",
            vec![framed(&Block::new(1).messages())],
        ),
        method(1, "SessionService/GetSession", vec![named(session)]),
        method(
            1,
            "SessionService/DeleteSession",
            vec![named("sessions/nobody")],
        ),
        method(2, "SessionService/ReadStep", vec![read.encode_to_vec()]),
        method(1, "SessionService/CancelStep", vec![cancel.encode_to_vec()]),
        method(1, "SessionService/ListSessions", vec![page.encode_to_vec()]),
        method(1, "MeshService/ListMeshes", vec![page.encode_to_vec()]),
        method(1, "MeshService/GetMesh", vec![named(&mesh)]),
        method(1, "MeshService/ReadMesh", vec![named(&mesh)]),
        method(1, "MeshService/DeleteMesh", vec![named(&mesh)]),
    ]
}

fn choose<'a>(methods: &'a [Method], rng: &mut fastrand::Rng) -> &'a Method {
    let total: usize = methods.iter().map(|method| method.weight).sum();
    let mut left = rng.usize(..total);
    let chosen = methods
        .iter()
        .find(|method| match left.checked_sub(method.weight) {
            Some(rest) => {
                left = rest;
                false
            }
            None => true,
        });
    chosen.unwrap()
}

/// Sends the input and reads all answers; the last one is returned.
async fn call(channel: &Channel, path: &str, input: &[u8]) -> Result<Bytes, Status> {
    let mut grpc = Grpc::new(channel.clone());
    grpc.ready()
        .await
        .map_err(|error| Status::unknown(error.to_string()))?;
    let messages = match path {
        "MeshService/UploadMesh"
        | "SurfaceService/UploadSurface"
        | "SessionService/ImportState" => unframed(input),
        _ => vec![Bytes::copy_from_slice(input)],
    };
    let is_watch = path == "SessionService/Watch";
    let request = Request::new(tokio_stream::iter(messages));
    let path = PathAndQuery::try_from(format!("/signorini.v1.{path}")).unwrap();
    let mut answers = grpc.streaming(request, path, Raw).await?.into_inner();
    let mut last = Bytes::new();
    loop {
        // Who watches a session to its end waits for others.
        let answer = if is_watch {
            tokio::time::timeout(LOOK, answers.message()).await
        } else {
            Ok(answers.message().await)
        };
        match answer {
            Ok(answer) => match answer? {
                Some(answer) => last = answer,
                None => return Ok(last),
            },
            Err(_) => return Ok(last),
        }
    }
}

/// A refusal says why, in the words of the contract, and fits into trailers.
fn is_of_the_contract(status: &Status) -> bool {
    let info = status.get_details_error_info();
    let known = info.is_some_and(|info| !["", "INTERNAL"].contains(&&*info.reason));
    known && status.message().len() + status.details().len() < 4096
}

/// A server with one session that has finished a step.
async fn prepared(block: &Block) -> (Server, String) {
    let config = Config {
        memory_budget_bytes: 32 << 20,
        solver_slots: 1,
        threads_per_slot: 1,
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    server.upload(block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 1)).await;
    stream.half_close();
    assert!(stream.end().await.is_none());
    (server, session)
}

/// Ends the session that a request has made.
async fn forget(server: &Server, answer: &[u8]) {
    let answer = wire::CreateSessionResponse::decode(answer).unwrap();
    if let Some(session) = answer.session {
        let request = wire::DeleteSessionRequest { name: session.name };
        let deleted = server.sessions().delete_session(request).await;
        // A life of a nanosecond is a request, too.
        let gone = |status: Status| common::reason(&status) == "SESSION_EXPIRED";
        assert!(deleted.err().is_none_or(gone));
    }
}

#[tokio::test]
async fn every_request_is_answered_or_refused_with_a_reason() {
    let block = Block::new(1);
    let (server, session) = prepared(&block).await;
    let state = call(
        &server.channel,
        "SessionService/ExportState",
        &named(&session),
    )
    .await;
    // Small: all of it is in one slice.
    let state = wire::ExportStateResponse::decode(state.unwrap())
        .unwrap()
        .data;
    let uploaded = framed(&surfaces()[0]);
    let surface = call(&server.channel, "SurfaceService/UploadSurface", &uploaded).await;
    let surface = wire::UploadSurfaceResponse::decode(surface.unwrap()).unwrap();
    let mut methods = methods(&session, &block);
    methods.extend(further_methods(
        &session,
        &state,
        &surface.surface.unwrap().name,
    ));
    let (campaign, budget) = (Campaign::from_environment(), Budget::of_mebibytes(96));
    let (mut answered, mut refused) = (0_u64, 0_u64);
    for case in campaign.numbers() {
        let mut rng = campaign.generator(case);
        let method = choose(&methods, &mut rng);
        let input = method.corpus.input(&mut rng);
        let told = || format!("{}\n{}", method.path, campaign.describe(case, &input));
        let outcome = tokio::time::timeout(HANGS, call(&server.channel, method.path, &input));
        match outcome.await {
            Ok(Ok(answer)) if method.path.ends_with("CreateSession") => {
                answered += 1;
                forget(&server, &answer).await;
            }
            Ok(Ok(_)) => answered += 1,
            Ok(Err(status)) => {
                refused += 1;
                assert!(is_of_the_contract(&status), "{status:?}\n{}", told());
            }
            Err(_) => panic!("no answer to {}", told()),
        }
        budget.check_for(told);
    }
    eprintln!("{answered} requests answered, {refused} refused");
    assert!(answered > 0 || refused < 1000);
    let name = server.session(block.scene()).await;
    assert_eq!(server.describe(&name).await.name, name);
}
