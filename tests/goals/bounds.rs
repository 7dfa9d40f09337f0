//! Bounds of the error of forces are above the true ones, by meshes fine enough to tell.

use std::sync::Arc;

use crate::common::meshes::{mesh, moved, square, unit_grid};
use crate::common::scenes::{HELD, elastic, mooney_rivlin, obstacle, push, rubber, support};
use crate::common::{assert_converged, close, run};
use signorini::report::GoalReport;
use signorini::scene::{GoalErrors, GoalQuestions, Probe, SceneKind, Shape};
use signorini::{CancelToken, Mesh, Scene, Step};

const GOALS: [&str; 2] = ["force.ball.y", "reaction.base.x"];

/// A block in plane strain, bonded below, under a ball off its middle.
pub(crate) fn block(body: Scene, depth: f64, increments: u32) -> (Scene, Step) {
    let mut scene = body;
    scene.solver.verify = false;
    scene.supports = vec![support("y0", HELD)];
    scene.supports[0].name = "base".to_owned();
    scene.supports[0].displacement[2] = None;
    let shape = Shape::Sphere {
        centre: [0.4, 2.0, 0.0],
        radius: 1.0,
    };
    scene.obstacles = vec![obstacle("ball", "y1", shape)];
    let mut step = push("ball", [0.0, -depth, 0.0]);
    step.increments = increments;
    (scene, step)
}

pub(crate) fn asked(goals: &[&str], problem: &(Scene, Step), mesh: &Arc<Mesh>) -> Vec<GoalReport> {
    let (session, reports) = run(&problem.0, std::slice::from_ref(&problem.1), mesh);
    reports.iter().for_each(assert_converged);
    let questions = GoalQuestions {
        goals: goals
            .iter()
            .map(|text| text.parse().expect("a goal"))
            .collect(),
        errors: GoalErrors::Bounded,
        ..GoalQuestions::default()
    };
    let answer = session.answer(&questions, &CancelToken::new());
    answer.expect("an answer")
}

fn assert_bounded(problem: &(Scene, Step)) {
    let reference = asked(&GOALS, problem, &mesh(square(48)));
    for count in [6, 12] {
        for (own, exact) in asked(&GOALS, problem, &mesh(square(count)))
            .iter()
            .zip(&reference)
        {
            let bound = own.bound.as_ref().expect("a bound");
            let error = (exact.value - own.value).abs();
            let ratios = [
                bound.estimate / (exact.value - own.value),
                bound.total() / error,
            ];
            assert!(bound.total() >= error, "{count} {}: {ratios:?}", own.goal);
            let sum: f64 = bound.cells.iter().sum();
            assert!(close(sum, bound.discretisation, 1e-12));
            assert!(bound.estimate.abs() <= bound.discretisation);
            assert!(
                bound.discretisation <= 0.2 * reference[0].value.abs(),
                "{bound:?}"
            );
        }
    }
}

#[test]
fn the_force_on_an_incompressible_block_is_within_its_bound() {
    assert_bounded(&block(elastic(0.5), 0.03, 1));
}

#[test]
fn the_force_on_a_compressible_block_is_within_its_bound() {
    assert_bounded(&block(elastic(0.3), 0.03, 1));
}

#[test]
fn the_force_on_rubber_is_within_its_bound() {
    assert_bounded(&block(rubber(mooney_rivlin(), None), 0.15, 3));
}

#[test]
fn the_bound_sees_the_edges_of_a_punch_inside_faces() {
    let (mut scene, step) = block(elastic(0.4), 0.02, 1);
    scene.obstacles[0].shape = Shape::Box {
        centre: [0.47, 1.5, 0.0],
        half_sizes: [0.21, 0.5, 1.0],
        rounding: 0.0,
    };
    let problem = (scene, step);
    let exact = asked(&GOALS, &problem, &mesh(square(60)))[0].value;
    for count in [5, 8] {
        let own = &asked(&GOALS, &problem, &mesh(square(count)))[0];
        let (error, bound) = (exact - own.value, own.bound.as_ref().expect("a bound"));
        let told = (count, bound.estimate / error, bound.total() / error.abs());
        assert!(error.abs() > 0.05 * exact.abs(), "{told:?}");
        assert!((0.4..2.5).contains(&told.1), "{told:?}");
        assert!((0.8..4.0).contains(&told.2), "{told:?}");
    }
}

