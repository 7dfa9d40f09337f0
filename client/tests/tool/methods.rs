//! Methods for comparison, asked for by name from a scene file: there with the feature
//! `compare`, refused by name without it.
#![cfg(feature = "embedded")]

use crate::common::{Run, example, run};
use serde_json::Value;

fn with(command: &str, changes: &[&str]) -> Run {
    let scene = example("cube-bend.toml");
    let changes = changes.iter().flat_map(|change| ["--set", *change]);
    let arguments = [command, scene.to_str().unwrap(), "--json"];
    run(arguments.into_iter().chain(changes))
}

fn step(changes: &[&str]) -> Value {
    let run = with("solve", changes);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    run.events("step").remove(0)
}

/// Displacement of the probe along the load.
fn corner(step: &Value) -> f64 {
    step["probes"]["corner"]["displacement"][2]
        .as_f64()
        .unwrap()
}

#[test]
#[cfg(feature = "compare")]
fn methods_are_chosen_by_their_keys_and_agree() {
    let default = step(&[]);
    for (changes, factor) in [
        (&["solver.saddle=arrow-hurwicz"][..], 2),
        (&["solver.saddle=minres"], 1),
        (&["solver.displacement_preconditioner=hierarchical-ssor"], 1),
        (&["solver.p1_solver=ic-cg"], 1),
    ] {
        let found = step(changes);
        let error = (corner(&found) - corner(&default)).abs();
        assert!(
            error < 1e-6 * corner(&default).abs(),
            "{changes:?}: {error}"
        );
        let count = |key: &str| found[key].as_u64().unwrap();
        let (iterations, taken) = (
            count("krylov_iterations"),
            count("preconditioner_applications"),
        );
        assert!(
            taken >= factor * iterations && taken <= factor * iterations + 2,
            "{changes:?}: {taken} {iterations}"
        );
    }
}

#[test]
#[cfg(not(feature = "compare"))]
fn methods_are_refused_by_key_and_feature() {
    for change in [
        "solver.saddle=minres",
        "solver.displacement_preconditioner=hierarchical-ssor",
        "solver.p1_solver=ic-cg",
    ] {
        let run = with("solve", &[change]);
        assert_eq!(run.code, Some(4), "{}", run.stderr);
        let key = change.split('=').next().unwrap();
        for word in [key, "feature `compare`"] {
            assert!(run.stderr.contains(word), "{}", run.stderr);
        }
    }
}

#[test]
fn a_penalty_reaches_the_solver() {
    let (plain, term) = (step(&[]), step(&["solver.penalty=1"]));
    let change = (corner(&term) - corner(&plain)).abs() / corner(&plain).abs();
    assert!(change > 1e-6 && change < 1e-2, "{change}");
    let run = with("solve", &["solver.penalty=-1"]);
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(run.stderr.contains("solver.penalty"), "{}", run.stderr);
}

#[test]
fn combinations_without_sense_exit_with_4_and_a_reason() {
    let run = with("solve", &["solver.saddle=minres", "solver.p1_solver=ic-cg"]);
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(
        run.stderr.contains("solver.p1_solver") && run.stderr.contains("not constant"),
        "{}",
        run.stderr
    );
}
