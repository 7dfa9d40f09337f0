//! The stream: steps in, results out, in sequence, cancelled, repeated, resumed.

#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "what a test does not expect is a failure"
)]

use crate::common::{Block, Server, open, press, reason, rejection_reason};
use signorini_proto::v1::{self as wire, solve_request, solve_response::Message};
use signorini_server::Config;

async fn pressed(n: i32) -> (Server, String) {
    let (server, block) = (Server::start().await, Block::new(n));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    (server, session)
}

fn with_fields(session: &str) -> wire::SolveOpen {
    let fields = [
        wire::FieldName::Displacement,
        wire::FieldName::Pressure,
        wire::FieldName::ContactPressure,
        wire::FieldName::Gap,
        wire::FieldName::ContactState,
    ];
    wire::SolveOpen {
        fields: fields.map(i32::from).to_vec(),
        ..open(session)
    }
}

#[tokio::test]
async fn a_report_on_contact_alone_says_what_it_leaves_out_and_brings_the_same_fields() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let mut found = Vec::new();
    for report in ["contact", "whole"] {
        let mut scene = block.scene();
        let solver = scene.solver.get_or_insert_default();
        solver.report = report.to_owned();
        solver.response = "condensed".to_owned();
        let session = server.session(scene).await;
        let mut stream = server.open(with_fields(&session)).await;
        stream.step(1, press(0.05, 1)).await;
        stream.half_close();
        let finished = stream.result().await;
        let mut fields = Vec::new();
        for _ in 0..finished.fields.len() {
            fields.push(stream.field().await.2);
        }
        found.push((finished.report.unwrap(), fields));
    }
    let [(alone, own), (whole, all)] = &found[..] else {
        panic!("two reports");
    };
    assert!(alone.left_out.contains(&"strain_energy".to_owned()));
    assert!(alone.strain_energy.is_nan() && whole.left_out.is_empty());
    assert_eq!(own.len(), 5);
    for (own, all) in own.iter().zip(all) {
        let scale = all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let wrong = own.iter().zip(all).map(|(a, b)| (a - b).abs());
        assert!(wrong.fold(0.0, f64::max) <= 1e-6 * scale && own.len() == all.len());
    }
}

#[tokio::test]
async fn a_step_brings_its_report_and_its_fields() {
    let (server, session) = pressed(2).await;
    let mut stream = server.open(with_fields(&session)).await;
    stream.step(1, press(0.05, 1)).await;
    stream.half_close();
    let finished = stream.result().await;
    let report = finished.report.clone().unwrap();
    assert_eq!(report.termination(), wire::Termination::Converged);
    assert!((finished.last, finished.sequence, finished.event) == (true, 1, 1));
    assert!(report.obstacles["ball"].force[2] < 0.0);
    assert_eq!(report.obstacle_poses[0].translation, [0.0, 0.0, -0.05]);
    let seconds = report.seconds.unwrap();
    assert!(seconds.total >= seconds.factorise && seconds.factorise > 0.0);
    let mut shapes = Vec::new();
    for _ in 0..finished.fields.len() {
        let (name, shape, values) = stream.field().await;
        assert_eq!(values.len() as i64, shape.iter().product::<i64>());
        shapes.push((name, shape));
    }
    let vertices = vec![27, 1];
    assert_eq!(shapes[0], (wire::FieldName::Displacement, vec![125, 3]));
    assert_eq!(shapes[1], (wire::FieldName::Pressure, vertices.clone()));
    assert_eq!(shapes[4], (wire::FieldName::ContactState, vertices));
    assert!(stream.end().await.is_none());
}

#[tokio::test]
async fn increments_come_as_one_result_each_with_iterations_before() {
    let (server, session) = pressed(2).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.04, 2)).await;
    let mut iterations = 0;
    let first = loop {
        match stream.next().await {
            Message::Iteration(iteration) => {
                let report = iteration.report.unwrap();
                assert_eq!((iteration.sequence, report.step), (1, 1));
                iterations += 1;
            }
            Message::StepFinished(finished) => break finished,
            other => panic!("{other:?} instead of a result"),
        }
    };
    assert!(iterations > 0);
    let second = stream.result().await;
    assert_eq!((first.last, second.last), (false, true));
    assert_eq!(second.report.unwrap().increment, 2);
    stream.press(2, 0.05).await;
    let moved = stream.result().await.report.unwrap();
    assert_eq!((moved.step, moved.increment), (2, 1));
    assert!((moved.time - 2.0).abs() < 1e-12);
    assert_eq!(moved.factorisations, 0);
}

