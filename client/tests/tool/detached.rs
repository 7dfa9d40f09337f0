//! Scenes that a server goes on solving when their client has left.
#![cfg(feature = "embedded")]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;

use crate::common::process::{Process, serve, start};
use crate::common::schema::{fault, result_lines};
use crate::common::{example, folder, run, signorini};
use serde_json::Value;

const LONG: &str = "step.0.increments=100000";

fn server(test: &str) -> (Process, String) {
    serve("127.0.0.1:0", test, "maximum_in_flight = 2\n")
}

/// Hands an example over and gives the session's name.
fn detach(url: &str, scene: &Path, set: &str) -> String {
    let scene = scene.to_str().unwrap();
    let arguments = ["solve", scene, "--server", url, "--set", set];
    let detached = run(arguments.into_iter().chain(["--detach", "--json"]));
    assert_eq!(detached.code, Some(0), "{}", detached.stderr);
    let [line] = detached.lines().try_into().unwrap();
    assert_eq!(fault(&result_lines(), &line), None, "{line}");
    assert_eq!(line["event"], "session");
    line["name"].as_str().unwrap().to_owned()
}

/// The files for ParaView of a folder, by name: the others tell how long a run took.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap();
    let files = entries.map(|entry| {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read(path).unwrap())
    });
    let timed = ["results.jsonl", "results.csv", "report.html"];
    files
        .filter(|(name, _)| !timed.contains(&name.as_str()))
        .collect()
}

/// Results in a folder's lines, without what another run does in another time.
fn steps(folder: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(folder.join("results.jsonl")).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines
        .filter(|line: &Value| line["event"] == "step")
        .map(comparable)
        .collect()
}

fn comparable(mut line: Value) -> Value {
    for key in [
        "seconds",
        "memory_bytes",
        "reused",
        "factorisations",
        "eigenvalue_applications",
        "compliance_columns",
    ] {
        line.as_object_mut().unwrap().remove(key).unwrap();
    }
    line
}

/// Waits for the first result on a process's stdout; gives the rest of it.
fn first_step(process: &mut Process) -> BufReader<impl std::io::Read + use<>> {
    let mut lines = BufReader::new(process.0.stdout.take().unwrap());
    loop {
        let mut line = String::new();
        assert!(lines.read_line(&mut line).unwrap() > 0, "no result");
        let line: Value = serde_json::from_str(&line).unwrap();
        if line["event"] == "step" {
            return lines;
        }
    }
}

#[test]
fn a_detached_solve_can_be_watched_fetched_and_cancelled() {
    let (process, url) = server("detached");
    let remote = ["--server", &url];
    let with = |arguments: &[&'static str], session: &str| {
        let (command, rest) = arguments.split_first().unwrap();
        let arguments = [*command, session].into_iter();
        run(arguments.chain(rest.iter().copied()).chain(remote))
    };
    let scene = example("hertz-plane.toml");
    let session = detach(&url, &scene, "step.0.increments=3");
    let watched = with(&["watch", "--json"], &session);
    assert_eq!(watched.code, Some(0), "{}", watched.stderr);
    let events: Vec<_> = watched
        .lines()
        .iter()
        .map(|line| line["event"].clone())
        .collect();
    assert_eq!(
        (&events[0], events.last().unwrap()),
        (&"plan".into(), &"summary".into())
    );
    assert_eq!(watched.events("step").len(), 3);
    let schema = result_lines();
    for line in watched.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    let shown = with(&["watch"], &session);
    assert!(shown.stdout.contains("obstacle floor"), "{}", shown.stdout);

    let long = detach(&url, &scene, LONG);
    let mut watcher = start(["watch", &long, "--json", "--server", &url]);
    drop(first_step(&mut watcher));
    let unfinished = with(&["fetch"], &long);
    assert!(
        unfinished.stderr.contains("is not finished"),
        "{}",
        unfinished.stderr
    );
    let other = with(&["cancel", "--sequence", "7"], &long);
    assert!(
        other.stdout.contains("step 7 does not run"),
        "{}",
        other.stdout
    );
    let cancelled = with(&["cancel", "--json"], &long);
    assert_eq!(
        (cancelled.code, &cancelled.lines()[0]["sequence"]),
        (Some(0), &1.into())
    );
    assert_eq!(fault(&schema, &cancelled.lines()[0]), None);
    assert_eq!(watcher.0.wait().unwrap().code(), Some(3));
    let idle = with(&["cancel"], &long);
    assert_eq!(idle.code, Some(0));
    assert!(idle.stdout.contains("no step runs"), "{}", idle.stdout);
    assert_eq!(with(&["watch"], &long).code, Some(3));
    assert_eq!(with(&["watch"], "sessions/none").code, Some(2));
    drop(process);
}

