//! How good forces are, and what they depend on, from the command line.
//!
//! References: differences of whole solves; the same scene on a finer mesh.
#![cfg(feature = "embedded")]

use std::path::Path;

use serde_json::Value;

use crate::common::schema::{fault, result_lines};
use crate::common::{Run, example, folder, run};

/// A ball pressed into a block of rubber, on a mesh of the examples.
const SCENE: &str = r#"
mesh = "square_n16.msh"
kind = "plane-strain"
[material.body]
model = "mooney-rivlin"
c10 = 0.4
c01 = 0.1
[[support]]
name = "base"
on = "y0"
displacement = { x = 0.0, y = 0.0 }
[[obstacle]]
name = "ball"
on = "y1"
shape = { kind = "cylinder", point = [0.45, 2.0, 0.0], axis = [0, 0, 1], radius = 1.0 }
[[step]]
increments = 2
obstacle.ball = { translation = [0.0, -0.1, 0.0] }
[solver]
tolerance = 1e-11
"#;

fn scene(folder: &Path, more: &str) -> String {
    let mesh = example("meshes/square_n16.msh");
    std::fs::copy(mesh, folder.join("square_n16.msh")).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, format!("{SCENE}{more}")).unwrap();
    path.to_str().unwrap().to_owned()
}

fn assert_done(run: &Run) {
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

/// The last increment of a solve whose lines keep to their schema.
fn solved(scene: &str, more: &[&str]) -> Value {
    let arguments = ["solve", scene, "--json", "--quiet"];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    assert_done(&run);
    let schema = result_lines();
    for line in run.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    run.events("step").pop().unwrap()
}

fn force(step: &Value) -> f64 {
    step["obstacles"]["ball"]["force"][1].as_f64().unwrap()
}

#[test]
fn gradients_are_those_of_whole_solves() {
    let folder = folder("gradients_are_those");
    let gradient = "[[gradient]]\nof = \"force.ball.y\"\nto = [\"material.body.c10\", \
                    \"obstacle.ball.radius\", \"obstacle.ball.translation.y\"]\n";
    let scene = scene(&folder, gradient);
    let goal = &solved(&scene, &[])["goals"]["force.ball.y"];
    let keys = [
        ("material.body.c10", "material.body.c10", 0.4),
        ("obstacle.ball.radius", "obstacle.ball.shape.radius", 1.0),
        (
            "obstacle.ball.translation.y",
            "step.0.obstacle.ball.translation.1",
            -0.1,
        ),
    ];
    for (parameter, key, value) in keys {
        let at = |value: f64| {
            let set = format!("{key}={value:?}");
            force(&solved(&scene, &["--set", &set]))
        };
        let step = 1e-5;
        let difference = (at(value + step) - at(value - step)) / (2.0 * step);
        let derivative = goal["derivatives"][parameter].as_f64().unwrap();
        let error = (derivative / difference - 1.0).abs();
        assert!(error < 1e-5, "{parameter}: {derivative} {difference}");
    }
}

#[test]
fn a_force_is_told_with_a_bound_that_a_finer_mesh_keeps() {
    let folder = folder("a_force_is_told_with_a_bound");
    let fields = "[output]\nfields = [\"displacement\", \"error_density\"]\n";
    let scene = scene(&folder, fields);
    let out = folder.join("out");
    let done = run([
        "solve",
        &scene,
        "--accuracy",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_done(&done);
    assert!(
        done.stdout.contains("goal               force.ball.y"),
        "{}",
        done.stdout
    );
    assert!(done.stdout.contains('±'), "{}", done.stdout);
    let mut table = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let row = table.records().last().unwrap().unwrap();
    let column = |name: &str| {
        let place = header.iter().position(|column| column == name);
        row[place.unwrap()].parse::<f64>().unwrap()
    };
    let (value, bound) = (
        column("goal.force.ball.y"),
        column("goal.force.ball.y.bound"),
    );
    let fine = folder.join("fine.msh");
    let refined = run([
        "refine",
        &scene,
        "-o",
        fine.to_str().unwrap(),
        "--levels",
        "2",
    ]);
    assert_done(&refined);
    let set = format!("mesh={}", fine.to_str().unwrap());
    let error = (force(&solved(&scene, &["--set", &set])) - value).abs();
    assert!(
        error <= bound && bound <= 0.1 * value.abs(),
        "{error} {bound} {value}"
    );
    let vtu = std::fs::read(out.join("scene_0001.vtu")).unwrap();
    let text = String::from_utf8_lossy(&vtu);
    assert!(text.contains("Name=\"error_density\""));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("\"goals\":{\"force.ball.y\""));
}

#[test]
fn names_that_are_not_there_are_refused_by_their_keys() {
    let bush = example("bush.toml");
    let without = run(["solve", bush.to_str().unwrap(), "--accuracy"]);
    assert_eq!(without.code, Some(2), "{}", without.stderr);
    let folder = folder("names_not_there");
    let scene = scene(
        &folder,
        "[accuracy]\nbound = [\"force.lid.y\", \"force.ball\"]\n",
    );
    let check = run(["check", &scene]);
    assert_ne!(check.code, Some(0));
    assert!(
        check.stderr.contains("accuracy.bound: `force.ball` is not"),
        "{}",
        check.stderr
    );
}
