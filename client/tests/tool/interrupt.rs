//! Ctrl-C while a scene is being solved.
#![cfg(feature = "embedded")]

use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use crate::common::process::serve;
use crate::common::{example, signorini};
use serde_json::Value;

#[test]
fn the_first_interrupt_cancels_and_keeps_the_last_state() {
    interrupted(&[]);
}

#[test]
fn so_it_does_on_a_server_of_its_own() {
    let (process, url) = serve("127.0.0.1:0", "interrupted", "");
    interrupted(&["--server", &url]);
    drop(process);
}

/// Interrupts a solve after its first result.
fn interrupted(more: &[&str]) {
    let scene = example("hertz-plane.toml");
    let mut child = signorini()
        .args([
            "solve",
            scene.to_str().unwrap(),
            "--json",
            "--set",
            "step.0.increments=100000",
        ])
        .args(more)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut events = Vec::new();
    for line in BufReader::new(child.stdout.take().unwrap()).lines() {
        let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
        let first_step =
            line["event"] == "step" && events.iter().all(|event: &Value| event["event"] != "step");
        events.push(line);
        if first_step {
            let id = child.id().to_string();
            assert!(
                Command::new("kill")
                    .args(["-INT", &id])
                    .status()
                    .unwrap()
                    .success()
            );
        }
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let [.., last, summary] = events.as_slice() else {
        unreachable!()
    };
    assert_eq!(
        (&last["event"], &last["termination"]),
        (&"step".into(), &"cancelled".into())
    );
    assert_eq!(summary["event"], "summary");
    assert!(last["time"].as_f64().unwrap() < 1.0);
}

#[test]
fn a_log_tells_each_increment_when_it_is_done() {
    let scene = example("hertz-plane.toml");
    let many = "step.0.increments=100000";
    let mut child = signorini()
        .args(["solve", scene.to_str().unwrap(), "--set", many])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let told: Vec<String> = lines.take(4).map(Result::unwrap).collect();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(told[1].starts_with("step incr"), "{told:?}");
    for (row, start) in told[2..].iter().zip(["   1    1  ", "   1    2  "]) {
        assert!(row.starts_with(start), "{told:?}");
    }
}
