//! Streams never lose the thread: watchers, slow readers, deadlines, fairness.

#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "what a test does not expect is a failure"
)]

use crate::common::{
    Block, Server, duration, open, page, press, reason, rejection_reason, sample, watch,
};
use signorini_proto::v1::{self as wire, solve_request, watch_response};
use signorini_server::Config;

async fn pressed(n: i32, config: Config) -> (Server, String) {
    let (server, block) = (Server::with(config).await, Block::new(n));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    (server, session)
}

fn every_field() -> Vec<i32> {
    let fields = [wire::FieldName::Displacement, wire::FieldName::Pressure];
    fields.map(i32::from).to_vec()
}

fn forces(results: &[wire::StepFinished]) -> Vec<Vec<u64>> {
    let force = |one: &wire::StepFinished| {
        let force = &one.report.as_ref().unwrap().obstacles["ball"].force;
        force.iter().map(|value| value.to_bits()).collect()
    };
    results.iter().map(force).collect()
}

#[tokio::test]
async fn any_number_of_watchers_see_every_result_and_the_end() {
    let (server, session) = pressed(1, Config::embedded()).await;
    let mut stream = server.open(open(&session)).await;
    let mut early = Vec::new();
    for _ in 0..20 {
        early.push(server.watch(watch(&session, wire::WatchEnd::Session)).await);
    }
    stream.step(1, press(0.04, 4)).await;
    let mut written = Vec::new();
    for _ in 0..4 {
        written.push(stream.result().await);
    }
    assert_eq!(server.describe(&session).await.watcher_count, 20);
    let mut late = server.watch(watch(&session, wire::WatchEnd::Idle)).await;
    let (seen, end) = late.results().await;
    assert!(end.is_none());
    assert_eq!(seen, written);
    let request = wire::DeleteSessionRequest { name: session };
    server.sessions().delete_session(request).await.unwrap();
    for mut watcher in early {
        let (seen, end) = watcher.results().await;
        assert_eq!(seen, written);
        assert_eq!(reason(&end.unwrap()), "SESSION_DELETED");
    }
}

#[tokio::test]
async fn a_watcher_sees_iterations_and_cannot_hold_up_the_writer() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let request = wire::WatchRequest {
        fields: every_field(),
        max_unread_bytes: 1 << 20,
        ..watch(&session, wire::WatchEnd::Session)
    };
    let mut stream = server.open(open(&session)).await;
    let mut slow = server.watch(request).await;
    // Far more than the mebibyte and the windows that the watcher leaves unread.
    stream.step(1, press(0.05, 1200)).await;
    let mut last = stream.result().await;
    while !last.last {
        last = stream.result().await;
    }
    assert_eq!(last.event, 1200);
    let (mut events, mut iterations, mut bytes) = (Vec::new(), 0, 0);
    while events.last() != Some(&1200) {
        match slow.next().await.unwrap().unwrap() {
            watch_response::Message::StepFinished(finished) => events.push(finished.event),
            watch_response::Message::Field(chunk) => bytes += chunk.data.len(),
            watch_response::Message::Iteration(_) => iterations += 1,
            watch_response::Message::Opened(_) | watch_response::Message::Heartbeat(_) => {}
        }
    }
    assert!(
        events.iter().copied().eq(1..=1200),
        "every result, in order"
    );
    assert!(iterations > 0);
    // Its fields were made although the writer wants none; the last are kept whole.
    assert!(bytes >= (375 + 27) * 8);
}

#[tokio::test]
async fn a_watcher_that_falls_behind_what_is_kept_is_told_so() {
    let config = Config {
        retained_results: 100,
        ..Config::embedded()
    };
    let block = Block::new(2);
    let server = Server::with(config).await;
    server.upload(&block).await;
    let output = Some(wire::Output {
        fields: every_field(),
        every: None,
    });
    let scene = wire::Scene {
        output,
        ..block.scene()
    };
    let session = server.session(scene).await;
    let request = wire::WatchRequest {
        max_unread_bytes: 1 << 20,
        ..watch(&session, wire::WatchEnd::Session)
    };
    let mut stream = server.open(open(&session)).await;
    let mut slow = server.watch(request).await;
    stream.step(1, press(0.05, 1500)).await;
    while !stream.result().await.last {}
    let (results, end) = slow.results().await;
    assert!(results.len() < 1500);
    let gapless = (1..=results.len() as i64).collect::<Vec<_>>();
    assert_eq!(
        results.iter().map(|one| one.event).collect::<Vec<_>>(),
        gapless
    );
    assert_eq!(reason(&end.unwrap()), "SEQUENCE_NOT_RETAINED");
}