#[tokio::test]
async fn a_gap_and_a_bad_update_are_rejected_and_the_stream_lives() {
    let (server, session) = pressed(1).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(2, press(0.01, 1)).await;
    let rejected = stream.rejection().await;
    assert_eq!(
        (rejected.sequence, rejection_reason(&rejected).as_str()),
        (2, "SEQUENCE_GAP")
    );

    let mut unknown = press(0.01, 1);
    unknown.obstacles[0].name = "bal".into();
    stream.step(1, unknown).await;
    stream.step(2, press(0.01, 1)).await;
    let rejected = stream.rejection().await;
    assert_eq!(
        (rejected.sequence, rejection_reason(&rejected).as_str()),
        (1, "SCENE_INVALID")
    );
    // What was sent behind a rejected update has lost its place.
    assert_eq!(rejection_reason(&stream.rejection().await), "SEQUENCE_GAP");

    stream.step(1, press(f64::NAN, 1)).await;
    assert_eq!(rejection_reason(&stream.rejection().await), "SCENE_INVALID");
    stream.step(1, press(0.01, 0)).await;
    assert_eq!(rejection_reason(&stream.rejection().await), "SCENE_INVALID");
    stream.step(1, press(0.01, 1)).await;
    assert_eq!(stream.result().await.sequence, 1);
}

#[tokio::test]
async fn a_finished_sequence_is_answered_again_without_computing() {
    let (server, session) = pressed(1).await;
    let mut stream = server.open(with_fields(&session)).await;
    stream.step(1, press(0.02, 1)).await;
    let first = stream.result().await;
    for _ in 0..first.fields.len() {
        stream.field().await;
    }
    stream.step(1, press(0.02, 1)).await;
    let again = stream.result().await;
    assert_eq!(first, again);
    assert_eq!(stream.field().await.1, [27, 3]);
}

#[tokio::test]
async fn a_new_stream_gets_what_the_old_one_missed() {
    let (server, session) = pressed(1).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 3)).await;
    let first = stream.result().await;
    drop(stream);
    // The step is finished without a reader.
    let mut stream = loop {
        let seen = wire::SolveOpen {
            last_seen_event: Some(first.event),
            ..open(&session)
        };
        let mut stream = server.stream(seen).await;
        match stream.try_next().await {
            Ok(Message::Opened(_)) => break stream,
            Ok(other) => panic!("{other:?} instead of `opened`"),
            // The server has not noticed yet that the first stream is gone.
            Err(status) => assert_eq!(reason(&status), "SESSION_BUSY"),
        }
    };
    stream.step(1, press(0.02, 3)).await;
    let mut events = Vec::new();
    while events.last() != Some(&3) {
        events.push(stream.result().await.event);
    }
    assert!(events.contains(&2));
}

#[tokio::test]
async fn cancelling_from_another_connection_delivers_the_last_state() {
    let (server, session) = pressed(2).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    let request = wire::CancelStepRequest {
        name: session.clone(),
        sequence: 0,
    };
    let cancelled = server
        .sessions()
        .cancel_step(request.clone())
        .await
        .unwrap()
        .into_inner();
    assert_eq!(cancelled.sequence, 1);
    let last = loop {
        let finished = stream.result().await;
        if finished.last {
            break finished.report.unwrap();
        }
    };
    assert_eq!(last.termination(), wire::Termination::Cancelled);
    let idle = server
        .sessions()
        .cancel_step(request)
        .await
        .unwrap()
        .into_inner();
    assert_eq!(idle.sequence, 0);
    stream.press(2, 0.001).await;
    assert_eq!(
        stream.result().await.report.unwrap().termination(),
        wire::Termination::Converged
    );
}

#[tokio::test]
async fn cancelling_while_preparing_is_answered_at_once() {
    let (server, session) = pressed(6).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.01, 1)).await;
    stream
        .send(solve_request::Message::Cancel(wire::SolveCancel {
            sequence: 1,
        }))
        .await;
    let finished = stream.result().await;
    assert_eq!((finished.sequence, finished.last), (1, true));
    assert_eq!(
        finished.report.unwrap().termination(),
        wire::Termination::Cancelled
    );
    stream.press(2, 0.01).await;
    let next = stream.result().await.report.unwrap();
    assert_eq!(
        (next.step, next.termination()),
        (2, wire::Termination::Converged)
    );
}

#[tokio::test]
async fn a_second_writer_is_refused() {
    let (server, session) = pressed(1).await;
    let _first = server.open(open(&session)).await;
    let mut second = server.stream(open(&session)).await;
    assert_eq!(reason(&second.end().await.unwrap()), "SESSION_BUSY");
}

#[tokio::test]
async fn a_second_session_reuses_what_the_first_prepared() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    let mut forces = Vec::new();
    for reused in [false, true] {
        let session = server.session(block.scene()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.03, 1)).await;
        let report = stream.result().await.report.unwrap();
        forces.push(report.obstacles["ball"].force.clone());
        assert_eq!(!report.reused.is_empty(), reused, "{:?}", report.reused);
        assert_eq!(server.describe(&session).await.prepared_reused, reused);
    }
    assert_eq!(forces[0], forces[1]);
}

