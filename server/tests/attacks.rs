//! All bad clients at once, for some seconds: memory stays in its bound, health answers, a good
//! client gets every answer. And a server that is used for a while holds no more than before.
//!
//! The figures that are promised are measured by the scripts of `tests/benches/service`, on a
//! release and for longer.

mod common;

use std::time::{Duration, Instant};

use common::{Block, Process, Server, Stream, folder, open, press};
use signorini_proto::v1::{self as wire, solve_response::Message, upload_mesh_request::Part};
use tokio::task::JoinSet;
use tonic::client::Grpc;
use tonic_health::pb::{HealthCheckRequest, health_client::HealthClient};
use tonic_prost::ProstCodec;

const BUDGET: u64 = 200_000_000;
/// What the process may hold at that budget.
const MOST: u64 = BUDGET + BUDGET * 15 / 100 + 60_000_000;
const TIME: Duration = Duration::from_secs(20);
/// No promise, but far from no answer: the build is slow and the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(10);

/// A request for a session whose scene is given in bytes.
#[derive(Clone, PartialEq, prost::Message)]
struct Bomb {
    #[prost(bytes = "bytes", tag = "1")]
    scene: bytes::Bytes,
    #[prost(string, tag = "3")]
    request_id: String,
}

/// Every field there is.
fn all_fields() -> Vec<i32> {
    (1..=13).collect()
}

/// Asks for all fields of very many results and reads none.
async fn writer(server: Server, block: Block) {
    let name = server.session(block.scene()).await;
    let opening = wire::SolveOpen {
        fields: all_fields(),
        max_unread_bytes: 1 << 30,
        ..open(&name)
    };
    let stream = server.stream(opening).await;
    stream.step(1, press(0.02, 100_000)).await;
    std::future::pending::<()>().await;
    drop(stream);
}

