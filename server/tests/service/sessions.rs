//! Sessions: planned, created, listed, refused with the paths of faulty keys.

use std::time::Duration;

use crate::common::{Block, Server, open, paths, reason};
use signorini_proto::v1 as wire;
use signorini_server::Config;

async fn refused(server: &Server, scene: wire::Scene) -> tonic::Status {
    let request = wire::CreateSessionRequest {
        scene: Some(scene),
        ..Default::default()
    };
    server.sessions().create_session(request).await.unwrap_err()
}

#[tokio::test]
async fn validate_only_returns_the_plan_and_creates_nothing() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        validate_only: true,
        ..Default::default()
    };
    let response = server
        .sessions()
        .create_session(request)
        .await
        .unwrap()
        .into_inner();
    let plan = response.plan.unwrap();
    assert!(response.session.is_none());
    assert_eq!(plan.name, "block");
    assert_eq!(plan.unknowns.unwrap().displacement, 3 * 125);
    assert_eq!(plan.formulation(), wire::Formulation::Mixed);
    let list = wire::ListSessionsRequest::default();
    assert!(
        server
            .sessions()
            .list_sessions(list)
            .await
            .unwrap()
            .into_inner()
            .sessions
            .is_empty()
    );
}

#[tokio::test]
async fn bad_scenes_name_the_paths_of_all_faulty_keys() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let mut scene = block.scene();
    scene.supports[0].on = vec!["botom".into()];
    scene.obstacles[0].on = vec!["tip".into()];
    let status = refused(&server, scene).await;
    assert_eq!(reason(&status), "SCENE_INVALID");
    let found = paths(&status);
    assert!(found.contains(&"support.base.on".to_owned()), "{found:?}");
    assert!(found.contains(&"obstacle.ball.on".to_owned()), "{found:?}");

    let mut scene = block.scene();
    scene.obstacles[0].shape.as_mut().unwrap().kind =
        Some(wire::shape::Kind::Sphere(wire::Sphere {
            centre: vec![1.0],
            radius: None,
        }));
    let found = paths(&refused(&server, scene).await);
    assert_eq!(
        found,
        ["obstacle.ball.shape.centre", "obstacle.ball.shape.radius"]
    );
}

#[tokio::test]
async fn keys_of_later_capabilities_are_refused_by_path() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let with = |change: fn(&mut wire::Scene)| {
        let mut scene = block.scene();
        change(&mut scene);
        scene
    };
    let cases: [(&str, wire::Scene); 2] = [
        (
            "pressure[0]",
            with(|scene| {
                let on = vec!["top".to_owned()];
                let value = Some(1.0);
                scene.pressures.push(wire::Pressure { on, value });
            }),
        ),
        (
            "step[0].support.base.rotation",
            with(|scene| {
                scene.steps = vec![wire::LoadStep {
                    supports: vec![wire::SupportTarget {
                        name: "base".into(),
                        rotation: vec![0.0, 0.0, 7.0],
                        ..Default::default()
                    }],
                    ..Default::default()
                }];
            }),
        ),
    ];
    for (path, scene) in cases {
        let status = refused(&server, scene).await;
        assert_eq!(status.code(), tonic::Code::Unimplemented, "{path}");
        assert_eq!(paths(&status), [path]);
        assert!(
            status.message().starts_with("not supported yet: "),
            "{}",
            status.message()
        );
    }
}

#[tokio::test]
async fn unknown_mesh_and_unknown_session_are_named() {
    let (server, block) = (Server::start().await, Block::new(1));
    let status = refused(&server, block.scene()).await;
    assert_eq!(reason(&status), "MESH_NOT_FOUND");
    assert!(status.message().contains(&block.digest()));
    let mut stream = server.stream(open("sessions/none")).await;
    let status = stream.end().await.unwrap();
    assert_eq!(reason(&status), "SESSION_NOT_FOUND");
    for (length, expected) in [(256, "SESSION_NOT_FOUND"), (257, "REQUEST_INVALID")] {
        let request = wire::GetSessionRequest {
            name: "s".repeat(length),
        };
        let status = server.sessions().get_session(request).await.unwrap_err();
        assert_eq!(reason(&status), expected);
    }
}

#[tokio::test]
async fn the_same_request_identifier_gives_the_same_session() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        session_id: "ball-1".into(),
        request_id: "first".into(),
        ..Default::default()
    };
    let create = |request: wire::CreateSessionRequest| async {
        server.sessions().create_session(request).await
    };
    let first = create(request.clone())
        .await
        .unwrap()
        .into_inner()
        .session
        .unwrap();
    let again = create(request.clone())
        .await
        .unwrap()
        .into_inner()
        .session
        .unwrap();
    assert_eq!(
        (first.name.as_str(), &again.name),
        ("sessions/ball-1", &first.name)
    );
    let other = wire::CreateSessionRequest {
        request_id: "second".into(),
        ..request
    };
    assert_eq!(reason(&create(other).await.unwrap_err()), "SESSION_EXISTS");
}

