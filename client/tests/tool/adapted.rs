//! Forces known as well as a scene asks, by meshes that `solve` refines.
//!
//! Reference: the same scene, refined until its bound is a tenth.
#![cfg(feature = "embedded")]

use std::path::Path;

use serde_json::Value;

use crate::common::schema::{fault, result_lines};
use crate::common::{Run, example, folder, run};

/// A ball pressed into a bonded block, on a mesh of the examples.
const SCENE: &str = r#"
mesh = "square_n16.msh"
kind = "plane-strain"
[material.body]
model = "linear-elastic"
shear_modulus = 1
poisson_ratio = 0.5
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
obstacle.ball = { translation = [0.0, -0.03, 0.0] }
[accuracy]
"#;

fn scene(folder: &Path, accuracy: &str) -> String {
    let mesh = example("meshes/square_n16.msh");
    std::fs::copy(mesh, folder.join("square_n16.msh")).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, format!("{SCENE}{accuracy}")).unwrap();
    path.to_str().unwrap().to_owned()
}

fn solved(scene: &str, more: &[&str]) -> Run {
    let arguments = ["solve", scene, "--json"];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    let schema = result_lines();
    for line in run.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    run
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn last_round(run: &Run) -> Value {
    run.events("round").pop().unwrap()
}

#[test]
fn a_force_is_reached_and_results_are_those_of_the_last_mesh() {
    let folder = folder("a_force_is_reached");
    let fine = solved(&scene(&folder, "force.ball = 2e-4\n"), &["--quiet"]);
    assert_eq!(fine.code, Some(0), "{}", fine.stderr);
    let exact = number(&last_round(&fine)["goals"]["force.ball.y"]["value"]);
    let out = folder.join("out");
    let path = scene(&folder, "force.ball = 2e-3\nmax_unknowns = 1e6\n");
    let run = solved(&path, &["--out", out.to_str().unwrap()]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let (rounds, steps) = (run.events("round"), run.events("step"));
    assert!(rounds.len() > 1 && rounds[0]["end"].is_null());
    let last = last_round(&run);
    assert_eq!(last["end"], "reached");
    assert!(run.stderr.contains("mesh 2: "), "{}", run.stderr);
    let goal = &last["goals"]["force.ball.y"];
    let (value, bound) = (number(&goal["value"]), number(&goal["bound"]));
    assert!(bound <= 2e-3 * value.abs() && (value - exact).abs() <= bound);
    // Both increments are on the last mesh, with the bound of the force.
    assert_eq!(steps.len(), 2);
    let force = number(&steps[1]["obstacles"]["ball"]["force"][1]);
    assert!((force - value).abs() < 1e-6 * value.abs());
    let told = number(&steps[1]["goals"]["force.ball.y"]["bound"]["total"]);
    assert!((told - bound).abs() < 1e-3 * bound);
    let unknowns = &steps[1]["unknowns"];
    let all = ["displacement", "pressure", "contact"].map(|key| unknowns[key].as_i64().unwrap());
    assert_eq!(Some(all.iter().sum()), last["unknowns"].as_i64());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Refinement"));
}

#[test]
fn a_limit_that_comes_first_is_a_warning_and_has_an_exit_code() {
    let folder = folder("a_limit_that_comes_first");
    let path = scene(&folder, "force.ball.y = 1e-4\nmax_unknowns = 3000\n");
    let run = solved(&path, &[]);
    assert_eq!(run.code, Some(11), "{}", run.stderr);
    assert!(
        run.stderr
            .contains("warning: accuracy: not reached: the next mesh would have"),
        "{}",
        run.stderr
    );
    assert_eq!(last_round(&run)["end"], "max_unknowns");
    assert_eq!(run.events("step").len(), 2);
}

#[test]
fn steps_without_an_equilibrium_leave_what_they_leave_without_accuracy() {
    let folder = folder("steps_without_an_equilibrium");
    let path = scene(&folder, "force.ball.y = 0.01\n");
    let out = folder.join("out");
    let limit = ["--set", "solver.max_wall_time=1e-9"];
    let more = [&limit[..], &["--out", out.to_str().unwrap()]].concat();
    let run = solved(&path, &more);
    let plain = scene(&folder, "").replace("scene.toml", "plain.toml");
    let text = SCENE.replace("[accuracy]\n", "");
    std::fs::write(&plain, text).unwrap();
    let alone = solved(&plain, &limit);
    assert_eq!(run.code, alone.code, "{}", run.stderr);
    let of = |run: &Run| run.events("step")[0]["termination"].clone();
    assert_eq!(of(&run), of(&alone));
    let why =
        "warning: accuracy: not reached: step 1 found no equilibrium on the mesh of the scene";
    assert!(run.stderr.contains(why), "{}", run.stderr);
    assert!(run.events("round").is_empty() && out.join("report.html").exists());
}

#[test]
fn what_has_no_error_is_refused_with_its_key() {
    let folder = folder("what_has_no_error");
    let of = |accuracy: &str, more: &[&str]| {
        let run = solved(&scene(&folder, accuracy), more);
        assert_eq!(run.code, Some(4), "{}", run.stderr);
        run.stderr
    };
    assert!(of("force.lid.y = 0.01\n", &[]).contains("force.lid.y"));
    assert!(
        of(
            "force.ball = 0.01\n",
            &["--set", "step.0.obstacle.ball.translation=[0.1,-0.1,0]"]
        )
        .contains("along no single axis")
    );
}

#[test]
fn a_rough_ball_goes_its_way_on_every_mesh() {
    let folder = folder("a_rough_ball_goes_its_way");
    let path = scene(&folder, "force.ball.y = 0.01\n");
    let run = solved(&path, &["--set", "obstacle.0.friction=0.3"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let last = last_round(&run);
    assert_eq!(last["end"], "reached");
    let goal = &last["goals"]["force.ball.y"];
    let (value, bound) = (number(&goal["value"]), number(&goal["bound"]));
    assert!(bound <= 0.01 * value.abs());
    let steps = run.events("step");
    let force = number(&steps[1]["obstacles"]["ball"]["force"][1]);
    assert!((force - value).abs() < 1e-6 * value.abs());
}

#[test]
fn a_plan_is_that_of_the_first_mesh_and_says_so() {
    let folder = folder("a_plan_is_that_of_the_first_mesh");
    let path = scene(&folder, "force.ball = 0.01\n");
    let checked = run(["check", &path]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stderr.contains("[accuracy] has tolerances"));
}