/// 2.7 MiB of empty sub-messages, again and again.
async fn bomber(server: Server, scene: bytes::Bytes) {
    let bomb = Bomb {
        scene,
        request_id: "bomb".into(),
    };
    loop {
        let mut client = Grpc::new(server.channel.clone());
        client.ready().await.unwrap();
        let path = "/signorini.v1.SessionService/CreateSession"
            .parse()
            .unwrap();
        let request = tonic::Request::new(bomb.clone());
        let codec = ProstCodec::<Bomb, wire::CreateSessionResponse>::default();
        let refused = client.unary(request, path, codec).await;
        assert!(refused.is_err());
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

/// Announces a mesh that takes most of the budget and sends eight bytes a second.
async fn uploader(server: Server) {
    let header = wire::MeshHeader {
        cell_kind: wire::CellKind::Tetrahedron.into(),
        vertex_count: 900_000,
        cell_count: 2_500_000,
        ..Default::default()
    };
    let (sender, receiver) = tokio::sync::mpsc::channel(1);
    let parts = tokio_stream::wrappers::ReceiverStream::new(receiver);
    let send = async move {
        let mut part = Part::Header(header);
        for offset in 0.. {
            let message = wire::UploadMeshRequest { part: Some(part) };
            if sender.send(message).await.is_err() {
                return;
            }
            tokio::time::sleep(Duration::from_secs(1)).await;
            part = Part::Chunk(wire::MeshChunk {
                array: wire::MeshArray::Coordinates.into(),
                offset_elements: offset,
                data: vec![0; 8].into(),
                ..Default::default()
            });
        }
    };
    let mut meshes = server.meshes();
    // Whether it is refused or goes on is not what is asked.
    let (_outcome, ()) = tokio::join!(meshes.upload_mesh(parts), send);
}

/// Plans a large body, again and again.
async fn planner(server: Server, scene: wire::Scene) {
    loop {
        let request = wire::CreateSessionRequest {
            scene: Some(scene.clone()),
            validate_only: true,
            ..Default::default()
        };
        let _refused = server.sessions().create_session(request).await;
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A body pressed through, in very many increments.
async fn presser(server: Server, block: Block) {
    loop {
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            ..Default::default()
        };
        if let Ok(made) = server.sessions().create_session(request).await {
            let name = made.into_inner().session.unwrap().name;
            let mut stream = server.stream(open(&name)).await;
            stream.step(1, press(0.7, 1000)).await;
            while stream.try_next().await.is_ok() {}
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
}

/// Bad clients of all kinds, each on a connection of its own, until the set is dropped.
async fn attack(process: &Process) -> JoinSet<()> {
    let [small, block, large] = [2, 8, 16].map(Block::new);
    let own = process.connect().await;
    for block in [&small, &block, &large] {
        own.upload(block).await;
    }
    let scene = bytes::Bytes::from([0x52, 0].repeat(1_400_000));
    let mut bad = JoinSet::new();
    for _ in 0..2 {
        bad.spawn(writer(process.connect().await, Block::new(8)));
    }
    for _ in 0..40 {
        bad.spawn(bomber(process.connect().await, scene.clone()));
    }
    for _ in 0..4 {
        bad.spawn(uploader(process.connect().await));
    }
    for _ in 0..64 {
        bad.spawn(planner(process.connect().await, large.scene()));
    }
    for _ in 0..3 {
        bad.spawn(presser(process.connect().await, Block::new(8)));
    }
    for _ in 0..12 {
        bad.spawn(presser(process.connect().await, Block::new(2)));
    }
    bad
}

/// A session of the good client, made before the others come.
async fn good(process: &Process) -> (Server, Stream) {
    let (server, block) = (process.connect().await, Block::new(1));
    server.upload(&block).await;
    let name = server.session(block.scene()).await;
    let stream = server.open(open(&name)).await;
    (server, stream)
}

#[tokio::test(flavor = "multi_thread")]
async fn all_bad_clients_together_leave_memory_health_and_a_good_client() {
    let settings = format!("memory_budget_bytes = {BUDGET}\n");
    let process = Process::start(&folder("attacks"), &settings);
    let (_good, mut stream) = good(&process).await;
    let mut health = HealthClient::new(process.connect().await.channel);
    let _bad = attack(&process).await;
    let (begun, mut most, mut answered) = (Instant::now(), 0, 0);
    while begun.elapsed() < TIME {
        let asked = health.check(HealthCheckRequest::default());
        let asked = tokio::time::timeout(PATIENCE, asked).await;
        asked.expect("health answers").unwrap();
        most = process.resident().max(most);
        answered += 1;
        stream.press(answered, 0.001 * (answered % 10) as f64).await;
        let result = tokio::time::timeout(2 * PATIENCE, stream.result()).await;
        assert_eq!(result.expect("an answer").sequence, answered);
    }
    assert!(answered > 20, "{answered} updates");
    assert!(most <= MOST, "{most} bytes of {MOST}");
    assert!(most > BUDGET / 4, "{most} bytes: no attack at all");
}

/// Four times as many updates at once as may wait, twenty times over; how soon each was
/// refused that was.
async fn flood(server: Server, name: String) -> (i64, Vec<Duration>) {
    const BURST: i64 = 16;
    let mut stream = server.open(open(&name)).await;
    let (mut answered, mut refused) = (0, Vec::new());
    for _ in 0..20 {
        let begun = Instant::now();
        for sequence in answered + 1..=answered + BURST {
            stream.press(sequence, 0.001 * (sequence % 10) as f64).await;
        }
        let mut left = BURST;
        while left > 0 {
            match stream.next().await {
                Message::StepFinished(result) => {
                    assert_eq!(result.sequence, answered + 1);
                    answered += 1;
                    left -= 1;
                }
                Message::UpdateRejected(_) => {
                    refused.push(begun.elapsed());
                    left -= 1;
                }
                Message::Iteration(_) | Message::Heartbeat(_) => {}
                other @ (Message::Opened(_) | Message::Field(_)) => panic!("{other:?}"),
            }
        }
    }
    let session = server.describe(&name).await;
    let found = (
        session.last_accepted_sequence,
        session.last_finished_sequence,
    );
    assert_eq!(found, (answered, answered), "accepted, finished");
    (answered, refused)
}

#[tokio::test(flavor = "multi_thread")]
async fn too_much_work_is_refused_soon_and_every_accepted_update_is_answered_once() {
    let process = Process::start(&folder("overload"), "maximum_in_flight = 4\n");
    let (server, block) = (process.connect().await, Block::new(2));
    server.upload(&block).await;
    let mut floods = JoinSet::new();
    for _ in 0..8 {
        let name = server.session(block.scene()).await;
        floods.spawn(flood(process.connect().await, name));
    }
    let (mut answered, mut refused) = (0, Vec::new());
    while let Some(one) = floods.join_next().await {
        let (count, times) = one.unwrap();
        answered += count;
        refused.extend(times);
    }
    refused.sort_unstable();
    assert!(
        answered > 160 && refused.len() > 500,
        "{answered}, {}",
        refused.len()
    );
    let late = refused[refused.len() * 99 / 100];
    assert!(late < Duration::from_secs(2), "{late:?}");
}

/// Sessions that are used and then deleted, or left.
async fn sessions(server: &Server, block: &Block, left: bool) {
    for _ in 0..15 {
        let name = server.session(block.scene()).await;
        let opening = wire::SolveOpen {
            fields: all_fields(),
            ..open(&name)
        };
        let mut stream = server.open(opening).await;
        stream.step(1, press(0.01, 4)).await;
        for _ in 0..4 {
            stream.result().await;
        }
        stream.half_close();
        assert!(stream.end().await.is_none());
        if !left {
            let request = wire::DeleteSessionRequest { name };
            server.sessions().delete_session(request).await.unwrap();
        }
    }
}

/// Whether memory has grown by more than it may.
fn has_grown(before: u64, after: u64) -> bool {
    after.saturating_sub(before) > (before / 20).max(32 << 20)
}

#[tokio::test(flavor = "multi_thread")]
async fn sessions_that_are_deleted_leave_no_memory_behind_and_those_that_stay_are_found() {
    let process = Process::start(&folder("soak"), "");
    let (server, block) = (process.connect().await, Block::new(5));
    server.upload(&block).await;
    sessions(&server, &block, false).await;
    let before = process.resident();
    for _ in 0..2 {
        sessions(&server, &block, false).await;
    }
    let after = process.resident();
    assert!(!has_grown(before, after), "{before} to {after}");
    for _ in 0..8 {
        sessions(&server, &block, true).await;
        if has_grown(before, process.resident()) {
            return;
        }
    }
    panic!("{before} to {}: no leak is seen", process.resident());
}