#[test]
fn the_bound_falls_with_the_mesh() {
    let problem = block(rubber(mooney_rivlin(), Some(30.0)), 0.1, 2);
    let [coarse, fine] = [5, 10].map(|count| {
        let found = asked(&GOALS, &problem, &mesh(square(count)));
        found[0].bound.as_ref().expect("a bound").discretisation
    });
    assert!(fine < 0.6 * coarse, "{coarse} {fine}");
}

/// The pose of a pushed tool follows from the mesh: its force is known, a displacement below is not.
#[test]
fn a_displacement_under_a_pushed_punch_is_within_its_bound() {
    let (mut scene, mut step) = block(elastic(0.3), 0.0, 1);
    scene.obstacles[0].shape = Shape::Box {
        centre: [0.47, 1.5, 0.0],
        half_sizes: [0.21, 0.5, 1.0],
        rounding: 0.0,
    };
    scene.probes = vec![Probe {
        name: "mid".to_owned(),
        point: [0.47, 0.9, 0.0],
    }];
    step.obstacles[0].translation = None;
    step.obstacles[0].force = [None, Some(-0.1), None];
    let problem = (scene, step);
    let goals = ["force.ball.y", "displacement.mid.y"];
    let exact = asked(&goals, &problem, &mesh(square(60)))[1].value;
    for count in [5, 8, 12] {
        let found = asked(&goals, &problem, &mesh(square(count)));
        let [force, own] = [0, 1].map(|goal| found[goal].bound.as_ref().expect("a bound").total());
        let error = (found[1].value - exact).abs();
        assert!(
            force < 1e-6 && (found[0].value + 0.1).abs() < 1e-9,
            "{force}"
        );
        assert!(own >= error && own < 20.0 * error, "{count}: {own} {error}");
    }
}

/// A thick ring on a shaft that is wider than its hole by d, between frictionless plates: Lame's ring in plane
/// strain, G = 1, nu = 0.3, radii 1 and 2, height h,
/// force = 2 pi a h p,  p = d / a (b^2 - a^2) 2 G / (b^2 + a^2 (1 - 2 nu)).
#[test]
fn the_radial_force_on_a_shaft_is_that_of_lames_ring_within_its_bound() {
    let mut scene = elastic(0.3);
    scene.kind = Some(SceneKind::Axisymmetric);
    scene.supports = ["y0", "y1"]
        .map(|side| support(side, [None, Some(0.0), None]))
        .into();
    let shape = Shape::HalfSpace {
        point: [1.0, 0.0, 0.0],
        normal: [1.0, 0.0, 0.0],
    };
    scene.obstacles = vec![obstacle("shaft", "x0", shape)];
    let problem = (scene, push("shaft", [0.001, 0.0, 0.0]));
    let ring = |count: usize| {
        let (radial, axial) = (count, count.div_ceil(2));
        let grid = unit_grid(radial, axial);
        mesh(moved(grid, |[x, y, z]| [1.0 + x, 0.5 * y, z]))
    };
    let pressure = 0.001 * 3.0 * 2.0 / (4.0 + 0.4);
    let exact = std::f64::consts::TAU * 0.5 * pressure;
    for count in [2, 4, 8] {
        let own = &asked(&["force.shaft.x"], &problem, &ring(count))[0];
        let (error, bound) = (exact - own.value, own.bound.as_ref().expect("a bound"));
        let told = (count, error / exact, bound.total() / error.abs());
        assert!(error.abs() < 0.02 * exact && told.2 >= 1.0, "{told:?}");
    }
}

/// Neither is along a force: the pressure's dual solution is a spike, the energy is no linear
/// functional.
#[test]
fn the_largest_pressure_and_the_energy_are_within_their_bounds() {
    let goals = ["max_pressure.ball", "strain_energy"];
    for problem in [
        block(elastic(0.5), 0.03, 1),
        block(elastic(0.3), 0.03, 1),
        block(rubber(mooney_rivlin(), None), 0.15, 3),
    ] {
        let reference = asked(&goals, &problem, &mesh(square(48)));
        for count in [6, 12] {
            let found = asked(&goals, &problem, &mesh(square(count)));
            for (own, exact) in found.iter().zip(&reference) {
                let bound = own.bound.as_ref().expect("a bound");
                let error = (exact.value - own.value).abs();
                let told = (count, &own.goal, error, bound.total(), bound.estimate);
                assert!(bound.total() >= error, "{told:?}");
                assert!(bound.total() <= 2.0 * exact.value, "{told:?}");
            }
        }
    }
}
