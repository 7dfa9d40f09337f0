//! The identifier of a call: in the answer, and in every line of the log that belongs to it.

use std::io::Read as _;
use std::process::{Command, Stdio};

use signorini_proto::v1 as wire;
use tonic::Request;
use tonic::metadata::MetadataMap;

use crate::common::{Block, Server, folder};

const HEADER: &str = "x-request-id";

fn with_id<T>(message: T, id: &str) -> Request<T> {
    let mut request = Request::new(message);
    request.metadata_mut().insert(HEADER, id.parse().unwrap());
    request
}

fn id(metadata: &MetadataMap) -> String {
    metadata.get(HEADER).unwrap().to_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_call_keeps_its_identifier_in_its_answer_and_through_the_log() {
    let socket = format!("unix:{}", folder("request-id").join("socket").display());
    // Not to a terminal: one object a line without being asked.
    let mut process = Command::new(env!("CARGO_BIN_EXE_signorini-server"))
        .args(["--listen", &socket, "--metrics-listen", ""])
        .env_remove("RUST_LOG")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let server = Server::beside(&socket).await;
    let block = Block::new(1);
    server.upload(&block).await;
    let mut sessions = server.sessions();
    let create = wire::CreateSessionRequest {
        scene: Some(block.scene()),
        ..Default::default()
    };
    let made = sessions.create_session(with_id(create, "cell-7/42")).await;
    assert_eq!(id(made.unwrap().metadata()), "cell-7/42");
    let missing = || wire::GetSessionRequest {
        name: "sessions/none".into(),
    };
    let refused = sessions.get_session(with_id(missing(), "screen-1")).await;
    assert_eq!(id(refused.unwrap_err().metadata()), "screen-1");
    // What a log cannot bear is not taken, and what is not given is made.
    for request in [with_id(missing(), "two words"), Request::new(missing())] {
        let own = id(sessions.get_session(request).await.unwrap_err().metadata());
        assert!(own.len() == 16 && own.bytes().all(|byte| byte.is_ascii_hexdigit()));
    }
    let process_id = process.id().to_string();
    assert!(
        Command::new("kill")
            .arg(process_id)
            .status()
            .unwrap()
            .success()
    );
    let mut log = String::new();
    process
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut log)
        .unwrap();
    assert!(process.wait().unwrap().success());
    let lines: Vec<serde_json::Value> = log
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let of_call = |line: &serde_json::Value| {
        if line["target"] == "audit" {
            line["request"].clone()
        } else {
            line["spans"][0]["request"].clone()
        }
    };
    for (what, id) in [
        ("session started", "cell-7/42"),
        ("session ended", "cell-7/42"),
        ("call", "cell-7/42"),
        ("request refused", "screen-1"),
    ] {
        let found = lines
            .iter()
            .any(|line| line["message"] == what && of_call(line) == id);
        assert!(found, "`{what}` of {id} in\n{log}");
    }
}
