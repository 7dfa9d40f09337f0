//! Saved states: a session goes back to them with the same bits, also after a kill.

use crate::common::{Block, Process, Server, Stream, folder, open, press, reason};
use signorini_proto::array;
use signorini_proto::v1::{self as wire, solve_response::Message};

/// A result without what later steps of the same state may have otherwise, and its fields.
type Bare = (wire::StepReport, Vec<u8>);

fn bare(report: wire::StepReport) -> wire::StepReport {
    wire::StepReport {
        step: 0,
        time: 0.0,
        seconds: None,
        memory_bytes: 0,
        reused: Vec::new(),
        factorisations: 0,
        eigenvalue_applications: 0,
        compliance_columns: 0,
        ..report
    }
}

/// The depths of the two steps that are done again and again.
const DEPTHS: [f64; 2] = [0.03, 0.02];

/// The results of two steps from this sequence on, with the force at every node.
async fn two_steps(stream: &mut Stream, sequence: i64) -> Vec<Bare> {
    let mut results = Vec::new();
    for (step, depth) in (sequence..).zip(DEPTHS) {
        stream.step(step, press(depth, 2)).await;
        loop {
            let Message::StepFinished(finished) = stream.next().await else {
                continue;
            };
            // What a kill took from the disk is done and told again first.
            if finished.sequence < step {
                continue;
            }
            let (_, shape, values) = stream.field().await;
            assert_eq!(shape[1], 3);
            let bytes = array::encode(&values).to_vec();
            results.push((bare(finished.report.expect("a report")), bytes));
            if finished.last {
                break;
            }
        }
    }
    results
}

async fn save(server: &Server, session: &str) -> Result<wire::SaveStateResponse, tonic::Status> {
    let request = wire::SaveStateRequest {
        name: session.into(),
    };
    let answer = server.sessions().save_state(request).await;
    answer.map(tonic::Response::into_inner)
}

async fn restore(server: &Server, session: &str, save: i64) -> Result<(), tonic::Status> {
    let request = wire::RestoreStateRequest {
        name: session.into(),
        save,
    };
    server.sessions().restore_state(request).await.map(|_| ())
}

/// Opens a stream that asks for the forces at nodes.
async fn attached(server: &Server, session: &str) -> Stream {
    let open = wire::SolveOpen {
        fields: vec![wire::FieldName::NodalForce.into()],
        ..open(session)
    };
    server.open(open).await
}

