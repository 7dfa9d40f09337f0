//! The examples of fluids: whether seals leak, where, and what the files say of it.
//!
//! Exact: forces are in balance, brackets of blow-off pressures are as narrow as asked for, and a tight
//! seal has a margin above the pressure of the fluid. The brackets on meshes of half the size, below which
//! they change by .1 %: O-ring .1479 to .1487, lip .02153 to .02174, kiss seal 9.33e-4 to 9.38e-4.

use serde_json::Value;

use crate::common::schema::{fault, result_lines};
use crate::common::{example, folder, run};

/// Solves an example, checks its lines against their schema, and gives its increments.
fn solve(name: &str, more: &[&str]) -> Vec<Value> {
    let scene = example(name);
    let arguments = ["solve", scene.to_str().unwrap(), "--json"];
    let run = run(arguments.into_iter().chain(more.iter().copied()));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let schema = result_lines();
    for line in run.lines() {
        assert_eq!(fault(&schema, &line), None, "{line}");
    }
    let steps = run.events("step");
    let converged = steps.iter().all(|step| step["termination"] == "converged");
    assert!(converged, "{:?}", steps.last());
    steps
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| unreachable!("{value}"))
}

/// Forces on the body of everything that acts on it.
fn forces(step: &Value) -> Vec<[f64; 3]> {
    let kinds = ["obstacles", "supports", "fluids"].into_iter();
    let all = kinds.filter_map(|kind| step[kind].as_object());
    let of = |one: &Value| [0, 1, 2].map(|axis| number(&one["force"][axis]));
    all.flat_map(|all| all.values().map(of)).collect()
}

/// Along the axis; around it the body bears itself.
fn assert_balanced(step: &Value) {
    let forces = forces(step);
    let sizes = forces.as_flattened().iter().map(|force| force.abs());
    let largest = sizes.fold(0.0, f64::max);
    let sum: f64 = forces.iter().map(|force| force[1]).sum();
    assert!(sum.abs() <= 1e-6 * largest, "{sum} of {forces:?}");
}

/// The bracket of the pressure at which a fluid leaks, no wider than a hundredth.
fn bracket(fluid: &Value) -> [f64; 2] {
    assert_eq!(fluid["tightness"], "leaks");
    let [low, high] = ["blow_off_low", "blow_off_high"].map(|end| number(&fluid[end]));
    assert!(low < high && high - low <= 0.01 * high, "{low} {high}");
    assert!((number(&fluid["pressure"]) - low).abs() < 1e-12);
    [low, high]
}

#[test]
fn oil_lifts_a_lip_and_the_files_say_when_and_where() {
    let folder = folder("lip_seal");
    let steps = solve("lip-seal.toml", &["--out", folder.to_str().unwrap()]);
    steps.iter().for_each(assert_balanced);
    let last = steps.last().expect("an increment");
    let [low, high] = bracket(&last["fluids"]["oil"]);
    let mut table = csv::Reader::from_path(folder.join("results.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let row = table.records().last().expect("a row").unwrap();
    let of = |name: &str| {
        let column = header.iter().position(|column| column == name);
        row[column.expect("a column")].to_owned()
    };
    assert_eq!(of("fluid.oil.tightness"), "leaks");
    assert_eq!(of("fluid.oil.blow_off_low").parse(), Ok(low));
    assert_eq!(of("fluid.oil.blow_off_high").parse(), Ok(high));
    let series = std::fs::read_to_string(folder.join("lip-seal.pvd")).unwrap();
    let file = "lip-seal_oil_leak_0005.vtp";
    assert!(
        series.contains(file) && folder.join(file).exists(),
        "{series}"
    );
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(
        page.contains("\"leaks\":[{\"fluid\":\"oil\""),
        "{}",
        folder.display()
    );
    assert!(page.contains("\"bracket\":["));
}

/// Solves a seal to blow-off, whose pressure on finer meshes is `expected`, within a hundredth and the
/// bracket.
fn blown_off(name: &str, fluid: &str, expected: f64) {
    let steps = solve(name, &[]);
    steps.iter().for_each(assert_balanced);
    assert!(margins(&steps, fluid).iter().all(|margin| *margin > 0.0));
    let [low, high] = bracket(&steps.last().expect("an increment")["fluids"][fluid]);
    assert!(
        low <= 1.01 * expected && 0.99 * expected <= high,
        "{low} {high}"
    );
}

/// How far each tight increment that has a path is from a leak.
fn margins(steps: &[Value], name: &str) -> Vec<f64> {
    let fluids = steps.iter().map(|step| &step["fluids"][name]);
    let tight = fluids.filter(|fluid| fluid["tightness"] == "tight");
    let paths = tight.map(|fluid| &fluid["leak_path"]);
    paths
        .filter(|path| !path.is_null())
        .map(|path| number(&path["margin_over_pressure"]))
        .collect()
}

#[test]
fn water_blows_an_o_ring_up_until_it_gets_past() {
    blown_off("o-ring-blow-off.toml", "water", 0.1483);
}

#[test]
fn air_lifts_a_kiss_seal_off_its_plate() {
    blown_off("kiss-seal.toml", "air", 9.355e-4);
}

#[test]
fn a_stopper_stays_tight_under_the_drug() {
    let steps = solve("syringe.toml", &[]);
    steps.iter().for_each(assert_balanced);
    let margins = margins(&steps, "drug");
    assert_eq!(margins.len(), steps.len());
    assert!(
        margins.iter().skip(1).all(|margin| *margin > 0.5),
        "{margins:?}"
    );
}

/// The ring feels the water from one side and hands it to the back-up ring, which closes the gap at
/// the lid: contact rises with the water.
#[test]
fn a_ring_before_its_back_up_ring_stays_tight_at_five_megapascals() {
    let steps = solve("backed-ring.toml", &[]);
    steps.iter().for_each(assert_balanced);
    let margins = margins(&steps, "water");
    assert_eq!(margins.len(), steps.len());
    assert!(margins.iter().all(|margin| *margin > 0.0), "{margins:?}");
    let last = steps.last().expect("an increment");
    let peak = number(&last["contacts"]["backing"]["peak_pressure"]);
    assert!(peak > 5.0, "{peak}");
    let water = &last["fluids"]["water"];
    assert_eq!(water["tightness"], "tight");
}
