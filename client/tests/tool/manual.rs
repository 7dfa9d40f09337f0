//! What README and manual let a newcomer run does what they say. Their Python is run by the
//! tests of the package.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::{Run, example, folder, run};

fn client() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page(path: &str) -> String {
    std::fs::read_to_string(client().join(path)).unwrap()
}

/// The only snippet of a language on a page.
fn snippet(page: &str, language: &str) -> String {
    let mark = format!("```{language}\n");
    assert_eq!(page.matches(&mark).count(), 1, "{language}");
    let (_, rest) = page.split_once(&mark).unwrap();
    rest.split_once("```").unwrap().0.to_owned()
}

/// Solves a scene of a page on this mesh.
fn solve_text(test: &str, scene: &str, mesh: &Path) -> (PathBuf, Run) {
    let folder = folder(test);
    let file = folder.join("ring.toml");
    std::fs::write(&file, scene).unwrap();
    let mesh = format!("mesh={:?}", mesh.to_str().unwrap());
    let out = folder.join("results");
    let [file, to] = [&file, &out].map(|path| path.to_str().unwrap());
    let run = run(["solve", file, "--set", &mesh, "--out", to, "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    (out, run)
}

/// Files of results that a page names, such as `results/ring.pvd`.
fn named_results(page: &str) -> Vec<&str> {
    let spans = page.split('`').skip(1).step_by(2);
    spans
        .filter_map(|span| span.strip_prefix("results/"))
        .collect()
}

fn assert_written(page: &str, out: &Path) {
    let names = named_results(page);
    assert!(names.len() >= 3, "{names:?}");
    for name in names {
        assert!(out.join(name).is_file(), "{name}");
    }
}

fn last_force(run: &Run, obstacle: &str, axis: usize) -> f64 {
    let last = run.events("step").pop().unwrap();
    assert_eq!(last["termination"], "converged");
    last["obstacles"][obstacle]["force"][axis].as_f64().unwrap()
}

#[test]
fn the_first_command_of_the_readme_writes_what_it_says() {
    let readme = page("../README.md");
    let commands = readme.lines().filter(|line| line.starts_with("cargo run "));
    let commands: Vec<&str> = commands.collect();
    let [command] = commands[..] else {
        unreachable!("{commands:?}");
    };
    let (_, arguments) = command.split_once("--bin signorini -- ").unwrap();
    let words: Vec<&str> = arguments.split_whitespace().collect();
    let ["solve", scene, "--out", "results"] = words[..] else {
        unreachable!("{arguments}");
    };
    let (scene, out) = (client().join("..").join(scene), folder("readme_first"));
    let [scene, to] = [&scene, &out].map(|path| path.to_str().unwrap());
    let run = run(["solve", scene, "--out", to, "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_written(&readme, &out);
    let unknowns = &run.events("plan")[0]["unknowns"];
    let all = unknowns.as_object().unwrap().values();
    let count = all.filter_map(Value::as_i64).sum::<i64>();
    let told = format!("{} {:03} unknowns", count / 1000, count % 1000);
    assert!(readme.contains(&told), "{told}");
}

#[test]
fn the_scene_of_the_readme_is_solved() {
    let scene = snippet(&page("../README.md"), "toml");
    let mesh = example("meshes/indent_l3.msh");
    let (_, run) = solve_text("readme_scene", &scene, &mesh);
    // Hertz, for a quarter: 4/3 E* sqrt(R) d^(3/2) / 4, with E* = 4 of this body; the block is
    // not a half-space, and stiffer.
    let hertz = 4.0 / 3.0 * 4.0 * 0.02_f64.powf(1.5) / 4.0;
    let force = -last_force(&run, "ball", 2);
    assert!((1.0..1.35).contains(&(force / hertz)), "{force} {hertz}");
}

#[test]
fn the_first_seal_of_the_manual_has_the_force_that_it_says() {
    let page = page("manual/first-seal.md");
    let scene = snippet(&page, "toml");
    // The mesh of the page, coarser.
    let mesh = client().join("tests/formats/ring2.msh");
    let (out, run) = solve_text("first_seal", &scene, &mesh);
    assert_written(&page, &out);
    assert!(page.contains("some 660 N at a fifth of\nsqueeze"));
    let force = -last_force(&run, "lid", 1);
    assert!((force / 660.0 - 1.0).abs() < 0.03, "{force}");
}
