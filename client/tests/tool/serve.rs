//! `serve` and the commands that look at a server.
#![cfg(feature = "embedded")]

use std::process::Stdio;

use crate::common::process::{serve, serve_with_log};
use crate::common::{example, folder, run, signorini};

#[test]
fn a_served_scene_is_solved_and_the_server_ends_on_a_signal() {
    let (mut process, url) = serve("127.0.0.1:0", "serve_tcp", "");
    assert!(url.starts_with("http://127.0.0.1:"), "{url}");
    let scene = example("hertz-plane.toml");
    let solved = run([
        "solve",
        scene.to_str().unwrap(),
        "--server",
        &url,
        "--quiet",
    ]);
    assert_eq!(
        (solved.code, solved.stdout.as_str()),
        (Some(0), ""),
        "{}",
        solved.stderr
    );
    let sessions = run(["session", "list", "--server", &url]);
    assert_eq!((sessions.code, sessions.stdout.as_str()), (Some(0), ""));
    process.signal("-TERM");
    assert!(process.0.wait().unwrap().success());
}

#[test]
fn a_server_whose_log_nobody_reads_any_more_goes_on() {
    let (mut process, url) = serve_with_log("127.0.0.1:0", "serve_mute", "", Stdio::piped());
    drop(process.0.stderr.take());
    let scene = example("hertz-plane.toml");
    let scene = scene.to_str().unwrap();
    for _ in 0..2 {
        let solved = run(["solve", scene, "--server", &url, "--quiet"]);
        assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    }
}

#[test]
fn meshes_are_put_listed_and_deleted_over_a_unix_socket() {
    let socket = std::env::temp_dir().join(format!("signorini-client-{}.sock", std::process::id()));
    let (process, url) = serve(&format!("unix:{}", socket.display()), "serve_unix", "");
    let server = ["--server", &url];
    let mesh = example("meshes/cube_n6.msh");
    let put = run(["mesh", "put", mesh.to_str().unwrap(), "--json"]
        .into_iter()
        .chain(server));
    assert_eq!(put.code, Some(0), "{}", put.stderr);
    let digest = put.lines()[0]["digest"].as_str().unwrap().to_owned();
    let list = run(["mesh", "list"].into_iter().chain(server));
    assert!(list.stdout.starts_with(&digest), "{}", list.stdout);
    assert!(
        list.stdout.contains("343 vertices, 1296 cells, 432 facets"),
        "{}",
        list.stdout
    );
    assert_eq!(
        run(["mesh", "delete", &digest].into_iter().chain(server)).code,
        Some(0)
    );
    assert_eq!(run(["mesh", "list"].into_iter().chain(server)).stdout, "");
    let bent = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/formats/sphere2.inp");
    let put = run(["mesh", "put", bent].into_iter().chain(server));
    assert!(
        put.stdout.contains("30 facets, 45 curved edges"),
        "{}",
        put.stdout
    );
    let missing = run(["session", "show", "sessions/none"]
        .into_iter()
        .chain(server));
    assert_eq!(missing.code, Some(2), "{}", missing.stderr);
    drop(process);
}

#[test]
fn addresses_that_others_can_reach_are_refused() {
    let refused = run(["serve", "--listen", "0.0.0.0:0"]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("0.0.0.0:0"), "{}", refused.stderr);
}

#[test]
fn a_secured_server_is_used_with_what_the_tool_has_made() {
    let made = folder("serve_tls_files");
    let path = |name: &str| made.join(name).to_str().unwrap().to_owned();
    let (tokens, authority) = (path("tokens.toml"), path("ca.pem"));
    let certs = run(["certs", "init", made.to_str().unwrap()]);
    assert_eq!(certs.code, Some(0), "{}", certs.stderr);
    let add = |name, role| {
        let added = run(["token", "add", name, "--role", role, "--tokens", &tokens]);
        assert_eq!(added.code, Some(0), "{}", added.stderr);
        let file = path(name);
        std::fs::write(&file, added.stdout).unwrap();
        file
    };
    let (solver, reader) = (add("line-1", "solve"), add("screen", "read"));
    let [certificate, key] = ["server.pem", "server.key"].map(path);
    let more =
        format!("tokens = {tokens:?}\ntls_certificate = {certificate:?}\ntls_key = {key:?}\n");
    let (process, url) = serve("127.0.0.1:0", "serve_tls", &more);
    assert!(url.starts_with("https://127.0.0.1:"), "{url}");
    let server = ["--server", &url, "--ca", &authority];
    let shown = |token| server.into_iter().chain(["--token-file", token]);
    let scene = example("hertz-plane.toml");
    let solve = ["solve", scene.to_str().unwrap(), "--quiet"];
    let solved = run(solve.into_iter().chain(shown(&solver)));
    assert_eq!(solved.code, Some(0), "{}", solved.stderr);
    let listed = run(["mesh", "list"].into_iter().chain(shown(&reader)));
    assert_eq!((listed.code, listed.stdout.as_str()), (Some(0), ""));
    for (token, said) in [
        (Some(&reader), "PERMISSION_DENIED"),
        (None, "UNAUTHENTICATED"),
    ] {
        let token = token.map(|token| ["--token-file", token]);
        let arguments = solve.into_iter().chain(server);
        let refused = run(arguments.chain(token.into_iter().flatten()));
        assert_eq!(refused.code, Some(6), "{}", refused.stderr);
        assert!(refused.stderr.contains(said), "{}", refused.stderr);
    }
    let unknown = run(["session", "list", "--server", &url]);
    assert_eq!(unknown.code, Some(2));
    assert!(unknown.stderr.contains("--ca"), "{}", unknown.stderr);
    let list = run(["token", "list", "--json", "--tokens", &tokens]);
    assert_eq!(list.lines()[1]["name"], "screen");
    for code in [0, 2] {
        let revoked = run(["token", "revoke", "screen", "--tokens", &tokens]);
        assert_eq!(revoked.code, Some(code), "{}", revoked.stderr);
    }
    drop(process);
}

