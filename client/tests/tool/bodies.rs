//! The examples of several bodies: forces in balance, what is told of contact and ties, and the files.

use std::path::PathBuf;

use serde_json::Value;

use crate::common::schema::{fault, result_lines};
use crate::common::{Run, example, folder, run};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| unreachable!("{value}"))
}

/// An example that is solved, its lines as the schema has them, and the folder of its files.
fn solved(name: &str) -> (Run, PathBuf) {
    let folder = folder(name);
    let scene = example(&format!("{name}.toml"));
    let out = ["--out", folder.to_str().unwrap()];
    let arguments = ["solve", scene.to_str().unwrap(), "--json"];
    let run = run(arguments.into_iter().chain(out));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let schema = result_lines();
    for line in run.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    (run, folder)
}

#[test]
fn two_rollers_flatten_against_each_other_and_the_files_say_how_far() {
    let (run, folder) = solved("rollers");
    let steps = run.events("step");
    let last = steps.last().unwrap();
    let nip = &last["contacts"]["nip"];
    let pushed = number(&nip["force"][1]);
    let [shaft, bearing] =
        ["shaft", "bearing"].map(|name| number(&last["supports"][name]["force"][1]));
    // The upper roller is named first: what the lower one does to it, its shaft takes.
    assert!((pushed + shaft).abs() < 1e-5 * pushed, "{pushed} {shaft}");
    assert!((shaft + bearing).abs() < 1e-5 * pushed, "{shaft} {bearing}");
    let intervals = nip["contact_intervals"].as_array().unwrap();
    assert_eq!(intervals.len(), 1);
    let width = number(&nip["contact_width"]);
    assert!((number(&intervals[0]["width"]) - width).abs() < 1e-9 * width);
    let mean = pushed / width;
    assert!(
        (number(&nip["mean_pressure"]) / mean - 1.0).abs() < 0.02,
        "{nip}"
    );
    assert!(number(&nip["peak_pressure"]) > mean);
    // The nip lies on the line between the shafts.
    assert!(number(&nip["peak_pressure_place"][0]).abs() < 0.3, "{nip}");
    let table = std::fs::read_to_string(folder.join("results.csv")).unwrap();
    assert!(
        table
            .lines()
            .next()
            .unwrap()
            .contains("contact.nip.peak_pressure_y")
    );
    assert!(run.stderr.contains("contact nip") || run.stdout.contains("nip"));
}

