//! Meshes that the server refines until a force is known as well as is asked for.

use std::time::Duration;

use serde_json::Value;

use crate::common::{Block, Server, answer, open, paths, press, reason};
use signorini_proto::v1::refine_mesh_response::Part;
use signorini_proto::v1::{self as wire, RefinementEnd};
use signorini_server::Config;

/// Ends a test that would wait for ever.
const PATIENCE: Duration = Duration::from_secs(60);

/// A ball pressed into a block, its force within `tolerance`.
fn scene(block: &Block, tolerance: f64) -> wire::Scene {
    let target = wire::AccuracyTarget {
        goal: "force.ball".into(),
        tolerance,
    };
    wire::Scene {
        steps: vec![press(0.05, 1)],
        accuracy: Some(wire::Accuracy {
            targets: vec![target],
            ..Default::default()
        }),
        ..block.scene()
    }
}

fn limited(block: &Block, limit: impl FnOnce(&mut wire::Accuracy)) -> wire::Scene {
    let mut scene = scene(block, 1e-6);
    limit(scene.accuracy.as_mut().unwrap());
    scene
}

/// What the live page is told.
async fn live(server: &Server) -> Value {
    let told = answer(server.metrics_url.as_ref().unwrap(), "GET", "/live.json").await;
    let (_, body) = told.split_once("\r\n\r\n").unwrap();
    serde_json::from_str(body).unwrap()
}

type Told = Result<(Vec<wire::RefinementRound>, wire::RefinedMesh), tonic::Status>;

async fn refine(server: &Server, scene: wire::Scene) -> Told {
    let request = wire::RefineMeshRequest { scene: Some(scene) };
    let mut stream = server.meshes().refine_mesh(request).await?.into_inner();
    let mut rounds = Vec::new();
    loop {
        match stream.message().await?.expect("a last message").part {
            Some(Part::Round(round)) => rounds.push(round),
            Some(Part::Refined(refined)) => {
                assert!(stream.message().await?.is_none());
                return Ok((rounds, refined));
            }
            None => {}
        }
    }
}

async fn refused(server: &Server, scene: wire::Scene) -> tonic::Status {
    refine(server, scene).await.unwrap_err()
}

#[tokio::test]
async fn a_session_on_the_refined_mesh_has_the_force_as_well_as_was_asked() {
    let (server, block) = (Server::start().await, Block::new(2));
    let first = server.upload(&block).await;
    let (rounds, refined) = refine(&server, scene(&block, 0.05)).await.unwrap();
    assert_eq!(refined.end(), RefinementEnd::Reached);
    assert!(rounds.len() > 1, "{rounds:?}");
    let last = rounds.last().unwrap();
    let goal = &last.goals[0];
    assert_eq!(goal.goal, "force.ball.z");
    assert!(goal.bound <= 0.05 * goal.value.abs());
    let (mesh, scene) = (refined.mesh.unwrap(), refined.scene.unwrap());
    assert!(mesh.name != first && mesh.cell_count == last.cell_count);
    assert_eq!(scene.mesh, mesh.name);
    let accuracy = scene.accuracy.as_ref().unwrap();
    assert!(accuracy.targets.is_empty() && accuracy.bound == ["force.ball.z"]);
    let step = scene.steps[0].clone();
    let session = server.session(scene).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, step).await;
    let report = stream.result().await.report.unwrap();
    let told = &report.goals["force.ball.z"];
    let bound = told.bound.as_ref().unwrap();
    assert!((told.value - goal.value).abs() < 1e-6 * goal.value.abs());
    assert!((bound.total - goal.bound).abs() < 1e-3 * goal.bound);
}

/// All steps are solved on each mesh, and a session on the last one has the same force.
#[tokio::test]
async fn a_rough_ball_is_refined_and_a_session_on_the_mesh_goes_the_same_way() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let mut rough = scene(&block, 0.05);
    rough.obstacles[0].friction = Some(0.3);
    let (rounds, refined) = refine(&server, rough).await.unwrap();
    assert_eq!(refined.end(), RefinementEnd::Reached);
    assert!(rounds.len() > 1, "{rounds:?}");
    let scene = refined.scene.unwrap();
    let step = scene.steps[0].clone();
    let session = server.session(scene).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, step).await;
    let report = stream.result().await.report.unwrap();
    let value = rounds.last().unwrap().goals[0].value;
    let told = report.goals["force.ball.z"].value;
    assert!((told - value).abs() < 1e-6 * value.abs(), "{told} {value}");
}

