//! What one client may have of a server.

use signorini_proto::array;
use signorini_proto::v1::{self as wire, surface_service_client::SurfaceServiceClient};
use signorini_server::Config;
use tonic::{Code, Status};
use tonic_types::StatusExt as _;

use crate::common::{Block, Server, reason};

async fn create(server: &Server, block: &Block) -> Result<String, Status> {
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ..Default::default()
    };
    let made = server.sessions().create_session(request).await?;
    Ok(made.into_inner().session.unwrap().name)
}

async fn list(server: &Server) -> Result<(), Status> {
    let request = wire::ListSessionsRequest::default();
    server.sessions().list_sessions(request).await.map(drop)
}

fn asks_to_come_again(refused: &Status, said: &str) {
    assert_eq!(refused.code(), Code::ResourceExhausted);
    assert_eq!(reason(refused), said);
    assert!(refused.get_details_retry_info().is_some());
}

#[tokio::test]
async fn sessions_of_one_client_hold_no_more_than_they_may() {
    let server = Server::start().await;
    let block = Block::new(2);
    server.upload(&block).await;
    let session = create(&server, &block).await.unwrap();
    let bytes = server.describe(&session).await.memory_bytes;
    drop(server);
    let config = Config {
        maximum_client_bytes: 4 * u64::try_from(bytes).unwrap(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    server.upload(&block).await;
    let mut made = Vec::new();
    let refused = loop {
        match create(&server, &block).await {
            Ok(session) => made.push(session),
            Err(refused) => break refused,
        }
        assert!(made.len() < 20);
    };
    asks_to_come_again(&refused, "MEMORY_BUDGET");
    assert!(!made.is_empty());
    for name in made {
        let request = wire::DeleteSessionRequest { name };
        server.sessions().delete_session(request).await.unwrap();
    }
    create(&server, &block).await.unwrap();
}

/// A tool of triangles that is like no other.
pub(crate) fn tetrahedron(height: f64) -> Vec<wire::UploadSurfaceRequest> {
    use wire::upload_surface_request::Part;
    let header = wire::SurfaceHeader {
        vertex_count: 4,
        facet_count: 4,
        ..Default::default()
    };
    let chunk = |array: wire::SurfaceArray, data| {
        Part::Chunk(wire::SurfaceChunk {
            array: array.into(),
            offset_elements: 0,
            data,
        })
    };
    let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., height];
    let facets = [0_i32, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let parts = [
        Part::Header(header),
        chunk(wire::SurfaceArray::Coordinates, array::encode(&corners)),
        chunk(wire::SurfaceArray::Facets, array::encode(&facets)),
    ];
    parts
        .map(|part| wire::UploadSurfaceRequest { part: Some(part) })
        .into()
}

#[tokio::test]
async fn tools_and_sessions_of_one_client_count_together() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let session = create(&server, &block).await.unwrap();
    let bytes = server.describe(&session).await.memory_bytes;
    drop(server);
    let config = Config {
        maximum_client_bytes: 2 * u64::try_from(bytes).unwrap(),
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    server.upload(&block).await;
    let mut tools = SurfaceServiceClient::new(server.channel.clone());
    let mut sent = Vec::new();
    let refused = loop {
        let parts = tokio_stream::iter(tetrahedron(1.0 + sent.len() as f64));
        match tools.upload_surface(parts).await {
            Ok(made) => sent.push(made.into_inner().surface.unwrap().name),
            Err(refused) => break refused,
        }
        assert!(sent.len() < 2000);
    };
    asks_to_come_again(&refused, "MEMORY_BUDGET");
    let refused = create(&server, &block).await.unwrap_err();
    asks_to_come_again(&refused, "MEMORY_BUDGET");
    for name in sent {
        let request = wire::DeleteSurfaceRequest { name };
        tools.delete_surface(request).await.unwrap();
    }
    create(&server, &block).await.unwrap();
}

#[tokio::test]
async fn calls_of_one_client_beyond_its_rate_are_told_to_come_again() {
    let config = Config {
        maximum_client_calls_per_second: 2,
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    let mut answered = 0;
    let refused = loop {
        match list(&server).await {
            Ok(()) => answered += 1,
            Err(refused) => break refused,
        }
        assert!(answered < 1000);
    };
    // A burst of two seconds, and what has come back meanwhile.
    assert!(answered >= 4, "{answered}");
    asks_to_come_again(&refused, "CALL_RATE");
    // Health is no call of a client.
    let mut health = tonic_health::pb::health_client::HealthClient::new(server.channel.clone());
    for _ in 0..20 {
        let request = tonic_health::pb::HealthCheckRequest::default();
        health.check(request).await.unwrap();
    }
    let answered = async {
        while list(&server).await.is_err() {
            tokio::time::sleep(std::time::Duration::from_millis(50)).await;
        }
    };
    let answered = tokio::time::timeout(std::time::Duration::from_secs(20), answered).await;
    answered.unwrap();
}

#[tokio::test]
async fn sessions_are_counted_by_user_over_all_connections() {
    let few = Config {
        maximum_client_sessions: 2,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(few).await, Block::new(1));
    server.upload(&block).await;
    let first = create(&server, &block).await.unwrap();
    let other = Server::beside(&server.url).await;
    create(&other, &block).await.unwrap();
    for one in [&server, &other] {
        asks_to_come_again(&create(one, &block).await.unwrap_err(), "SESSION_LIMIT");
    }
    let request = wire::DeleteSessionRequest { name: first };
    server.sessions().delete_session(request).await.unwrap();
    create(&other, &block).await.unwrap();
}
