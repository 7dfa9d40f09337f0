//! `serve` and the commands that look at a server.
#![cfg(feature = "embedded")]

use crate::common::process::serve;
use crate::common::{example, run};

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
}