#[test]
fn fetched_files_are_those_of_a_solve_that_writes_them() {
    let (process, url) = server("fetched");
    let folder = folder("fetched_files");
    let (solved, fetched) = (folder.join("solved"), folder.join("fetched"));
    let scene = example("hertz-plane.toml");
    let set = "step.0.increments=2";
    let direct = run([
        "solve",
        scene.to_str().unwrap(),
        "--server",
        &url,
        "--set",
        set,
        "--out",
        solved.to_str().unwrap(),
    ]);
    assert_eq!(direct.code, Some(0), "{}", direct.stderr);
    let session = detach(&url, &scene, set);
    assert_eq!(run(["watch", &session, "--server", &url]).code, Some(0));
    let out = fetched.to_str().unwrap();
    let fetch = run(["fetch", &session, "--server", &url, "--out", out, "--json"]);
    assert_eq!(fetch.code, Some(0), "{}", fetch.stderr);
    assert_eq!(fetch.events("step").len(), 2);
    let (solved_files, fetched_files) = (files(&solved), files(&fetched));
    assert_eq!(
        fetched_files.keys().collect::<Vec<_>>(),
        solved_files.keys().collect::<Vec<_>>()
    );
    assert_eq!(
        fetched_files.len(),
        7,
        "a series, two bodies, two obstacles, two outlines"
    );
    for (name, bytes) in &solved_files {
        assert!(fetched_files[name] == *bytes, "{name} differs");
    }
    assert_eq!(steps(&fetched), steps(&solved));
    drop(process);
}

