//! What operators rely on: metrics, health, reflection, shutdown, Unix sockets.

mod common;

use std::time::Duration;

use common::{Block, Server, open, page, press, reason, sample};
use signorini_proto::v1 as wire;
use signorini_server::Config;
use tonic_health::pb::health_client::HealthClient;
use tonic_health::pb::{HealthCheckRequest, health_check_response::ServingStatus};

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(30);

async fn list(server: &Server) -> Vec<wire::Session> {
    let request = wire::ListSessionsRequest::default();
    let response = server.sessions().list_sessions(request).await.unwrap();
    response.into_inner().sessions
}

async fn health(server: &Server, service: &str) -> ServingStatus {
    let request = HealthCheckRequest {
        service: service.into(),
    };
    let mut client = HealthClient::new(server.channel.clone());
    client.check(request).await.unwrap().into_inner().status()
}

#[tokio::test]
async fn the_metrics_page_counts_what_happened_and_has_no_summaries() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    server.upload(&block).await;
    for _ in 0..2 {
        let session = server.session(block.scene()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.02, 2)).await;
        while !stream.result().await.last {}
    }
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    assert!(!page.contains(" summary"));
    assert_eq!(
        sample(&page, "signorini_steps_total{termination=\"converged\"}"),
        2
    );
    assert_eq!(
        sample(
            &page,
            "signorini_increments_total{termination=\"converged\"}"
        ),
        4
    );
    assert_eq!(
        sample(&page, "signorini_cache_hits_total{kind=\"prepared\"}"),
        1
    );
    assert_eq!(
        sample(&page, "signorini_cache_misses_total{kind=\"prepared\"}"),
        1
    );
    assert_eq!(sample(&page, "signorini_sessions"), 2);
    assert_eq!(sample(&page, "signorini_meshes"), 1);
    assert!(sample(&page, "signorini_iterations_total") > 0);
    assert!(sample(&page, "signorini_memory_bytes{kind=\"prepared\"}") > 0);
    assert_eq!(sample(&page, "signorini_krylov_iterations_count"), 4);
}

#[tokio::test]
async fn health_knows_the_services() {
    let server = Server::start().await;
    for service in [
        "",
        "signorini.v1.MeshService",
        "signorini.v1.SessionService",
    ] {
        assert_eq!(
            health(&server, service).await,
            ServingStatus::Serving,
            "{service}"
        );
    }
}

#[tokio::test]
async fn shutdown_delivers_the_last_state_ends_the_streams_and_returns() {
    let (mut server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    server.signal_stop();
    let last = loop {
        let finished = stream.result().await;
        if finished.last {
            break finished.report.unwrap();
        }
    };
    assert_eq!(last.termination(), wire::Termination::Cancelled);
    assert_eq!(reason(&stream.end().await.unwrap()), "SHUTTING_DOWN");
    server.stopped().await.unwrap();
}

#[tokio::test]
async fn a_unix_socket_serves_the_same() {
    let path = std::env::temp_dir().join(format!("signorini-op-{}.sock", std::process::id()));
    let listen = format!("unix:{}", path.display());
    let config = Config {
        listen: listen.clone(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    assert_eq!(server.url, listen);
    server.upload(&Block::new(1)).await;
}

#[tokio::test]
async fn reflection_lists_the_services() {
    use tonic_reflection::pb::v1::server_reflection_client::ServerReflectionClient;
    use tonic_reflection::pb::v1::server_reflection_request::MessageRequest;
    use tonic_reflection::pb::v1::server_reflection_response::MessageResponse;
    let server = Server::start().await;
    let request = tonic_reflection::pb::v1::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(MessageRequest::ListServices(String::new())),
    };
    let mut client = ServerReflectionClient::new(server.channel.clone());
    let answers = client
        .server_reflection_info(tokio_stream::iter([request]))
        .await
        .unwrap();
    let answer = answers.into_inner().message().await.unwrap().unwrap();
    let Some(MessageResponse::ListServicesResponse(list)) = answer.message_response else {
        panic!("a list of services is due");
    };
    let names: Vec<_> = list
        .service
        .into_iter()
        .map(|service| service.name)
        .collect();
    assert!(
        names.contains(&"signorini.v1.SessionService".to_owned()),
        "{names:?}"
    );
}

#[tokio::test]
async fn sessions_expire_when_nobody_uses_them() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ttl: Some(prost_types::Duration {
            seconds: 0,
            nanos: 50_000_000,
        }),
        ..Default::default()
    };
    let created = server
        .sessions()
        .create_session(request)
        .await
        .unwrap()
        .into_inner();
    let name = created.session.unwrap().name;
    // Asked again and again: listing renews no session.
    let gone = async {
        while !list(&server).await.is_empty() {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(PATIENCE, gone)
        .await
        .expect("the session expires");
    let request = wire::GetSessionRequest { name };
    let status = server.sessions().get_session(request).await.unwrap_err();
    assert_eq!(reason(&status), "SESSION_EXPIRED");
}