#[tokio::test]
async fn requests_of_one_identifier_at_one_time_make_one_session() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let create = || {
        let (mut client, scene) = (server.sessions(), Some(block.scene()));
        tokio::spawn(async move {
            let request = wire::CreateSessionRequest {
                scene,
                request_id: "same".into(),
                ..Default::default()
            };
            let response = client.create_session(request).await.unwrap();
            response.into_inner().session.unwrap().name
        })
    };
    let all: Vec<_> = (0..8).map(|_| create()).collect();
    let mut names = std::collections::BTreeSet::new();
    for one in all {
        names.insert(one.await.unwrap());
    }
    assert_eq!(names.len(), 1, "{names:?}");
}

#[tokio::test]
async fn a_request_that_failed_leaves_its_identifier_to_the_next() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let request = |scene| wire::CreateSessionRequest {
        scene: Some(scene),
        request_id: "same".into(),
        ..Default::default()
    };
    let mut faulty = block.scene();
    faulty.supports[0].on = vec!["botom".into()];
    let mut client = server.sessions();
    let status = client.create_session(request(faulty)).await.unwrap_err();
    assert_eq!(reason(&status), "SCENE_INVALID");
    client.create_session(request(block.scene())).await.unwrap();
}

#[tokio::test]
async fn a_time_to_live_beyond_thirty_days_is_refused() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ttl: Some(forever()),
        ..Default::default()
    };
    let status = server.sessions().create_session(request).await.unwrap_err();
    assert_eq!(reason(&status), "REQUEST_INVALID");
    assert_eq!(paths(&status), ["ttl"]);
}

#[tokio::test]
async fn an_endless_iteration_interval_is_refused_and_leaves_the_session_free() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let endless = wire::SolveOpen {
        iteration_interval: Some(forever()),
        ..open(&session)
    };
    let mut stream = server.stream(endless).await;
    // A stream that is not refused would never end.
    let end = tokio::time::timeout(Duration::from_secs(30), stream.end());
    let status = end.await.expect("the stream ends").unwrap();
    assert_eq!(paths(&status), ["open.iteration_interval"]);
    server.open(open(&session)).await;
}

fn forever() -> prost_types::Duration {
    prost_types::Duration {
        seconds: i64::MAX,
        nanos: 0,
    }
}

#[tokio::test]
async fn a_scene_above_its_limit_is_refused_with_the_limit() {
    let (server, block) = (Server::start().await, Block::new(1));
    let scene = wire::Scene {
        manufactured: "x".repeat(3 << 20),
        ..block.scene()
    };
    let status = refused(&server, scene).await;
    assert_eq!(reason(&status), "MESSAGE_LIMIT");
    use tonic_types::StatusExt;
    let metadata = status.get_details_error_info().unwrap().metadata;
    assert_eq!(metadata["limit"], (3 << 20).to_string());
}

#[tokio::test]
async fn a_mesh_stays_while_a_session_uses_it() {
    let (server, block) = (Server::start().await, Block::new(1));
    let mesh = server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let delete = || wire::DeleteMeshRequest { name: mesh.clone() };
    let status = server.meshes().delete_mesh(delete()).await.unwrap_err();
    assert_eq!(reason(&status), "MESH_IN_USE");
    let request = wire::DeleteSessionRequest { name: session };
    server.sessions().delete_session(request).await.unwrap();
    server.meshes().delete_mesh(delete()).await.unwrap();
}

#[tokio::test]
async fn predicted_memory_above_the_budget_is_refused_with_numbers() {
    let block = Block::new(4);
    let config = Config {
        memory_budget_bytes: 1 << 20,
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    server.upload(&block).await;
    let status = refused(&server, block.scene()).await;
    assert_eq!(reason(&status), "MEMORY_BUDGET");
    use tonic_types::StatusExt;
    let metadata = status.get_details_error_info().unwrap().metadata;
    assert_eq!(metadata["budget_bytes"], (1 << 20).to_string());
    assert!(metadata["predicted_bytes"].parse::<u64>().unwrap() > 1 << 20);
}

#[tokio::test]
async fn a_session_counts_what_later_steps_take_when_they_come() {
    let (server, block) = (Server::start().await, Block::new(6));
    server.upload(&block).await;
    let request = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ..Default::default()
    };
    let made = server.sessions().create_session(request).await.unwrap();
    let session = made.into_inner().session.unwrap();
    let predicted = session.plan.unwrap().predicted_bytes;
    let held = async || server.describe(&session.name).await.memory_bytes;
    let mut stream = server.open(open(&session.name)).await;
    for sequence in 1..=3 {
        stream.press(sequence, 0.002 * sequence as f64).await;
        stream.result().await;
        let held = held().await;
        assert!(3 * held < predicted, "{held} of {predicted}");
    }
    // The response at the contact surface, which is kept from some step on.
    let (before, mut sequence) = (held().await, 3);
    while held().await < 2 * before {
        sequence += 1;
        assert!(sequence < 100);
        stream.press(sequence, 0.01).await;
        stream.result().await;
    }
}