#[tokio::test]
async fn an_acknowledged_update_recomputes_nothing() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.03, 2)).await;
    let first = [stream.result().await, stream.result().await];
    drop(stream);
    let request = wire::SolveOpen {
        last_seen_event: Some(2),
        ..open(&session)
    };
    let mut stream = reopened(&server, request).await;
    for sequence in [1, 1] {
        stream.step(sequence, press(0.03, 2)).await;
        assert_eq!([stream.result().await, stream.result().await], first);
    }
    let session = server.describe(&session).await;
    assert_eq!(
        (
            session.last_accepted_sequence,
            session.last_finished_sequence
        ),
        (1, 1)
    );
}

/// Opens a stream as soon as the server has noticed that the one before is gone.
async fn reopened(server: &Server, request: wire::SolveOpen) -> crate::common::Stream {
    use signorini_proto::v1::solve_response::Message;
    loop {
        let mut stream = server.stream(request.clone()).await;
        match stream.try_next().await {
            Ok(Message::Opened(_)) => return stream,
            Ok(other) => panic!("{other:?} instead of `opened`"),
            Err(status) => assert_eq!(reason(&status), "SESSION_BUSY"),
        }
    }
}

#[tokio::test]
async fn a_resumed_stream_gets_what_it_missed_of_a_running_step_exactly_once() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 400)).await;
    let seen = stream.result().await.event;
    drop(stream);
    let request = wire::SolveOpen {
        last_seen_event: Some(seen),
        ..open(&session)
    };
    let mut stream = reopened(&server, request).await;
    stream.step(1, press(0.05, 400)).await;
    stream.half_close();
    let mut events = Vec::new();
    while events.last() != Some(&400) {
        events.push(stream.result().await.event);
    }
    // Finished when it was asked for again, it comes whole behind what was missed.
    let missed = (seen + 1..=400).collect::<Vec<_>>();
    assert_eq!(events, missed);
}

#[tokio::test]
async fn a_disconnect_cancels_only_where_the_session_says_so() {
    let (server, block) = (Server::start().await, Block::new(2));
    server.upload(&block).await;
    for (policy, ending) in [
        (
            wire::DisconnectPolicy::FinishStep,
            wire::Termination::Converged,
        ),
        (
            wire::DisconnectPolicy::CancelStep,
            wire::Termination::Cancelled,
        ),
    ] {
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            on_disconnect: policy.into(),
            ..Default::default()
        };
        let created = server.sessions().create_session(request).await.unwrap();
        let session = created.into_inner().session.unwrap().name;
        let mut watcher = server.watch(watch(&session, wire::WatchEnd::Session)).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.05, 2000)).await;
        stream.result().await;
        drop(stream);
        let results = watcher.update().await;
        let last = results.last().unwrap();
        assert_eq!(last.report.as_ref().unwrap().termination(), ending);
    }
}

#[tokio::test]
async fn a_client_that_comes_back_in_its_grace_finds_its_step_going_on() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let opening = |grace| wire::SolveOpen {
        on_disconnect: wire::DisconnectPolicy::CancelStep.into(),
        disconnect_grace: duration(grace),
        ..open(&session)
    };
    let mut watcher = server.watch(watch(&session, wire::WatchEnd::Session)).await;
    let mut stream = server.open(opening(20_000)).await;
    stream.step(1, press(0.05, 1000)).await;
    stream.result().await;
    drop(stream);
    // Another one drives it, and leaves for less.
    let mut stream = server.open(opening(200)).await;
    let first = stream.result().await;
    assert_eq!(
        first.report.unwrap().termination(),
        wire::Termination::Converged
    );
    stream.step(2, press(0.04, 100_000)).await;
    stream.step(3, press(0.03, 1)).await;
    let mut finished = 0;
    while finished < 1 {
        let result = stream.result().await;
        finished += i32::from(result.sequence == 1 && result.last);
    }
    stream.result().await;
    drop(stream);
    let ends: Vec<_> = [watcher.update().await, watcher.update().await]
        .iter()
        .map(|results| {
            results
                .last()
                .unwrap()
                .report
                .as_ref()
                .unwrap()
                .termination()
        })
        .collect();
    assert_eq!(
        ends,
        [wire::Termination::Converged, wire::Termination::Cancelled]
    );
    // The one behind it is dropped: its number is free.
    assert_eq!(server.describe(&session).await.last_accepted_sequence, 2);
}