#[test]
fn more_steps_than_the_server_holds_are_all_accepted_before_the_client_leaves() {
    let (process, url) = server("many_steps");
    let folder = folder("many_steps_scene");
    let scene = folder.join("steps.toml");
    let text = std::fs::read_to_string(example("hertz-plane.toml")).unwrap();
    let meshes = format!("{}/", example("meshes").to_str().unwrap());
    let more: String = (1..=4)
        .map(|step| {
            format!("[[step]]\nobstacle.floor = {{ translation = [0.0, 0.0, 0.05{step}] }}\n\n")
        })
        .collect();
    let text = text
        .replace("meshes/", &meshes)
        .replace("[[probe]]", &format!("{more}[[probe]]"));
    std::fs::write(&scene, text).unwrap();
    let session = detach(&url, &scene, "step.0.increments=2");
    let shown = run(["session", "show", &session, "--json", "--server", &url]);
    assert_eq!(shown.lines()[0]["last_accepted_sequence"], 5);
    assert_eq!(shown.lines()[0]["attached"], false);
    let watched = run(["watch", &session, "--json", "--server", &url]);
    let times: Vec<_> = watched
        .events("step")
        .iter()
        .map(|step| step["time"].clone())
        .collect();
    assert_eq!(times, [0.5, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let third = run(["fetch", &session, "--step", "3", "--json", "--server", &url]);
    assert_eq!(third.events("step").len(), 1);
    assert_eq!(third.events("step")[0]["step"], 3);
    let none = run(["fetch", &session, "--step", "6", "--server", &url]);
    assert_eq!(
        (none.code, none.stdout.as_str()),
        (Some(2), ""),
        "{}",
        none.stderr
    );
    drop(process);
}

#[test]
fn a_named_session_is_found_by_its_name_and_keeps_it() {
    let (process, url) = server("named");
    let bare = url.strip_prefix("http://").unwrap();
    let with = |arguments: &[&str]| {
        let output = signorini()
            .args(arguments)
            .env("SIGNORINI_SERVER", bare)
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (
            output.status.code(),
            text(output.stdout),
            text(output.stderr),
        )
    };
    let none = with(&["session", "list"]);
    assert_eq!((none.0, none.1.as_str()), (Some(0), ""));
    assert!(none.2.contains("has no sessions"), "{}", none.2);
    let scene = example("hertz-plane.toml");
    let solve = ["solve", scene.to_str().unwrap(), "--detach", "--name"];
    let named = with(&[&solve[..], &["ring-1"]].concat());
    assert_eq!((named.0, named.1.as_str()), (Some(0), "sessions/ring-1\n"));
    assert_eq!(with(&["watch", "ring-1"]).0, Some(0));
    let listed = with(&["session", "list"]).1;
    for part in [
        "sessions/ring-1  ",
        "1 of 1 steps done",
        " old, expires in ",
    ] {
        assert!(listed.contains(part), "{listed}");
    }
    let twice = with(&[&solve[..], &["ring-1"]].concat());
    assert_eq!(twice.0, Some(6), "{}", twice.2);
    let wrong = with(&[&solve[..], &["Ring 1"]].concat());
    assert_eq!(wrong.0, Some(2), "{}", wrong.2);
    drop(process);
}

#[test]
fn an_interrupted_watcher_leaves_the_step_alone() {
    let (process, url) = server("watcher");
    let session = detach(&url, &example("hertz-plane.toml"), LONG);
    let mut watcher = start(["watch", &session, "--json", "--follow", "--server", &url]);
    let mut rest = first_step(&mut watcher);
    watcher.signal("-INT");
    let mut text = String::new();
    rest.read_to_string(&mut text).unwrap();
    assert_eq!(watcher.0.wait().unwrap().code(), Some(130));
    let shown = run(["session", "show", &session, "--json", "--server", &url]);
    assert_eq!(shown.lines()[0]["state"], "running");
    // The end of the session is the end of watching it.
    let mut watcher = start(["watch", &session, "--json", "--follow", "--server", &url]);
    drop(first_step(&mut watcher));
    let deleted = run(["session", "delete", &session, "--server", &url]);
    assert_eq!(deleted.code, Some(0), "{}", deleted.stderr);
    assert_eq!(watcher.0.wait().unwrap().code(), Some(3));
    drop(process);
}

#[test]
fn a_server_that_is_told_to_end_leaves_the_last_state_to_its_client() {
    let (mut process, url) = server("terminated");
    let folder = folder("terminated_files");
    let scene = example("hertz-plane.toml");
    let mut solve = start([
        "solve",
        scene.to_str().unwrap(),
        "--server",
        &url,
        "--json",
        "--set",
        LONG,
        "--out",
        folder.to_str().unwrap(),
    ]);
    let mut rest = first_step(&mut solve);
    process.signal("-TERM");
    let mut text = String::new();
    rest.read_to_string(&mut text).unwrap();
    let mut told = String::new();
    let mut stderr = solve.0.stderr.take().unwrap();
    stderr.read_to_string(&mut told).unwrap();
    assert_eq!(solve.0.wait().unwrap().code(), Some(3), "{told}");
    assert!(
        told.contains("SHUTTING_DOWN") && told.contains("the last state is kept"),
        "{told}"
    );
    assert!(told.contains("cancelled: step 1"), "{told}");
    let last = steps(&folder).pop().unwrap();
    assert_eq!(last["termination"], "cancelled");
    assert!(folder.join("hertz-plane.pvd").exists());
    assert!(text.lines().last().unwrap().contains("summary"), "{text}");
    assert!(process.0.wait().unwrap().success());
}

#[test]
fn detaching_needs_a_server_that_stays() {
    let scene = example("hertz-plane.toml");
    let scene = scene.to_str().unwrap();
    let alone = run(["solve", scene, "--detach"]);
    assert_eq!((alone.code, alone.stdout.as_str()), (Some(2), ""));
    assert!(
        alone.stderr.contains("--detach needs --server"),
        "{}",
        alone.stderr
    );
    for wrong in [
        &["solve", scene, "--ttl", "60"][..],
        &["solve", scene, "--detach", "--ttl", "0"],
        &["solve", scene, "--detach", "--out", "folder"],
        &["watch", "sessions/a"],
        &["fetch", "sessions/a", "--server", "unix:/s", "--step", "0"],
    ] {
        assert_eq!(run(wrong.iter().copied()).code, Some(2), "{wrong:?}");
    }
}
