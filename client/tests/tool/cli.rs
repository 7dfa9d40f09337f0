//! The command line tool before it solves anything: arguments, files, messages
//! and exit codes.

use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;

use crate::common::{Run, example, folder, run, signorini};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Solves a copy of an example with one piece of its text replaced.
fn solve_changed(test: &str, from: &str, to: &str) -> Run {
    let original = std::fs::read_to_string(example("hertz-sphere.toml")).unwrap();
    assert!(original.contains(from));
    let folder = folder(test);
    let scene = folder.join("scene.toml");
    let meshes = format!("{}/", text(&example("meshes")));
    let changed = original.replacen(from, to, 1).replace("meshes/", &meshes);
    std::fs::write(&scene, changed).unwrap();
    run(["solve", text(&scene)])
}

fn assert_refused(run: &Run, message: &str) {
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(run.stderr.contains(message), "{}", run.stderr);
    assert_eq!(run.stdout, "");
}

#[test]
fn wrong_arguments_exit_with_2() {
    for arguments in [
        &["solve"][..],
        &["dance"],
        &["solve", "a.toml", "--set", "b"],
        &["mesh", "list"],
    ] {
        let run = run(arguments.iter().copied());
        assert_eq!(run.code, Some(2), "{arguments:?}");
        assert_eq!(run.stdout, "");
    }
    let run = run(["plan", "a.toml", "--server", "nowhere"]);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("unix:PATH"), "{}", run.stderr);
}

#[test]
fn help_names_every_exit_code() {
    let run = run(["--help"]);
    assert_eq!(run.code, Some(0));
    for code in [
        "0 ok",
        "3 not converged",
        "4 invalid",
        "5 no server",
        "6 refused",
        "130 interrupted",
    ] {
        assert!(run.stdout.contains(code), "{code}");
    }
}

#[test]
fn completions_are_printed_on_stdout() {
    let run = run(["completions", "bash"]);
    assert_eq!(run.code, Some(0));
    assert!(run.stdout.contains("_signorini()"));
    assert_eq!(run.stderr, "");
}

#[test]
fn a_server_that_does_not_answer_exits_with_5() {
    let scene = example("cube-bend.toml");
    let run = run(["solve", text(&scene), "--server", "unix:/no/such/socket"]);
    assert_eq!(run.code, Some(5));
    assert!(
        run.stderr.contains("unix:/no/such/socket"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_variable_that_is_set_to_nothing_is_as_unset() {
    let mut command = signorini();
    command.args(["session", "list", "--server", "127.0.0.1:1"]);
    for name in ["CA", "CERT", "KEY", "TOKEN", "TOKEN_FILE"] {
        command.env(format!("SIGNORINI_{name}"), "");
    }
    let told = command.output().unwrap();
    assert_eq!(told.status.code(), Some(5), "{told:?}");
    let mut command = signorini();
    let told = command
        .args(["session", "list"])
        .env("SIGNORINI_SERVER", "");
    let told = String::from_utf8(told.output().unwrap().stderr).unwrap();
    assert!(
        told.contains("required") && told.contains("--server <URL>"),
        "{told}"
    );
}

#[test]
fn a_port_of_another_protocol_exits_with_5_and_its_address() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut request = [0; 24];
            stream.read_exact(&mut request).unwrap();
            stream
                .write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n")
                .unwrap();
        }
    });
    let scene = example("cube-bend.toml");
    for arguments in [
        &["solve", text(&scene), "--server", &url][..],
        &["session", "list", "--server", &url],
    ] {
        let run = run(arguments.iter().copied());
        assert_eq!(run.code, Some(5), "{}", run.stderr);
        assert!(
            run.stderr.contains(&format!("answers at {url}: ")),
            "{}",
            run.stderr
        );
    }
}

#[test]
fn files_that_do_not_exist_are_named() {
    let here = std::env::current_dir().unwrap();
    let absent = run(["solve", "missing.toml"]);
    assert_refused(&absent, "error: missing.toml: ");
    assert_refused(
        &absent,
        &format!("looked for {}", text(&here.join("missing.toml"))),
    );
    let scene = example("cube-bend.toml");
    let run = run(["solve", text(&scene), "--set", "mesh=missing.msh"]);
    assert_refused(&run, "error: missing.msh: ");
    assert_refused(&run, "beside the scene");
}