#[tokio::test]
async fn a_stream_whose_deadline_passes_leaves_its_last_state() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let (updates, outbound) = tokio::sync::mpsc::channel(4);
    let step = wire::LoadStepUpdate {
        sequence: 1,
        step: Some(press(0.05, 100_000)),
        max_wall_time: None,
    };
    for message in [
        solve_request::Message::Open(open(&session)),
        solve_request::Message::LoadStep(step),
    ] {
        let message = Some(message);
        updates.send(wire::SolveRequest { message }).await.unwrap();
    }
    let outbound = tokio_stream::wrappers::ReceiverStream::new(outbound);
    let mut request = tonic::Request::new(outbound);
    request.set_timeout(std::time::Duration::from_millis(1500));
    let mut answers = server.sessions().solve(request).await.unwrap().into_inner();
    let status = loop {
        match answers.message().await {
            Ok(message) => assert!(message.is_some()),
            Err(status) => break status,
        }
    };
    // The client's own clock may be the first.
    let codes = [tonic::Code::DeadlineExceeded, tonic::Code::Cancelled];
    assert!(codes.contains(&status.code()), "{status:?}");
    let mut watcher = server.watch(watch(&session, wire::WatchEnd::Idle)).await;
    let (results, _) = watcher.results().await;
    let last = results.last().unwrap().report.as_ref().unwrap();
    assert_eq!(last.termination(), wire::Termination::DeadlineExceeded);
    assert!(last.time > 0.0 && last.time < 1.0);
}

#[tokio::test]
async fn a_client_that_leaves_just_before_its_deadline_leaves_a_step_that_ends() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let step = wire::LoadStepUpdate {
        sequence: 1,
        step: Some(press(0.05, 100_000)),
        max_wall_time: None,
    };
    let messages = [
        solve_request::Message::Open(open(&session)),
        solve_request::Message::LoadStep(step),
    ];
    let messages = messages.map(|message| wire::SolveRequest {
        message: Some(message),
    });
    let mut request = tonic::Request::new(tokio_stream::iter(messages));
    request.set_timeout(std::time::Duration::from_millis(1500));
    let mut answers = server.sessions().solve(request).await.unwrap().into_inner();
    let mut watcher = server.watch(watch(&session, wire::WatchEnd::Session)).await;
    answers.message().await.ok();
    drop(answers);
    let results = watcher.update().await;
    let last = results.last().unwrap().report.as_ref().unwrap();
    assert_eq!(last.termination(), wire::Termination::DeadlineExceeded);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flooding_client_leaves_another_at_least_forty_percent() {
    let config = Config {
        solver_slots: 1,
        threads_per_slot: 1,
        metrics_listen: "127.0.0.1:0".into(),
        ..Config::embedded()
    };
    let (mut server, block) = (Server::with(config).await, Block::new(5));
    server.upload(&block).await;
    // Shares are counted by increments, which shall cost alike.
    let mut scene = block.scene();
    scene.solver.get_or_insert_default().response = "iterative".into();
    let mut flood = Vec::new();
    for _ in 0..16 {
        let session = server.session(scene.clone()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.05, 100_000)).await;
        stream.result().await;
        flood.push((session, stream));
    }
    // Another client is another connection.
    server.channel = server.connect().await;
    let session = server.session(scene).await;
    let mut stream = server.open(open(&session)).await;
    stream.press(1, 0.001).await;
    stream.result().await;
    let before = increments(&server).await;
    // All at once, so that the solver and not the way to it is shared.
    for sequence in 2..=31 {
        stream.press(sequence, 0.001).await;
    }
    while stream.result().await.sequence < 31 {}
    let all = increments(&server).await - before;
    assert!(all > 30, "the flood runs");
    assert!(30.0 / all as f64 >= 0.4, "30 of {all} increments");
}

async fn increments(server: &Server) -> u64 {
    let page = page(server.metrics_url.as_ref().unwrap()).await;
    sample(
        &page,
        "signorini_increments_total{termination=\"converged\"}",
    )
}

