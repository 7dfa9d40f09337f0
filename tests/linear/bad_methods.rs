//! Methods that nobody knows or that make no sense together are refused with the
//! path of their key and a reason.

use crate::common::refusals::{assert_refused, sphere};
use crate::common::scenes::{cube_bend, obstacle};
use signorini::Scene;
use signorini::scene::{Choice, MetricKind, SaddleMethod, UnknownName};

#[test]
fn methods_are_known_by_name() {
    let unknown = |read: Result<(), UnknownName>, nearest: [&str; 2]| {
        let message = read.expect_err("no such method").to_string();
        let [name, known] = nearest;
        let expected = format!("unknown method `{name}`; did you mean `{known}`?");
        assert_eq!(message, expected);
    };
    let saddle = "gccr".parse::<Choice<SaddleMethod>>();
    unknown(saddle.map(drop), ["gccr", "gcr"]);
    let metric = "fractionel".parse::<Choice<MetricKind>>();
    unknown(metric.map(drop), ["fractionel", "fractional"]);
    let mut scene = cube_bend(0.5);
    scene.solver.quadrature_degree = Some(0);
    assert_refused(&scene, "solver.quadrature_degree", &["between 1"]);
}

/// [`cube_bend`] by other methods.
fn with_methods(poisson_ratio: f64, methods: [&str; 3]) -> Scene {
    let mut scene = cube_bend(poisson_ratio);
    let [displacement, p1, saddle] = methods;
    scene.solver.displacement_preconditioner = displacement.parse().expect("a preconditioner");
    scene.solver.p1_solver = p1.parse().expect("a solver");
    scene.solver.saddle = saddle.parse().expect("a method");
    scene
}

#[test]
fn methods_that_make_no_sense_together_are_refused_with_a_reason() {
    let (multiplicative, key) = ("hierarchical-multiplicative", "displacement_preconditioner");
    let cases = [
        (0.5, ["auto", "auto", "cg"], "saddle", "saddle point"),
        (
            0.5,
            ["auto", "auto", "stationary"],
            "saddle",
            "saddle point",
        ),
        (
            0.3,
            ["auto", "auto", "minres"],
            "saddle",
            "pressure unknown",
        ),
        (
            0.3,
            ["auto", "auto", "arrow-hurwicz"],
            "saddle",
            "pressure unknown",
        ),
        (0.3, [multiplicative, "auto", "cg"], key, "not symmetric"),
        (
            0.5,
            [multiplicative, "auto", "minres"],
            key,
            "not symmetric",
        ),
        (
            0.5,
            ["auto", "ic-cg", "uzawa-cg"],
            "p1_solver",
            "not constant",
        ),
    ];
    for (poisson_ratio, methods, key, word) in cases {
        let scene = with_methods(poisson_ratio, methods);
        assert_refused(&scene, &format!("solver.{key}"), &[word]);
    }
}

#[test]
fn methods_that_know_no_contact_are_refused_there() {
    let touching = |poisson_ratio, methods| {
        let mut scene = with_methods(poisson_ratio, methods);
        scene.obstacles = vec![obstacle("ball", "z1", sphere(1.0))];
        scene
    };
    for (poisson_ratio, saddle) in [(0.5, "minres"), (0.5, "uzawa-cg"), (0.3, "cg")] {
        let scene = touching(poisson_ratio, ["auto", "auto", saddle]);
        assert_refused(&scene, "solver.saddle", &["contact"]);
    }
    let scene = touching(0.5, ["auto", "ic-cg", "auto"]);
    assert_refused(&scene, "solver.p1_solver", &["compliance"]);
}

#[test]
fn a_penalty_needs_incompressible_materials() {
    for (poisson_ratio, weight, word) in [
        (0.5, -1.0, "between 0 and"),
        (0.5, f64::NAN, "between 0 and"),
        (0.3, 1.0, "pressure unknown"),
        (0.49, 1.0, "incompressible"),
    ] {
        let mut scene = cube_bend(poisson_ratio);
        scene.solver.penalty = Some(weight);
        assert_refused(&scene, "solver.penalty", &[word]);
    }
}
