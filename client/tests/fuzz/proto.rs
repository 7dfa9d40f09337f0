//! No bytes make the decoders of messages, arrays and statuses panic or take
//! memory beyond their budget, and what is decoded is encoded again as it was.

use std::path::Path;

use crate::fuzz::memory::Budget;
use crate::fuzz::{Campaign, Corpus, Form};
use prost::Message;
use signorini_client::{Refusal, scene_file};
use signorini_proto::array::{self, Assembler};
use signorini_proto::v1;
use tonic_types::{ErrorDetails, StatusExt};

/// Tags and lengths of nested messages, and of a group, which proto3 does not have.
const WORDS: [&str; 8] = [
    "\n\u{0}",
    "\u{1a}\u{2}",
    "*\u{0}",
    "R\u{4}",
    "\u{8}\u{1}",
    "\u{b}\u{c}",
    "z\u{1}a",
    "\u{12}\u{7f}",
];

fn scene() -> v1::Scene {
    let every_key = include_str!("../../src/scene_file/every_key.toml");
    let file = scene_file::read(every_key, Path::new("every.toml"), &[]).unwrap();
    v1::Scene {
        mesh: format!("meshes/{}", "0123456789abcdef".repeat(4)),
        ..file.scene
    }
}

fn requests() -> Vec<Vec<u8>> {
    let scene = scene();
    let step = scene.steps.first().cloned();
    let update = |message| v1::SolveRequest {
        message: Some(message),
    };
    let load = v1::LoadStepUpdate {
        sequence: 1,
        step,
        max_wall_time: Some(prost_types::Duration {
            seconds: 60,
            nanos: 5,
        }),
    };
    let open = v1::SolveOpen {
        session: "sessions/abcd".into(),
        last_seen_event: Some(3),
        fields: vec![1, 2, 3, 4, 5, 6, 7],
        ..Default::default()
    };
    let creation = v1::CreateSessionRequest {
        scene: Some(scene),
        session_id: "press".into(),
        request_id: "once".into(),
        ..Default::default()
    };
    use v1::solve_request::Message;
    vec![
        creation.encode_to_vec(),
        update(Message::LoadStep(load)).encode_to_vec(),
        update(Message::Open(open)).encode_to_vec(),
        update(Message::Cancel(v1::SolveCancel { sequence: 1 })).encode_to_vec(),
    ]
}

fn answers() -> Vec<Vec<u8>> {
    let chunk = v1::FieldChunk {
        sequence: 1,
        event: 2,
        field: 1,
        element_type: 1,
        shape: vec![2, 3],
        data: array::encode(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        last: true,
        ..Default::default()
    };
    let finished = v1::StepFinished {
        sequence: 1,
        event: 2,
        report: Some(v1::StepReport::default()),
        fields: vec![1, 2],
        ..Default::default()
    };
    use v1::solve_response::Message;
    let answer = |message| v1::SolveResponse {
        message: Some(message),
    };
    vec![
        answer(Message::Field(chunk)).encode_to_vec(),
        answer(Message::StepFinished(finished)).encode_to_vec(),
    ]
}

/// A status as the service makes them.
fn status() -> Vec<u8> {
    let mut details = ErrorDetails::with_error_info(
        "SCENE_INVALID",
        "signorini",
        [("path".into(), "name".into())],
    );
    details.add_bad_request_violation("material.body", "is required");
    let status = tonic::Status::with_error_details(tonic::Code::InvalidArgument, "bad", details);
    status.details().to_vec()
}

/// Decodes as `M`; what was taken survives a round trip.
fn round_trip<M: Message + Default>(input: &[u8]) -> bool {
    let Ok(message) = M::decode(input) else {
        return false;
    };
    let bytes = message.encode_to_vec();
    let again = M::decode(&bytes[..]).expect("what was encoded can be decoded");
    // As bytes, for NaN is not equal to itself.
    assert_eq!(again.encode_to_vec(), bytes);
    true
}

/// Every message of the services that holds others.
fn decoded(input: &[u8]) -> usize {
    [
        round_trip::<v1::CreateSessionRequest>(input),
        round_trip::<v1::SolveRequest>(input),
        round_trip::<v1::UploadMeshRequest>(input),
        round_trip::<v1::ReadStepRequest>(input),
        round_trip::<v1::SolveResponse>(input),
        round_trip::<v1::UploadMeshResponse>(input),
    ]
    .into_iter()
    .filter(|taken| *taken)
    .count()
}

fn arrays(input: &[u8]) {
    let Ok(v1::SolveResponse {
        message: Some(v1::solve_response::Message::Field(chunk)),
    }) = v1::SolveResponse::decode(input)
    else {
        return;
    };
    if let Ok(count) = array::element_count(&chunk.shape) {
        let mut assembler = Assembler::<f64>::new(count);
        assembler.push(chunk.offset_elements, &chunk.data).ok();
        assert!(
            assembler
                .finish()
                .map_or(true, |values| values.len() == count)
        );
    }
}

#[test]
fn every_seed_is_a_message() {
    for seed in requests().iter().chain(&answers()) {
        assert!(decoded(seed) > 0, "{}", seed.escape_ascii());
    }
}

#[test]
fn all_bytes_are_decoded_or_refused_within_the_budget() {
    let seeds = [requests(), answers()].concat();
    let (corpus, budget) = (
        Corpus::new(Form::Messages, seeds, &WORDS),
        Budget::of_mebibytes(64),
    );
    let (mut taken, mut cases) = (0_usize, 0_usize);
    Campaign::from_environment().run(&corpus, |input, _| {
        (taken, cases) = (taken + decoded(input), cases + 1);
        arrays(input);
        budget.check();
    });
    eprintln!("{taken} messages of {cases} inputs");
    assert!(taken > 0 || cases < 1000);
}

#[test]
fn details_of_any_status_are_read_or_left_out() {
    let corpus = Corpus::new(Form::Messages, vec![status()], &WORDS);
    let budget = Budget::of_mebibytes(64);
    Campaign::from_environment().run(&corpus, |input, _| {
        let details = bytes::Bytes::copy_from_slice(input);
        let status = tonic::Status::with_details(tonic::Code::Internal, "bad", details);
        assert_eq!(Refusal::from(&status).code, tonic::Code::Internal);
        budget.check();
    });
}