#[tokio::test]
async fn a_full_queue_says_when_to_come_back() {
    use tonic_types::StatusExt as _;
    let config = Config {
        solver_slots: 1,
        maximum_queued: 2,
        ..Config::embedded()
    };
    let (mut server, block) = (Server::with(config).await, Block::new(2));
    server.upload(&block).await;
    let session = server.session(block.scene()).await;
    let mut stream = server.open(open(&session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    stream.result().await;
    server.channel = server.connect().await;
    let refused = loop {
        let request = wire::CreateSessionRequest {
            scene: Some(block.scene()),
            ..Default::default()
        };
        if let Err(status) = server.sessions().create_session(request).await {
            break status;
        }
    };
    assert_eq!(reason(&refused), "QUEUE_FULL");
    let retry = refused.get_details_retry_info().unwrap();
    assert!(retry.retry_delay.unwrap() > std::time::Duration::ZERO);
}

/// Bytes for one session on this block and nothing else.
async fn room_for(block: &Block) -> u64 {
    let server = Server::start().await;
    let parts = tokio_stream::iter(block.messages());
    let mesh = server
        .meshes()
        .upload_mesh(parts)
        .await
        .unwrap()
        .into_inner();
    let name = server.session(block.scene()).await;
    let session = server.describe(&name).await;
    // What it shares is built or still to come: their sum is that of the prediction.
    let held = session.memory_bytes + session.prepared_memory_bytes;
    // Scene and plan count too.
    (held + mesh.mesh.unwrap().memory_bytes).unsigned_abs() + (16 << 10)
}

#[tokio::test]
async fn an_evicted_factor_is_rebuilt_with_the_same_bits() {
    let (block, other) = (Block::new(3), Block::new(4));
    let config = Config {
        memory_budget_bytes: room_for(&other).await,
        ..Config::embedded()
    };
    let server = Server::with(config).await;
    let mut seen = Vec::new();
    for (round, block) in [&block, &other, &block].into_iter().enumerate() {
        server.upload(block).await;
        let session = server.session(block.scene()).await;
        let mut stream = server.open(open(&session)).await;
        stream.step(1, press(0.03, 1)).await;
        let finished = stream.result().await;
        assert_eq!(
            finished.report.as_ref().unwrap().factorisations,
            1,
            "round {round}"
        );
        seen.push(forces(&[finished]));
        drop(stream);
        let request = wire::DeleteSessionRequest { name: session };
        server.sessions().delete_session(request).await.unwrap();
    }
    assert_eq!(seen[0], seen[2]);
    assert_ne!(seen[0], seen[1]);
}

#[tokio::test]
async fn a_step_that_waits_for_a_slot_ends_at_its_deadline() {
    let config = Config {
        solver_slots: 1,
        ..Config::embedded()
    };
    let (server, session) = pressed(2, config).await;
    let mut stream = server.open(open(&session)).await;
    let update = |sequence| wire::LoadStepUpdate {
        sequence,
        step: Some(press(0.05, 100_000)),
        max_wall_time: duration(50),
    };
    for sequence in [1, 2] {
        let message = solve_request::Message::LoadStep(update(sequence));
        stream.send(message).await;
    }
    let mut last = Vec::new();
    while last.len() < 2 {
        let finished = stream.result().await;
        if finished.last {
            last.push((finished.sequence, finished.report.unwrap().termination()));
        }
    }
    let ended = wire::Termination::DeadlineExceeded;
    assert_eq!(last, [(1, ended), (2, ended)]);
}

#[tokio::test]
async fn a_cancel_is_read_behind_unread_results_and_rejections() {
    let (server, session) = pressed(2, Config::embedded()).await;
    let limited = wire::SolveOpen {
        fields: every_field(),
        max_unread_bytes: 1 << 20,
        ..open(&session)
    };
    let mut stream = server.open(limited).await;
    let mut watcher = server.watch(watch(&session, wire::WatchEnd::Session)).await;
    stream.step(1, press(0.05, 100_000)).await;
    for _ in 0..100 {
        stream.step(7, press(0.05, 1)).await;
    }
    stream
        .send(solve_request::Message::Cancel(wire::SolveCancel {
            sequence: 1,
        }))
        .await;
    // Nobody has read a byte of the stream.
    let results = watcher.update().await;
    let last = results.last().unwrap().report.as_ref().unwrap();
    assert_eq!(last.termination(), wire::Termination::Cancelled);
    let mut rejected = 0;
    while rejected < 100 {
        if let signorini_proto::v1::solve_response::Message::UpdateRejected(one) =
            stream.next().await
        {
            assert_eq!(rejection_reason(&one), "SEQUENCE_GAP");
            rejected += 1;
        }
    }
}