#[test]
fn broken_meshes_are_refused_with_the_place() {
    let folder = folder("broken_meshes");
    let whole = std::fs::read(example("meshes/cube_n6.msh")).unwrap();
    let noise: Vec<u8> = (0..4000_u32)
        .map(|index| (index * index % 251) as u8)
        .collect();
    let scene = example("cube-bend.toml");
    for (name, bytes, message) in [
        ("cut.msh", &whole[..whole.len() / 2], "line "),
        ("noise.msh", &noise[..], "not a Gmsh MSH file"),
        ("other.stl", &b"solid part"[..], "meshio convert"),
    ] {
        let mesh = folder.join(name);
        std::fs::write(&mesh, bytes).unwrap();
        let run = run([
            "solve",
            text(&scene),
            "--set",
            &format!("mesh={}", text(&mesh)),
        ]);
        assert_refused(&run, name);
        assert!(run.stderr.contains(message), "{}", run.stderr);
    }
}

#[test]
fn unknown_keys_suggest_the_nearest_one_violation_a_line() {
    let run = solve_changed("unknown_keys", "radius = 1.0", "raduis = 1.0");
    assert_refused(
        &run,
        "error: obstacle.ball.shape.raduis: unknown key; did you mean \"radius\"?\n",
    );
    assert_refused(
        &run,
        "error: obstacle.ball.shape.radius: required key is missing\n",
    );
}

#[test]
fn an_empty_scene_is_refused() {
    let scene = folder("empty_scene").join("empty.toml");
    std::fs::write(&scene, "").unwrap();
    assert_refused(
        &run(["solve", text(&scene)]),
        "error: mesh: required key is missing\n",
    );
}

#[test]
fn a_scene_in_json_is_told_that_it_is_none_and_which() {
    let scene = folder("json_scene").join("scene.json");
    std::fs::write(&scene, "{\"mesh\": \"a.msh\"}").unwrap();
    let run = run(["check", text(&scene)]);
    assert_refused(&run, "it looks like JSON");
    assert_refused(&run, &format!("error: {}: ", text(&scene)));
}

#[test]
fn a_mesh_file_is_described_without_a_server() {
    let mesh = example("meshes/indent_l1.msh");
    let shown = run(["mesh", "info", text(&mesh)]);
    assert_eq!(shown.code, Some(0), "{}", shown.stderr);
    for part in ["tetrahedra", "group z1", " faces, from (", "mean ratio"] {
        assert!(shown.stdout.contains(part), "{part}\n{}", shown.stdout);
    }
    let line = run(["mesh", "info", text(&mesh), "--json"])
        .lines()
        .remove(0);
    let mut groups = line["groups"].as_array().unwrap().iter();
    let top = groups.find(|group| group["name"] == "z1").unwrap();
    assert!(top["low"][2].as_f64().unwrap().abs() < 1e-9, "{top}");
    assert_eq!(line["cell_kind"], "tetrahedra");
    let digest = line["name"].as_str().unwrap();
    assert!(digest.starts_with("meshes/"), "{digest}");
}

#[test]
fn the_version_is_told_by_a_word_as_by_a_flag() {
    let [word, flag] = ["version", "--version"].map(|one| run([one]));
    assert_eq!(word.code, Some(0), "{}", word.stderr);
    assert!(word.stdout.starts_with("signorini "), "{}", word.stdout);
    assert_eq!(word.stdout, flag.stdout);
}

#[test]
fn manual_pages_cover_the_commands() {
    let folder = folder("manual_pages");
    assert_eq!(run(["man", text(&folder)]).code, Some(0));
    let solve = std::fs::read_to_string(folder.join("signorini-solve.1")).unwrap();
    assert!(
        solve.contains("SIGNORINI_SERVER") && solve.contains("Examples"),
        "{solve}"
    );
    assert!(folder.join("signorini-mesh-info.1").exists());
}

#[test]
fn every_command_that_takes_a_scene_has_examples() {
    for command in ["solve", "plan", "serve", "watch", "fetch", "init", "mesh"] {
        let help = run([command, "--help"]);
        assert!(
            help.stdout.contains("Examples:\n  "),
            "{command}\n{}",
            help.stdout
        );
    }
}