/// A session that has been pressed once, with its stream.
async fn pressed(server: &Server) -> (String, Stream) {
    let block = Block::new(2);
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = attached(server, &session).await;
    stream.step(1, press(0.01, 1)).await;
    stream.result().await;
    stream.field().await;
    (session, stream)
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_steps_from_a_saved_state_give_the_same_bits() {
    let server = Server::start().await;
    let (session, mut stream) = pressed(&server).await;
    let saved = save(&server, &session).await.expect("a saved state");
    assert!(saved.save == 1 && saved.memory_bytes > 1000);
    let first = two_steps(&mut stream, 2).await;
    assert_eq!(first.len(), 4);
    for round in 1..=2 {
        restore(&server, &session, 1).await.expect("what was saved");
        assert!(two_steps(&mut stream, 2 + 2 * round).await == first);
    }
    // Another session has none of it.
    let other = server.session(Block::new(2).scene()).await;
    let refused = restore(&server, &other, 1).await.unwrap_err();
    assert_eq!(reason(&refused), "STATE_NOT_FOUND");
}

#[tokio::test(flavor = "multi_thread")]
async fn eight_states_are_kept_and_count_in_the_memory_of_their_session() {
    let server = Server::start().await;
    let (session, mut stream) = pressed(&server).await;
    let before = server.describe(&session).await.memory_bytes;
    let mut bytes = 0;
    for number in 1..=9 {
        let saved = save(&server, &session).await.expect("a saved state");
        assert_eq!(saved.save, number);
        bytes = saved.memory_bytes;
    }
    stream.step(2, press(0.02, 1)).await;
    stream.result().await;
    assert!(server.describe(&session).await.memory_bytes >= before + 8 * bytes);
    let refused = restore(&server, &session, 1).await.unwrap_err();
    assert_eq!(reason(&refused), "STATE_NOT_FOUND");
    restore(&server, &session, 2)
        .await
        .expect("the oldest kept");
    let refused = save(&server, "sessions/nobody").await.unwrap_err();
    assert_eq!(reason(&refused), "SESSION_NOT_FOUND");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_restored_state_and_the_saved_ones_survive_a_kill() {
    let mut process = Process::start(&folder("saves"), "");
    let server = process.connect().await;
    let (session, mut stream) = pressed(&server).await;
    let saved = save(&server, &session).await.expect("a saved state").save;
    let first = two_steps(&mut stream, 2).await;
    process.kill();
    process.restart();
    // Saved before the kill, gone back to behind it.
    let server = process.connect().await;
    let mut stream = attached(&server, &session).await;
    restore(&server, &session, saved)
        .await
        .expect("a state on disk");
    assert!(two_steps(&mut stream, 4).await == first, "after a kill");
    restore(&server, &session, saved).await.expect("and again");
    process.kill();
    process.restart();
    // Gone back to before the kill.
    let server = process.connect().await;
    let mut stream = attached(&server, &session).await;
    assert!(two_steps(&mut stream, 6).await == first, "before a kill");
    assert_eq!(
        save(&server, &session).await.expect("another").save,
        saved + 1
    );
    process.kill();
    let found = signorini_server::fsck(&folder_of_data()).expect("a data folder");
    assert_eq!(found.faults, Vec::<String>::new());
}

/// Where the test above has its data.
fn folder_of_data() -> std::path::PathBuf {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    folder.join("durable").join("saves").join("data")
}

#[tokio::test(flavor = "multi_thread")]
async fn values_by_node_arrive_on_the_wire_and_forces_by_node_come_back() {
    let server = Server::start().await;
    let (_, mut stream) = pressed(&server).await;
    // The nine vertices of the bottom, ascending, one way down: as the support moved.
    let lowered = wire::LoadStep {
        supports: vec![wire::SupportTarget {
            name: "base".into(),
            values: Some(wire::Values {
                place: wire::ValuePlace::Nodes.into(),
                numbers: bytes::Bytes::new(),
                rows: array::encode(&[0.0, 0.0, -0.005].repeat(9)),
            }),
            ..Default::default()
        }],
        ..Default::default()
    };
    stream.step(2, lowered.clone()).await;
    let result = stream.result().await.report.expect("a report");
    let (name, shape, forces) = stream.field().await;
    assert_eq!((name, shape[1]), (wire::FieldName::NodalForce, 3));
    let sum: f64 = forces.iter().skip(2).step_by(3).sum();
    let (base, ball) = (
        &result.supports["base"].force,
        &result.obstacles["ball"].force,
    );
    assert!((sum - base[2] - ball[2]).abs() < 1e-12 * ball[2].abs());
    // A body lowered by half the depth touches as if pressed by the other half.
    let (_, mut other) = pressed(&server).await;
    other.step(2, press(0.005, 1)).await;
    let half = other.result().await.report.expect("a report");
    let expected = half.obstacles["ball"].force[2];
    assert!(
        (ball[2] - expected).abs() < 1e-6 * expected.abs(),
        "{} {expected}",
        ball[2]
    );
    let mut wrong = lowered;
    let values = wrong.supports[0].values.as_mut().expect("values");
    values.rows = values.rows.slice(..24 * 8);
    stream.step(3, wrong).await;
    let rejected = stream.rejection().await;
    assert_eq!(crate::common::rejection_reason(&rejected), "SCENE_INVALID");
}