#[test]
fn a_bush_is_tied_to_its_tubes_and_the_files_say_what_the_ties_carry() {
    let (run, folder) = solved("sleeved-bush");
    let steps = run.events("step");
    for step in &steps {
        assert_eq!(step["termination"], "converged");
    }
    let last = steps.last().unwrap();
    let [inner, outer] = ["inner", "outer"].map(|name| &last["ties"][name]);
    let [pin, seat] = ["pin", "seat"].map(|name| &last["supports"][name]);
    let size = number(&pin["force"][0]);
    assert!(size > 0.0, "{pin}");
    // The rubber is named first: what the tube does to it, the pin does to the tube.
    for axis in [0, 1] {
        let [a, b, c, d] = [pin, inner, outer, seat].map(|one| number(&one["force"][axis]));
        let apart = [b - a, c + a, d + a];
        assert!(apart.iter().all(|x| x.abs() < 1e-5 * size), "{apart:?}");
    }
    // About the same point.
    let [a, b] = [inner, outer].map(|one| number(&one["moment"][2]));
    assert!((a + b).abs() < 1e-4 * size, "{a} {b}");
    let around = 2.0 * std::f64::consts::PI;
    assert!((number(&inner["area"]) / (10.0 * around) - 1.0).abs() < 1e-4);
    assert!(number(&inner["gap"]) < 1e-3, "{inner}");
    let table = std::fs::read_to_string(folder.join("results.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(header.contains("tie.outer.peak_traction_y"), "{header}");
    assert!(run.stderr.contains("tie inner") || run.stdout.contains("inner"));
}

#[test]
fn the_folds_of_a_bellows_touch_each_other_and_bear_the_load() {
    let (run, folder) = solved("bellows");
    let steps = run.events("step");
    assert_eq!(steps.len(), 16);
    let head = |step: &Value| -number(&step["supports"]["head"]["force"][1]);
    for step in &steps {
        assert_eq!(step["termination"], "converged");
        let sum = head(step) - number(&step["supports"]["foot"]["force"][1]);
        assert!(sum.abs() < 1e-5 * head(step), "{sum}");
    }
    // Open up to 12 mm, and ever softer; then the folds touch, outside on two places more than inside.
    let width = |step: &Value, name: &str| number(&step["contacts"][name]["contact_width"]);
    let [open, shut] = [&steps[11], &steps[15]];
    for name in ["outer", "inner"] {
        assert!(width(open, name).abs() < f64::EPSILON);
        assert!(width(shut, name) > 2.0, "{shut}");
    }
    let stiffness = |last: usize| head(&steps[last]) - head(&steps[last - 1]);
    assert!(stiffness(11) < stiffness(1), "{}", stiffness(11));
    assert!(stiffness(15) > 20.0 * stiffness(11), "{}", stiffness(15));
    let places = |name: &str| {
        let intervals = shut["contacts"][name]["contact_intervals"].as_array();
        intervals.unwrap().len()
    };
    assert_eq!([places("outer"), places("inner")], [3, 2]);
    let table = std::fs::read_to_string(folder.join("results.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(header.contains("contact.outer.peak_pressure_y"), "{header}");
}

/// A scene of squares, one on the other, tied where they meet; the upper one is half as wide.
const STACKED: &str = r#"
kind = "plane-strain"

[[body]]
name = "low"
mesh = "SQUARE"

[[body]]
name = "up"
mesh = "SQUARE"
mesh_scale = 0.5
rotation = [0.0, 0.0, 3.141592653589793]
translation = [0.75, 1.5, 0.0]

[material.low-body]
model = "linear-elastic"
shear_modulus = 1.0
poisson_ratio = 0.3

[material.up-body]
model = "linear-elastic"
shear_modulus = 10.0
poisson_ratio = 0.3

[[tie]]
name = "seam"
between = ["low-y1", "up-y1"]
carries = "up-y1"

[[support]]
name = "ground"
on = "low-y0"
displacement = { x = 0.0, y = 0.0 }

[[support]]
name = "lid"
on = "up-y0"
displacement = { x = 0.0, y = -0.1 }
"#;

#[test]
fn bodies_of_files_of_their_own_are_put_in_their_places_and_tied() {
    let folder = folder("stacked");
    let square = example("meshes/square_n16.msh");
    let square = square.canonicalize().unwrap();
    let text = STACKED.replace("SQUARE", square.to_str().unwrap());
    let scene = folder.join("stacked.toml");
    std::fs::write(&scene, &text).unwrap();
    let told = run(["solve", scene.to_str().unwrap(), "--json"]);
    assert_eq!(told.code, Some(0), "{}", told.stderr);
    let steps = told.events("step");
    let last = steps.last().unwrap();
    let [ground, lid] = ["ground", "lid"].map(|name| number(&last["supports"][name]["force"][1]));
    let seam = &last["ties"]["seam"];
    // The lower square is named first: pressed down by the upper one, held up by the ground.
    let force = number(&seam["force"][1]);
    assert!(
        lid < 0.0 && (lid + ground).abs() < 1e-5 * ground,
        "{lid} {ground}"
    );
    assert!((force - lid).abs() < 1e-5 * ground, "{seam}");
    assert!((number(&seam["area"]) - 0.5).abs() < 1e-12, "{seam}");
    // Half of the wider surface is free, which is said.
    let said = told.stdout.clone() + &told.stderr;
    assert!(said.contains("50 % of `low-y1` has no partner"), "{said}");
    // Names that meet are refused by both.
    let text = text.replace("name = \"up\"", "name = \"low\"");
    std::fs::write(&scene, text).unwrap();
    let told = run(["solve", scene.to_str().unwrap()]);
    assert_eq!(told.code, Some(4), "{}", told.stderr);
    assert!(
        told.stderr.contains("`low` is that of two bodies"),
        "{}",
        told.stderr
    );
}
