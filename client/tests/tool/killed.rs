//! A server that is killed and started again beneath a solve.
#![cfg(feature = "embedded")]

use std::io::{BufRead as _, BufReader};
use std::process::Stdio;

use crate::common::process::{Process, serve};
use crate::common::{example, folder, signorini};
use serde_json::Value;

const INCREMENTS: u64 = 80;

/// Where a server of this test lies and listens.
struct Place {
    socket: String,
    settings: String,
}

impl Place {
    fn new() -> Self {
        let folder = folder("killed-beneath-a-solve");
        Self {
            socket: format!("unix:{}", folder.join("socket").display()),
            settings: format!("data = \"{}\"\n", folder.join("data").display()),
        }
    }

    fn start(&self) -> (Process, String) {
        serve(&self.socket, "killed_settings", &self.settings)
    }
}

#[test]
fn a_solve_outlives_the_server_that_it_asks() {
    let place = Place::new();
    let (mut server, url) = place.start();
    let scene = example("hertz-plane.toml");
    let many = format!("step.0.increments={INCREMENTS}");
    let child = signorini()
        .args(["solve", scene.to_str().unwrap(), "--json", "--set", &many])
        .args(["--server", &url])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut solve = Process(child.unwrap());
    let mut increments = Vec::new();
    for line in BufReader::new(solve.0.stdout.take().unwrap()).lines() {
        let line: Value = serde_json::from_str(&line.unwrap()).unwrap();
        if line["event"] != "step" {
            continue;
        }
        increments.push(line["increment"].as_u64().unwrap());
        match increments.len() {
            // As a crash, and as an upgrade.
            20 | 60 => {
                server.signal("-KILL");
                server.0.wait().unwrap();
                server = place.start().0;
            }
            40 => {
                server.signal("-TERM");
                assert!(server.0.wait().unwrap().success());
                server = place.start().0;
            }
            _ => {}
        }
    }
    assert_eq!(solve.0.wait().unwrap().code(), Some(0));
    assert_eq!(increments, (1..=INCREMENTS).collect::<Vec<_>>());
}