#[tokio::test]
async fn a_finished_step_can_be_read_again() {
    let (server, block) = (Server::start().await, Block::new(1));
    server.upload(&block).await;
    let fields = vec![i32::from(wire::FieldName::Displacement)];
    let output = Some(wire::Output {
        fields,
        every: None,
    });
    let session = server
        .session(wire::Scene {
            output,
            ..block.scene()
        })
        .await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.02, 2)).await;
    while !stream.result().await.last {}
    let request = wire::ReadStepRequest {
        name: session.clone(),
        sequence: 1,
        ..Default::default()
    };
    let mut answers = server
        .sessions()
        .read_step(request.clone())
        .await
        .unwrap()
        .into_inner();
    let (mut results, mut bytes) = (0, 0);
    while let Some(answer) = answers.message().await.unwrap() {
        match answer.message.unwrap() {
            wire::read_step_response::Message::StepFinished(_) => results += 1,
            wire::read_step_response::Message::Field(chunk) => bytes += chunk.data.len(),
        }
    }
    assert_eq!((results, bytes), (2, 2 * 27 * 3 * 8));
    let missing = wire::ReadStepRequest {
        sequence: 2,
        ..request
    };
    let status = server.sessions().read_step(missing).await.unwrap_err();
    assert_eq!(reason(&status), "STEP_NOT_FOUND");
}

#[tokio::test]
async fn a_step_ends_at_its_wall_time_with_the_last_state() {
    let (server, session) = pressed(2).await;
    let mut stream = server.open(open(&session)).await;
    let update = wire::LoadStepUpdate {
        sequence: 1,
        step: Some(press(0.05, 100_000)),
        max_wall_time: Some(prost_types::Duration {
            seconds: 0,
            nanos: 100_000_000,
        }),
    };
    stream.send(solve_request::Message::LoadStep(update)).await;
    let last = loop {
        let finished = stream.result().await;
        if finished.last {
            break finished.report.unwrap();
        }
    };
    assert_eq!(last.termination(), wire::Termination::DeadlineExceeded);
}

#[tokio::test]
async fn an_unread_stream_holds_up_the_next_increment_only() {
    let (server, session) = pressed(2).await;
    let fields = vec![i32::from(wire::FieldName::Displacement)];
    let limited = wire::SolveOpen {
        fields,
        max_unread_bytes: 1 << 20,
        ..open(&session)
    };
    let mut stream = server.open(limited).await;
    stream.step(1, press(0.05, 3000)).await;
    // All of it is more than one mebibyte and two windows; all of it arrives.
    let mut bytes = 0;
    loop {
        match stream.next().await {
            Message::Field(chunk) => {
                bytes += chunk.data.len();
                if chunk.event == 200 {
                    break;
                }
            }
            Message::StepFinished(_) | Message::Iteration(_) | Message::Heartbeat(_) => {}
            other => panic!("{other:?} instead of results"),
        }
    }
    assert_eq!(bytes, 200 * 125 * 3 * 8);
}

#[tokio::test]
async fn deleting_a_session_ends_its_stream_with_the_reason() {
    let (server, session) = pressed(1).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    let request = wire::DeleteSessionRequest { name: session };
    server.sessions().delete_session(request).await.unwrap();
    assert_eq!(reason(&stream.end().await.unwrap()), "SESSION_DELETED");
}

#[tokio::test]
async fn a_stream_without_open_or_with_two_is_refused() {
    let (server, session) = pressed(1).await;
    let mut stream = server.open(open(&session)).await;
    stream
        .send(solve_request::Message::Open(open(&session)))
        .await;
    assert_eq!(reason(&stream.end().await.unwrap()), "REQUEST_INVALID");
    let cancel = solve_request::Message::Cancel(wire::SolveCancel::default());
    let first = wire::SolveRequest {
        message: Some(cancel),
    };
    let call = server.sessions().solve(tokio_stream::iter([first])).await;
    let status = call.unwrap().into_inner().message().await.unwrap_err();
    assert_eq!(reason(&status), "REQUEST_INVALID");
}

#[tokio::test]
async fn too_many_waiting_updates_are_rejected() {
    let config = Config {
        maximum_in_flight: 1,
        ..Config::embedded()
    };
    let (server, block) = (Server::with(config).await, Block::new(1));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    stream.press(2, 0.01).await;
    let rejected = loop {
        match stream.next().await {
            Message::UpdateRejected(rejected) => break rejected,
            Message::StepFinished(_) | Message::Iteration(_) | Message::Heartbeat(_) => {}
            other => panic!("{other:?} instead of a rejection"),
        }
    };
    assert_eq!(rejection_reason(&rejected), "QUEUE_FULL");
}
