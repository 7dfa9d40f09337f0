//! Every example, solved through the server of the process, against its
//! reference.

use std::path::Path;

use crate::common::schema::{fault, result_lines};
use crate::common::{Run, example, folder, run};
use serde_json::Value;

/// Of the quarter models, from independent codes on the same meshes; of the sphere with
/// hats for the contact pressure.
const SPHERE_FORCE: f64 = -0.073123052969713 / 4.0;
const PLANE_FORCE: f64 = 0.070391246410417 / 4.0;

/// Direct solves with another finite element code on the mesh of the example.
const COOK_CORNER: f64 = 17.062315629153314;
const COOK_MIDPOINT: f64 = 16.30569870842602;

/// Solves an example and gives its last increment.
fn solve(name: &str, more: &[&str]) -> (Run, Value) {
    let scene = example(name);
    let arguments = ["solve", scene.to_str().unwrap(), "--json"];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let last = run.events("step").pop().unwrap();
    assert_eq!(last["termination"], "converged");
    (run, last)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn assert_near(value: &Value, reference: f64, relative: f64) {
    let value = number(value);
    assert!(
        (value - reference).abs() <= relative * reference.abs(),
        "{value} is not {reference}"
    );
}

#[test]
fn cube_bend_meets_its_reference() {
    let (run, last) = solve("cube-bend.toml", &["--verify"]);
    assert_near(&last["strain_energy"], 1.113336140715, 1e-7);
    assert_near(
        &last["probes"]["corner"]["displacement"][2],
        -2.27249749055,
        1e-7,
    );
    let summary = run.events("summary").pop().unwrap();
    for residual in ["equilibrium", "incompressibility", "complementarity", "gap"] {
        assert!(
            number(&summary["verification"][residual]) <= 1e-7,
            "{summary}"
        );
    }
}

#[test]
fn hertz_sphere_meets_its_reference() {
    let (run, last) = solve(
        "hertz-sphere.toml",
        &["--set", "solver.contact_space=linear"],
    );
    assert_near(&last["obstacles"]["ball"]["force"][2], SPHERE_FORCE, 1e-7);
    assert!(number(&last["obstacles"]["ball"]["contact_area"]) > 0.0);
    let schema = result_lines();
    for line in run.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    let events: Vec<_> = run
        .lines()
        .iter()
        .map(|line| line["event"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(
        (events[0].as_str(), events[events.len() - 1].as_str()),
        ("plan", "summary")
    );
}

#[test]
fn hertz_plane_meets_its_reference() {
    let (_, last) = solve("hertz-plane.toml", &[]);
    assert_near(&last["obstacles"]["floor"]["force"][2], PLANE_FORCE, 1e-7);
}

#[test]
fn cook_meets_its_reference() {
    let (_, last) = solve("cook.toml", &[]);
    let probes = &last["probes"];
    assert_near(&probes["corner"]["displacement"][1], COOK_CORNER, 1e-7);
    assert_near(&probes["midpoint"]["displacement"][1], COOK_MIDPOINT, 1e-7);
}

#[test]
fn manufactured_field_meets_its_error_table() {
    let (_, last) = solve("manufactured.toml", &[]);
    assert_near(&last["errors"]["displacement_l2"], 2.36252416e-3, 1e-3);
    assert_near(&last["errors"]["displacement_h1"], 1.00733052e-1, 1e-3);
    assert_near(&last["errors"]["pressure_l2"], 7.95444330e-3, 1e-3);
}

/// Drags extrapolated from three uniform refinements (two of the ball's mesh),
/// whose differences fall by four: the boundary is a polygon.
const CYLINDER_DRAG: f64 = 6.285e-3;
const BALL_DRAG: f64 = 9.633;

#[test]
fn flow_around_a_cylinder_has_its_drag_and_loses_no_mass() {
    let (_, last) = solve("stokes-cylinder.toml", &["--verify"]);
    let force = &last["supports"]["obstacle"]["force"];
    assert_near(&force[0], -CYLINDER_DRAG, 7e-3);
    assert!((number(&last["volume_ratio"]) - 1.0).abs() < 1e-7);
}

#[test]
fn flow_around_a_ball_has_its_drag_and_loses_no_mass() {
    let (_, last) = solve("stokes-obstacle.toml", &[]);
    let force = &last["supports"]["obstacle"]["force"];
    assert_near(&force[0], -BALL_DRAG, 2e-2);
    assert!((number(&last["volume_ratio"]) - 1.0).abs() < 1e-7);
}

/// A component of the force of an obstacle or support.
fn force(result: &Value, kind: &str, name: &str, component: usize) -> f64 {
    number(&result[kind][name]["force"][component])
}

#[test]
fn the_fluid_pushes_the_o_ring_to_its_wall_which_it_seals() {
    let (run, last) = solve("o-ring.toml", &[]);
    let squeezed = &run.events("step")[4];
    assert!(number(&squeezed["obstacles"]["lid"]["force"][1]) < -300.0);
    assert!(force(squeezed, "obstacles", "wall", 0).abs() < 1e-9);
    assert!(number(&last["obstacles"]["wall"]["max_pressure_deformed"]) > 4.0);
}

/// The pin's force on meshes two and four times finer: 264.778 and 264.765 with curved cells,
/// 264.531 and 264.694 with straight ones. The shaft's: 5.2520 and 5.2441, 5.2226 and 5.2403.
const PIN_FORCE: f64 = 264.764;
const SHAFT_FORCE: f64 = 5.244;

#[test]
fn pin_and_sleeve_of_the_bush_are_in_balance() {
    let (_, last) = solve("bush.toml", &[]);
    for component in 0..2 {
        let [pin, sleeve] = ["pin", "sleeve"].map(|name| force(&last, "supports", name, component));
        assert!((pin + sleeve).abs() < 1e-6 * PIN_FORCE, "{pin} {sleeve}");
    }
    assert_near(&last["supports"]["pin"]["force"][0], PIN_FORCE, 1e-3);
}

#[test]
fn the_lip_presses_its_shaft() {
    let (_, last) = solve("lip.toml", &[]);
    assert_near(&last["obstacles"]["shaft"]["force"][0], SHAFT_FORCE, 3e-3);
    // Its edge loses volume between the vertices; of nothing else there is a word.
    let warnings = last["warnings"].as_array().unwrap();
    let kinds: Vec<_> = warnings.iter().map(|one| one["kind"].as_str()).collect();
    assert_eq!(kinds, [Some("coarse_volume")], "{last}");
}

#[test]
fn a_stopper_that_slips_takes_the_coefficient_times_the_force_on_its_wall() {
    let (_, last) = solve("stopper.toml", &[]);
    let wall = force(&last, "obstacles", "barrel", 0);
    let plunger = force(&last, "supports", "plunger", 1);
    assert!(
        (plunger + 0.15 * wall).abs() < 1e-6 * plunger,
        "{plunger} {wall}"
    );
}

#[test]
fn finger_and_tyre_are_in_balance_with_what_holds_them() {
    for (scene, tool, held) in [("finger.toml", "rod", "bone"), ("tyre.toml", "road", "rim")] {
        let (_, last) = solve(scene, &[]);
        for component in 0..2 {
            let tool = force(&last, "obstacles", tool, component);
            let held = force(&last, "supports", held, component);
            assert!(
                (tool + held).abs() < 1e-6 * tool.abs().max(1.0),
                "{scene}: {tool} {held}"
            );
        }
    }
}

#[test]
fn a_roller_that_turns_faster_than_it_goes_drives_its_belt() {
    let (_, last) = solve("belt.toml", &[]);
    let roller = |component: usize| force(&last, "obstacles", "roller", component);
    let bed = |component: usize| force(&last, "supports", "bed", component);
    for component in 0..2 {
        assert!((roller(component) + bed(component)).abs() < 1e-6 * roller(1).abs());
    }
    assert!(roller(1) < -15.0 && roller(0) > 1.0, "{last}");
    let sticks = number(&last["obstacles"]["roller"]["stick_vertices"]);
    let slips = number(&last["obstacles"]["roller"]["slip_vertices"]);
    assert!(sticks > 0.0 && slips > 0.0, "{sticks} {slips}");
}

#[test]
fn the_plate_of_a_gripper_feels_the_egg_from_its_file() {
    let (_, last) = solve("gripper.toml", &[]);
    for component in [0, 2] {
        let egg = force(&last, "obstacles", "egg", component);
        let plate = force(&last, "supports", "plate", component);
        assert!((egg + plate).abs() < 1e-6 * 4.0, "{egg} {plate}");
    }
    assert_near(&last["obstacles"]["egg"]["force"][2], 3.92, 0.01);
    assert!(force(&last, "obstacles", "egg", 0) < -1.0, "{last}");
    let area = number(&last["obstacles"]["egg"]["contact_area"]);
    assert!((20.0..30.0).contains(&area), "{area}");
}

#[test]
fn increments_are_a_result_each() {
    let (run, _) = solve("hertz-plane.toml", &["--set", "step.0.increments=3"]);
    let times: Vec<f64> = run
        .events("step")
        .iter()
        .map(|step| number(&step["time"]))
        .collect();
    assert_eq!(times.len(), 3);
    assert!(
        (times[0] - 1.0 / 3.0).abs() < 1e-12 && (times[2] - 1.0).abs() < 1e-12,
        "{times:?}"
    );
}

#[test]
fn the_table_names_what_people_ask_for() {
    let scene = example("hertz-plane.toml");
    let short = run(["solve", scene.to_str().unwrap()]);
    assert_eq!(short.code, Some(0), "{}", short.stderr);
    for label in [
        "obstacle floor",
        "along its travel, of 0.05 so far",
        " ± ",
        "contact area",
        "pressure",
        "error estimate",
        "penetration",
        "seconds",
    ] {
        assert!(short.stdout.contains(label), "{label}\n{}", short.stdout);
    }
    let full = run(["solve", scene.to_str().unwrap(), "--verbose"]);
    for label in ["iterations", "SQP", "left out", "residuals"] {
        assert!(full.stdout.contains(label), "{label}\n{}", full.stdout);
        assert!(!short.stdout.contains(label), "{label}\n{}", short.stdout);
    }
}

#[test]
fn names_cannot_reach_into_a_terminal() {
    let scene = example("hertz-plane.toml");
    let set = ["--set", "name=\"a\\u001b[2Jb\""];
    let run = run(["solve", scene.to_str().unwrap()].into_iter().chain(set));
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    let refused = "name: has a control character";
    assert!(run.stderr.contains(refused), "{}", run.stderr);
    let told = run.stdout + &run.stderr;
    assert!(!told.contains('\u{1b}'), "{told}");
}

#[test]
fn a_folder_of_results_holds_the_series_and_the_lines() {
    let folder = folder("folder_of_results");
    let out = folder.to_str().unwrap();
    let (run, last) = solve(
        "hertz-plane.toml",
        &["--out", out, "--set", "step.0.increments=2"],
    );
    let series = std::fs::read_to_string(folder.join("hertz-plane.pvd")).unwrap();
    for file in [
        "hertz-plane_0001.vtu",
        "hertz-plane_floor_0001.vtp",
        "hertz-plane_0002.vtu",
        "hertz-plane_floor_0002.vtp",
    ] {
        assert!(
            folder.join(file).exists() && series.contains(file),
            "{file}"
        );
    }
    let lines = std::fs::read_to_string(folder.join("results.jsonl")).unwrap();
    assert_eq!(lines, run.stdout);
    check_table(&folder, &last);
    check_page(&folder);
    let displacement = vtu_array(&folder.join("hertz-plane_0002.vtu"), "displacement");
    let points = vtu_array(&folder.join("hertz-plane_0002.vtu"), "Points");
    let pole = points
        .chunks(3)
        .position(|point| point[0].hypot(point[1]).hypot(point[2] + 1.0) < 1e-9)
        .unwrap();
    let probe = &last["probes"]["pole"]["displacement"];
    for component in 0..3 {
        let difference = displacement[3 * pole + component] - number(&probe[component]);
        assert!(difference.abs() <= 1e-12, "{difference}");
    }
}

/// The spreadsheet has a row an increment, with the numbers of the lines.
fn check_table(folder: &Path, last: &Value) {
    let mut table = csv::Reader::from_path(folder.join("results.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    let of = |name: &str| {
        let column = header.iter().position(|column| column == name).unwrap();
        rows[1][column].parse::<f64>().unwrap()
    };
    let force = number(&last["obstacles"]["floor"]["force"][2]);
    assert!((of("floor.force_z") - force).abs() < 1e-15);
    assert!((of("floor.force_along_travel") - force).abs() < 1e-12 && force > 0.0);
    assert!((of("floor.travel") - 0.05).abs() < 1e-12);
}

/// The page holds the numbers and the surface, and is made again as it was.
fn check_page(folder: &Path) {
    let path = folder.join("report.html");
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.len() < 3_000_000, "{}", page.len());
    for part in [
        "hertz-plane",
        "\"along\":",
        "contact_pressure",
        "\"triangles\":",
    ] {
        assert!(page.contains(part), "{part}");
    }
    std::fs::remove_file(&path).unwrap();
    let again = run(["report", folder.to_str().unwrap()]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), page);
}

#[test]
fn increments_that_output_every_skips_bring_no_warning() {
    let folder = folder("skipped_increments");
    let out = folder.to_str().unwrap();
    let skip = ["--set", "step.0.increments=2", "--set", "output.every=2"];
    let more = [&["--out", out][..], &skip].concat();
    let (run, _) = solve("hertz-plane.toml", &more);
    assert!(!run.stderr.contains("warning:"), "{}", run.stderr);
    assert!(folder.join("hertz-plane_0001.vtu").exists());
    assert!(!folder.join("hertz-plane_0002.vtu").exists());
    let (run, _) = solve("hertz-plane.toml", &[&more[..], &["--quiet"]].concat());
    assert_eq!(run.stderr, "");
}

/// An array of doubles from a VTU file.
pub(crate) fn vtu_array(path: &Path, name: &str) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = bytes
        .windows(mark.len())
        .position(|window| window == mark)
        .unwrap();
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    let array = header.split(&format!("Name=\"{name}\"")).nth(1).unwrap();
    let offset = array
        .split("offset=\"")
        .nth(1)
        .unwrap()
        .split('"')
        .next()
        .unwrap();
    let block = &bytes[start + mark.len() + offset.parse::<usize>().unwrap()..];
    let length = u64::from_le_bytes(block[..8].try_into().unwrap()) as usize;
    let values = block[8..8 + length].chunks_exact(8);
    values
        .map(|value| f64::from_le_bytes(value.try_into().unwrap()))
        .collect()
}

/// The increments of a scene of the tests.
fn increments(name: &str, more: &[&str]) -> Vec<Value> {
    let scene = format!("{}/tests/scenes/{name}", env!("CARGO_MANIFEST_DIR"));
    let arguments = ["solve", &scene, "--json"];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    run.events("step")
}

/// Contact fractions of a pushed wave on a confined incompressible slab, from another code, up to
/// nine tenths of the pressure that closes it; beyond it the rest of the push is an even pressure.
#[test]
fn a_wave_pushed_on_a_confined_slab_is_borne_evenly_beyond_full_contact() {
    let steps = increments("wave-full-contact.toml", &[]);
    let result = |step: usize, key: &str| number(&steps[step]["obstacles"]["wave"][key]);
    for (step, fraction) in [0.195, 0.327, 0.4915, 0.6605, 0.788]
        .into_iter()
        .enumerate()
    {
        assert!((result(step, "contact_area") - 0.1 * fraction).abs() < 1e-4);
    }
    let full = [6, 7].map(|step| result(step, "contact_area"));
    assert!(full.iter().all(|area| (area - 0.1).abs() < 1e-9));
    let force = |step: usize| force(&steps[step], "obstacles", "wave", 2);
    let even = (force(7) - force(6)) / 0.1;
    let risen = result(7, "max_pressure") - result(6, "max_pressure");
    assert!((risen - even).abs() < 0.01 * even, "{risen} {even}");
}

/// Where programs go on without the curvature of contact in the place of a factor, one increment
/// takes 446 and, from other roundings, 3381.
#[test]
fn no_increment_of_an_x_ring_that_is_pressed_and_dragged_costs_ten_times_the_others() {
    let steps = increments("x-ring-rod.toml", &[]);
    assert_eq!(steps.len(), 36);
    for step in &steps {
        assert!(
            number(&step["preconditioner_applications"]) <= 320.0,
            "{step}"
        );
    }
}
