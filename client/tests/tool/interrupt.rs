//! Ctrl-C while a scene is being solved.
#![cfg(feature = "embedded")]

use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::process::serve;
use crate::common::{example, run, signorini};
use serde_json::Value;

#[test]
fn the_first_interrupt_cancels_and_keeps_the_last_state() {
    interrupted("-INT", &[]);
}

#[test]
fn so_does_a_wish_of_the_system_that_the_process_end() {
    interrupted("-TERM", &[]);
}

#[test]
fn so_it_does_on_a_server_of_its_own() {
    let (process, url) = serve("127.0.0.1:0", "interrupted", "");
    interrupted("-INT", &["--server", &url]);
    drop(process);
}

#[test]
fn the_step_of_a_solve_that_was_killed_ends_when_its_patience_does() {
    let (process, url) = serve("127.0.0.1:0", "killed-solve", "");
    let scene = example("hertz-plane.toml");
    let mut child = signorini()
        .args(["solve", scene.to_str().unwrap(), "--json", "--server", &url])
        .args(["--set", "step.0.increments=100000", "--patience", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("\"event\":\"step\"")));
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = Instant::now();
    let state = || {
        let told = run(["session", "list", "--json", "--server", &url]);
        let [line] = told.lines().try_into().unwrap();
        line["state"].as_str().unwrap().to_owned()
    };
    while state() == "running" {
        assert!(killed.elapsed() < Duration::from_secs(30));
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(state(), "active");
    assert!(killed.elapsed() >= Duration::from_secs(1));
    drop(process);
}

/// Interrupts a solve after its first result.
fn interrupted(signal: &str, more: &[&str]) {
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
                    .args([signal, &id])
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
    let told: Vec<String> = lines.take(5).map(Result::unwrap).collect();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(told[2].starts_with("step incr"), "{told:?}");
    for (row, start) in told[3..].iter().zip(["   1    1  ", "   1    2  "]) {
        assert!(row.starts_with(start), "{told:?}");
    }
}
