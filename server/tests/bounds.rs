//! What one client can take of the server: memory before it exists, connections,
//! names that a terminal obeys.

mod common;

use std::time::{Duration, Instant};

use common::{Block, Server, open, page, paths, press, reason, sample};
use signorini_proto::v1::{self as wire, upload_mesh_request::Part};
use signorini_server::Config;
use tokio::io::AsyncReadExt as _;
use tonic_types::StatusExt;

fn config() -> Config {
    Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    }
}

async fn figure(server: &Server, series: &str) -> u64 {
    sample(&page(server.metrics_url.as_ref().unwrap()).await, series)
}

/// Waits until a figure of the page is what it should be.
async fn until(server: &Server, series: &str, value: u64) {
    let end = Instant::now() + Duration::from_secs(20);
    loop {
        let found = figure(server, series).await;
        if found == value {
            return;
        }
        assert!(Instant::now() < end, "{series} is {found}, not {value}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

fn request(scene: wire::Scene) -> wire::CreateSessionRequest {
    wire::CreateSessionRequest {
        scene: Some(scene),
        ..Default::default()
    }
}

#[tokio::test]
async fn results_that_nobody_reads_stay_in_the_budget_and_none_is_lost() {
    const BUDGET: u64 = 24 << 20;
    const RESULTS: i32 = 400;
    let small = Config {
        memory_budget_bytes: BUDGET,
        retained_field_bytes: 1 << 20,
        ..config()
    };
    let (server, block) = (Server::with(small).await, Block::new(4));
    server.upload(&block).await;
    let mut scene = block.scene();
    let fields = vec![
        wire::FieldName::Displacement.into(),
        wire::FieldName::Stress.into(),
    ];
    scene.output.get_or_insert_default().fields = fields;
    let session = server.session(scene).await;
    let mut stream = server
        .open(wire::SolveOpen {
            max_unread_bytes: 1 << 30,
            ..open(&session)
        })
        .await;
    stream.step(1, press(0.02, RESULTS)).await;
    let held = "signorini_memory_bytes{kind=\"session\"}";
    let mut most = 0;
    for _ in 0..40 {
        tokio::time::sleep(Duration::from_millis(100)).await;
        most = figure(&server, held).await.max(most);
    }
    assert!(most <= BUDGET, "{most}");
    let unfinished = server.describe(&session).await;
    assert_eq!(
        unfinished.last_finished_sequence, 0,
        "it waits for its reader"
    );
    for increment in 1..=RESULTS {
        let finished = stream.result().await;
        assert_eq!(finished.event, i64::from(increment));
    }
}

#[tokio::test]
async fn a_message_that_becomes_far_larger_is_refused_before_it_is_decoded() {
    let server = Server::with(config()).await;
    let bombs: [fn(&mut wire::Scene); 3] = [
        |scene| scene.obstacles = vec![wire::Obstacle::default(); 1_000_000],
        |scene| scene.supports = vec![wire::Support::default(); 1_000_000],
        |scene| scene.steps = vec![wire::LoadStep::default(); 1_000_000],
    ];
    for bomb in bombs {
        let mut scene = wire::Scene::default();
        bomb(&mut scene);
        let begun = Instant::now();
        let refused = server.sessions().create_session(request(scene)).await;
        let status = refused.unwrap_err();
        assert_eq!(reason(&status), "MESSAGE_LIMIT", "{status:?}");
        assert!(begun.elapsed() < Duration::from_secs(5));
    }
    let session = "sessions/none";
    let mut stream = server.stream(open(session)).await;
    assert_eq!(reason(&stream.end().await.unwrap()), "SESSION_NOT_FOUND");
    until(&server, "signorini_decoding_bytes", 0).await;
    let refused = "signorini_refused_total{reason=\"MESSAGE_LIMIT\"}";
    assert_eq!(figure(&server, refused).await, 3);
}

#[tokio::test]
async fn a_bomb_in_a_stream_ends_it_with_the_reason() {
    let (server, block) = (Server::with(config()).await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    let step = wire::LoadStep {
        obstacles: vec![wire::ObstacleTarget::default(); 1_000_000],
        ..Default::default()
    };
    stream.step(1, step).await;
    assert_eq!(reason(&stream.end().await.unwrap()), "MESSAGE_LIMIT");
    assert!(!server.describe(&session).await.attached);
}

#[tokio::test]
async fn an_upload_takes_memory_as_its_chunks_arrive() {
    let (server, block) = (Server::with(config()).await, Block::new(4));
    let header = wire::MeshHeader {
        digest: String::new(),
        vertex_count: 12_000_000,
        cell_count: 30_000_000,
        ..block.header()
    };
    let chunk = wire::MeshChunk {
        array: wire::MeshArray::Coordinates.into(),
        data: vec![0; 8].into(),
        ..Default::default()
    };
    let (parts, inbound) = tokio::sync::mpsc::channel(4);
    for part in [Part::Header(header), Part::Chunk(chunk)] {
        let message = wire::UploadMeshRequest { part: Some(part) };
        parts.send(message).await.unwrap();
    }
    let mut client = server.meshes();
    let inbound = tokio_stream::wrappers::ReceiverStream::new(inbound);
    let upload = tokio::spawn(async move { client.upload_mesh(inbound).await });
    until(&server, "signorini_uploads", 1).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    let held = figure(&server, "signorini_memory_bytes{kind=\"session\"}").await;
    assert!(held < 1 << 20, "{held}");
    upload.abort();
    until(&server, "signorini_uploads", 0).await;
}

#[tokio::test]
async fn names_that_a_terminal_obeys_are_refused() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    for bad in ["\u{1b}]0;title\u{7}", "a\rb", "a\nb", "\u{9b}2J"] {
        let mut scene = block.scene();
        scene.name = bad.into();
        let status = server.sessions().create_session(request(scene)).await;
        let status = status.unwrap_err();
        assert_eq!(reason(&status), "SCENE_INVALID", "{bad:?}");
        assert_eq!(paths(&status), ["name"], "{bad:?}");
        let mut header = block.header();
        header.digest = String::new();
        header.groups[0].name = bad.into();
        let part = Some(Part::Header(header));
        let parts = tokio_stream::iter([wire::UploadMeshRequest { part }]);
        let status = server.meshes().upload_mesh(parts).await.unwrap_err();
        assert_eq!(reason(&status), "REQUEST_INVALID", "{bad:?}");
    }
}

#[tokio::test]
async fn whoever_is_refused_for_want_of_room_is_told_when_to_come_again() {
    let few = Config {
        maximum_sessions: 1,
        ..config()
    };
    let (server, block) = (Server::with(few).await, Block::new(1));
    server.upload(&block).await;
    server.session(block.scene()).await;
    let mut waits = Vec::new();
    for _ in 0..20 {
        let status = server
            .sessions()
            .create_session(request(block.scene()))
            .await;
        let status = status.unwrap_err();
        assert_eq!(reason(&status), "SESSION_LIMIT");
        waits.push(
            status
                .get_details_retry_info()
                .unwrap()
                .retry_delay
                .unwrap(),
        );
    }
    assert!(waits.iter().all(|wait| *wait >= Duration::from_millis(500)));
    waits.sort();
    waits.dedup();
    assert!(waits.len() > 10, "{waits:?}");
}

#[tokio::test]
async fn one_client_has_half_of_the_connections_and_a_silent_one_is_closed() {
    let few = Config {
        maximum_connections: 6,
        ..config()
    };
    let server = Server::with(few).await;
    let address = server.url.strip_prefix("http://").unwrap();
    let mut silent = Vec::new();
    for _ in 0..2 {
        silent.push(tokio::net::TcpStream::connect(address).await.unwrap());
    }
    until(&server, "signorini_connections", 3).await;
    let mut beyond = tokio::net::TcpStream::connect(address).await.unwrap();
    // Closed at once: by end or by reset.
    assert_eq!(beyond.read(&mut [0; 64]).await.unwrap_or(0), 0);
    let away = |why: &str| format!("signorini_connections_turned_away_total{{reason=\"{why}\"}}");
    assert_eq!(figure(&server, &away("client")).await, 1);
    // The one that speaks stays.
    until(&server, "signorini_connections", 1).await;
    assert_eq!(figure(&server, &away("silent")).await, 2);
}

#[tokio::test]
async fn a_stream_that_names_no_session_is_counted_and_ends() {
    let server = Server::with(config()).await;
    let (_updates, outbound) = tokio::sync::mpsc::channel::<wire::SolveRequest>(1);
    let outbound = tokio_stream::wrappers::ReceiverStream::new(outbound);
    let call = server.sessions().solve(outbound).await;
    assert_eq!(figure(&server, "signorini_streams").await, 1);
    let status = call.unwrap().into_inner().message().await.unwrap_err();
    assert_eq!(reason(&status), "REQUEST_INVALID");
    assert_eq!(paths(&status), ["open"]);
    until(&server, "signorini_streams", 0).await;
}

#[tokio::test]
async fn a_shutdown_takes_its_time_once_whatever_clients_do() {
    let quick = Config {
        drain_seconds: 2,
        ..config()
    };
    let (mut server, block) = (Server::with(quick).await, Block::new(3));
    server.upload(&block).await;
    let mut scene = block.scene();
    let fields = vec![
        wire::FieldName::Displacement.into(),
        wire::FieldName::Stress.into(),
    ];
    scene.output.get_or_insert_default().fields = fields;
    let session = server.session(scene).await;
    // This writer reads nothing, and this stream names no session.
    let unread = server.open(open(&session)).await;
    unread.step(1, press(0.02, 10_000)).await;
    let (_updates, outbound) = tokio::sync::mpsc::channel::<wire::SolveRequest>(1);
    let outbound = tokio_stream::wrappers::ReceiverStream::new(outbound);
    let _nameless = server.sessions().solve(outbound).await.unwrap();
    tokio::time::sleep(Duration::from_millis(500)).await;
    let asked = Instant::now();
    server.signal_stop();
    server.stopped().await.unwrap();
    let took = asked.elapsed();
    assert!(took < Duration::from_millis(3500), "{took:?}");
}