#[tokio::test]
async fn the_same_request_gives_the_same_mesh() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let mut names = Vec::new();
    for _ in 0..2 {
        let (_, refined) = refine(&server, scene(&block, 0.05)).await.unwrap();
        names.push(refined.mesh.unwrap().name);
    }
    assert_eq!(names[0], names[1]);
}

#[tokio::test]
async fn limits_end_it_with_the_last_mesh() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let one = limited(&block, |asked| asked.max_rounds = Some(1));
    let (rounds, refined) = refine(&server, one).await.unwrap();
    assert_eq!((rounds.len(), refined.end()), (1, RefinementEnd::MaxRounds));
    let few = limited(&block, |asked| asked.max_unknowns = Some(2000));
    let (rounds, refined) = refine(&server, few).await.unwrap();
    assert_eq!(refined.end(), RefinementEnd::MaxUnknowns);
    assert!(rounds.last().unwrap().unknown_count <= 2000 && refined.why.contains("2000"));
}

#[tokio::test]
async fn a_server_without_room_keeps_the_mesh_that_fits() {
    let config = Config {
        memory_budget_bytes: 24 << 20,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let (rounds, refined) = refine(&server, scene(&block, 1e-6)).await.unwrap();
    assert_eq!(refined.end(), RefinementEnd::NoRoom, "{}", refined.why);
    assert_eq!(
        refined.mesh.unwrap().cell_count,
        rounds.last().unwrap().cell_count
    );
}

#[tokio::test]
async fn what_cannot_be_refined_is_refused_with_its_key() {
    let (server, block) = (Server::start().await, Block::new(2));
    let missing = refused(&server, scene(&block, 0.1)).await;
    assert_eq!(reason(&missing), "MESH_NOT_FOUND");
    server.upload(&block).await;
    let none = refused(&server, block.scene()).await;
    assert_eq!(
        (reason(&none).as_str(), paths(&none)),
        ("SCENE_INVALID", vec!["accuracy".to_owned()])
    );
    let wild = limited(&block, |asked| {
        asked.max_time = Some(f64::NAN);
        asked.targets[0].tolerance = -1.0;
        asked.max_rounds = Some(i32::MIN);
    });
    let wild = paths(&refused(&server, wild).await);
    assert_eq!(
        wild,
        [
            "accuracy.force.ball.z",
            "accuracy.max_rounds",
            "accuracy.max_time"
        ]
    );
    // A goal along the motion of its obstacle and the same with its axis.
    let twice = limited(&block, |asked| {
        asked.targets = ["force.ball.z", "force.ball"]
            .map(|goal| wire::AccuracyTarget {
                goal: goal.into(),
                tolerance: 0.1,
            })
            .to_vec();
    });
    assert_eq!(
        paths(&refused(&server, twice).await),
        ["accuracy.force.ball.z"]
    );
    let mut behind = scene(&block, 0.1);
    behind.accuracy.as_mut().unwrap().targets[0].goal = "force.lid.z".into();
    let behind = refused(&server, behind).await;
    assert!(behind.message().contains("force.lid.z"), "{behind:?}");
    let whole = server
        .meshes()
        .refine_mesh(wire::RefineMeshRequest::default())
        .await;
    let mut whole = whole.unwrap().into_inner();
    assert_eq!(
        reason(&whole.message().await.unwrap_err()),
        "REQUEST_INVALID"
    );
}

#[tokio::test]
async fn a_session_with_tolerances_says_who_refines() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let request = |validate_only| wire::CreateSessionRequest {
        scene: Some(scene(&block, 0.1)),
        validate_only,
        ..Default::default()
    };
    let refused = server.sessions().create_session(request(false)).await;
    assert!(refused.unwrap_err().message().contains("`RefineMesh`"));
    // The plan is that of the first mesh.
    server
        .sessions()
        .create_session(request(true))
        .await
        .unwrap();
}

#[tokio::test]
async fn a_call_that_is_left_gives_its_slot_and_memory_back() {
    let config = Config {
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(6));
    server.upload(&block).await;
    let request = wire::RefineMeshRequest {
        scene: Some(scene(&block, 1e-9)),
    };
    let mut stream = server
        .meshes()
        .refine_mesh(request)
        .await
        .unwrap()
        .into_inner();
    let first = tokio::time::timeout(PATIENCE, stream.message());
    assert!(first.await.unwrap().unwrap().is_some());
    drop(stream);
    let idle = async {
        while live(&server).await["slots"]["busy"] != 0 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(PATIENCE, idle)
        .await
        .expect("the slot is free");
}