#[test]
fn settings_are_checked_and_shown_with_their_origin() {
    let file = folder("config_show").join("server.toml");
    let path = file.to_str().unwrap();
    std::fs::write(&file, "solver_slots = 3\nlog_level = \"debug\"\n").unwrap();
    let checked = run(["config", "check", path]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    let shown = run(["config", "show", "--config", path, "--log-level=warn"]);
    let line = |key: &str| {
        let mut lines = shown.stdout.lines();
        let found = lines.find(|line| line.starts_with(key)).unwrap_or_default();
        found
            .split_whitespace()
            .skip(2)
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(line("solver_slots"), format!("3 # {path}"));
    let mut command = signorini();
    command.args(["config", "show", "--origin"]);
    let shown = command
        .env("SIGNORINI_HEARTBEAT_SECONDS", "20")
        .output()
        .unwrap();
    let shown = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.contains("# SIGNORINI_HEARTBEAT_SECONDS\n"), "{shown}");
    assert_eq!(line("log_level"), "\"warn\" # --log-level");
    assert_eq!(line("heartbeat_seconds"), "10 # default");
    let tokens = file.with_file_name("tokens.toml");
    std::fs::write(&tokens, "").unwrap();
    let loose = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    std::fs::set_permissions(&tokens, loose).unwrap();
    std::fs::write(&file, format!("tokens = \"{}\"", tokens.display())).unwrap();
    let checked = run(["config", "check", path]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    let told = checked.stderr.contains("warning: tokens: ") && checked.stderr.contains("chmod 640");
    assert!(told, "{}", checked.stderr);
    for (text, said) in [
        ("solver_slots = 1000000000", "solver_slots: must be at most"),
        ("solver_slot = 3", "did you mean `solver_slots`"),
        ("tokens = \"nowhere.toml\"", "nowhere.toml"),
        ("listen = \"0.0.0.0:1\"", "signorini certs init"),
    ] {
        std::fs::write(&file, text).unwrap();
        let refused = run(["config", "check", path]);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        assert!(refused.stderr.contains(said), "{}", refused.stderr);
    }
}

#[test]
fn a_plan_says_what_is_built_and_what_is_left_out() {
    let scene = example("cube-bend.toml");
    let plan = run(["plan", scene.to_str().unwrap()]);
    assert_eq!(plan.code, Some(0), "{}", plan.stderr);
    for part in [
        "6591 displacement, 343 pressure, 0 contact",
        "left out",
        "predicted memory",
    ] {
        assert!(plan.stdout.contains(part), "{part}\n{}", plan.stdout);
    }
    let plan = run(["plan", scene.to_str().unwrap(), "--json"]);
    assert_eq!(plan.lines()[0]["unknowns"]["displacement"], 6591);
    assert_eq!(plan.lines()[0]["constants"], serde_json::json!([]));
}

#[test]
fn a_plan_lists_the_numbers_in_force_where_it_is_asked() {
    let scene = example("cube-bend.toml");
    let plan = run(["plan", scene.to_str().unwrap(), "--constants"]);
    assert_eq!(plan.code, Some(0), "{}", plan.stderr);
    let row = "0.00390625: Below this a smaller part of the increment leads further. (sqp/search)";
    assert!(plan.stdout.contains(row), "{}", plan.stdout);
    let plan = run(["plan", scene.to_str().unwrap(), "--constants", "--json"]);
    let constants = plan.lines()[0]["constants"].clone();
    let all = constants.as_array().unwrap();
    assert!(all.len() > 100, "{}", all.len());
    let named = |one: &&serde_json::Value| one["name"] == "LEAST_LENGTH";
    assert_eq!(all.iter().find(named).unwrap()["value"], "0.00390625");
}

#[test]
fn the_doctor_says_what_a_server_finds_here() {
    let folder = folder("doctor");
    let run = run(["doctor", folder.to_str().unwrap()]);
    assert_eq!(run.code, Some(0), "{}", run.stdout);
    for what in ["instruction set", "cores", "memory", "descriptors", "clock"] {
        assert!(run.stdout.contains(what), "{}", run.stdout);
    }
    let gone = folder.join("not-there");
    let run = crate::common::run(["doctor", gone.to_str().unwrap()]);
    assert_eq!(run.code, Some(8), "{}", run.stdout);
    assert!(run.stdout.contains("fault   writes to disk"));
}
