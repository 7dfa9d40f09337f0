//! Derivatives by the places of all vertices obey what holds for bodies that are scaled, moved or
//! turned as a whole, without any difference quotient, and agree with differences of whole solves.

use crate::common::meshes::{cube, irregular, mesh, square};
use crate::common::scenes::{elastic, probe, traction};
use crate::gradients::{Problem, linear, pressed};
use signorini::report::GoalReport;
use signorini::scene::{GoalQuestions, Pressure, SceneKind, Shape};
use signorini::{CancelToken, FieldName, GoalError, MeshParts};

/// Values by the places of vertices, then by what obstacles are made of and led by.
fn asked(problem: &Problem, goals: &[&str], parameters: &[&str]) -> Vec<GoalReport> {
    problem.ask(goals, &[&["mesh"], parameters].concat())
}

/// dJ/dX by vertices.
fn by_nodes(report: &GoalReport) -> &[[f64; 3]] {
    report.by_nodes.as_ref().expect("derivatives by places")
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Keys of the lengths of the obstacles of a problem with their values.
fn lengths(problem: &Problem, axes: usize) -> Vec<(String, f64)> {
    let mut all = Vec::new();
    for (obstacle, target) in problem
        .scene
        .obstacles
        .iter()
        .zip(&problem.steps[0].obstacles)
    {
        let Shape::Sphere { centre, radius } = obstacle.shape else {
            panic!("a ball");
        };
        let name = &obstacle.name;
        all.push((format!("obstacle.{name}.radius"), radius));
        for (axis, text) in ["x", "y", "z"].iter().enumerate().take(axes) {
            all.push((format!("obstacle.{name}.centre.{text}"), centre[axis]));
            let moved = target.translation.expect("a translation")[axis];
            all.push((format!("obstacle.{name}.translation.{text}"), moved));
        }
    }
    all
}

/// Asserts that goals are homogeneous of these degrees in all lengths together.
fn assert_homogeneous(problem: &Problem, axes: usize, goals: &[(&str, f64)]) {
    let lengths = lengths(problem, axes);
    let names: Vec<&str> = lengths.iter().map(|one| one.0.as_str()).collect();
    let texts: Vec<&str> = goals.iter().map(|one| one.0).collect();
    let found = asked(problem, &texts, &names);
    for (own, (_, degree)) in found.iter().zip(goals) {
        let places = by_nodes(own).iter().zip(problem.mesh.coordinates());
        let of_mesh: f64 = places.map(|(by, place)| dot(*by, *place)).sum();
        let derivatives = own.derivatives[1..].iter().zip(&lengths);
        let of_tools: f64 = derivatives.map(|((_, by), (_, length))| by * length).sum();
        let sum = of_mesh + of_tools;
        assert!(
            (sum - degree * own.value).abs() < 2e-9 * of_mesh.abs().max(own.value.abs()),
            "{}: {of_mesh} + {of_tools} = {sum}, {degree} x {}",
            own.goal,
            own.value
        );
    }
}

#[test]
fn goals_are_homogeneous_in_all_lengths_together() {
    let plane = [
        ("force.ball.y", 1.0),
        ("force.bar.x", 1.0),
        ("reaction.base.x", 1.0),
        ("strain_energy", 2.0),
        ("max_pressure.ball", 0.0),
    ];
    let solid = [
        ("force.ball.z", 2.0),
        ("reaction.base.x", 2.0),
        ("strain_energy", 3.0),
        ("max_pressure.bar", 0.0),
    ];
    for problem in [
        pressed(2, None),
        pressed(2, Some(30.0)),
        linear(2, 0.3),
        linear(2, 0.5),
    ] {
        assert_homogeneous(&problem, 2, &plane);
    }
    for problem in [
        pressed(3, None),
        pressed(3, Some(40.0)),
        linear(3, 0.3),
        linear(3, 0.5),
    ] {
        assert_homogeneous(&problem, 3, &solid);
    }
}

/// The pressed block as the section of a body about an axis, under a ball on that axis.
fn turned(mut problem: Problem) -> Problem {
    problem.scene.kind = Some(SceneKind::Axisymmetric);
    problem.scene.obstacles.pop();
    problem.scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0, 1.6, 0.0],
        radius: 0.6,
    };
    problem.steps[0].obstacles.pop();
    problem.scene.probes.clear();
    problem.scene.tractions = vec![traction("x1", [0.03, -0.02, 0.0])];
    problem
}

#[test]
fn goals_of_bodies_of_revolution_are_homogeneous_too() {
    let goals = [
        ("force.ball.y", 2.0),
        ("reaction.base.y", 2.0),
        ("strain_energy", 3.0),
        ("max_pressure.ball", 0.0),
    ];
    for problem in [
        pressed(2, None),
        pressed(2, Some(30.0)),
        linear(2, 0.3),
        linear(2, 0.5),
    ] {
        let mut problem = turned(problem);
        problem.scene.pressures = if problem.scene.materials == elastic(0.3).materials
            || problem.scene.materials == elastic(0.5).materials
        {
            Vec::new()
        } else {
            vec![Pressure {
                on: vec!["x1".to_owned()],
                value: 0.05,
            }]
        };
        assert_homogeneous(&problem, 2, &goals);
    }
}

#[test]
fn goals_do_not_see_that_all_is_moved_and_turn_with_it() {
    let problem = pressed(2, Some(30.0));
    let names = ["ball", "bar"];
    let motions: Vec<String> = (names.iter())
        .flat_map(|name| ["x", "y"].map(|axis| format!("obstacle.{name}.translation.{axis}")))
        .collect();
    let motions: Vec<&str> = motions.iter().map(String::as_str).collect();
    let found = asked(
        &problem,
        &["force.ball.x", "force.ball.y", "strain_energy"],
        &motions,
    );
    let centres: Vec<[f64; 2]> = lengths(&problem, 2)
        .chunks(5)
        .map(|own| [own[1].1 + own[2].1, own[3].1 + own[4].1])
        .collect();
    let turned = [-found[1].value, found[0].value, 0.0];
    for (own, turned) in found.iter().zip(turned) {
        let by = by_nodes(own);
        let tools: Vec<f64> = own.derivatives[1..].iter().map(|one| one.1).collect();
        let most = largest(by.as_flattened());
        for axis in 0..2 {
            let sum: f64 = by.iter().map(|by| by[axis]).sum();
            let sum = sum + tools[axis] + tools[2 + axis];
            assert!(sum.abs() < 1e-9 * most, "{} {axis}: {sum} {most}", own.goal);
        }
        let places = by.iter().zip(problem.mesh.coordinates());
        let of_mesh: f64 = places.map(|(by, x)| x[0] * by[1] - x[1] * by[0]).sum();
        let of_tools: f64 = (centres.iter().zip(tools.chunks(2)))
            .map(|(x, by)| x[0] * by[1] - x[1] * by[0])
            .sum();
        let error = of_mesh + of_tools - turned;
        assert!(
            error.abs() < 1e-9 * most,
            "{}: {error} {turned} {most}",
            own.goal
        );
    }
}

/// Asserts that derivatives by some vertices agree with central differences of whole solves.
fn assert_differences(problem: &Problem, parts: &MeshParts, goals: &[&str], vertices: &[usize]) {
    const STEP: f64 = 1e-6;
    let found = asked(problem, goals, &[]);
    let axes = parts.cell_kind.dimension();
    for &vertex in vertices {
        for axis in 0..axes {
            let [more, less] = [STEP, -STEP].map(|by| {
                let mut moved = parts.clone();
                moved.coordinates[vertex][axis] += by;
                let moved = Problem {
                    mesh: mesh(moved),
                    ..problem.clone()
                };
                moved.ask(goals, &[])
            });
            for ((own, more), less) in found.iter().zip(&more).zip(&less) {
                let by = by_nodes(own)[vertex][axis];
                let difference = (more.value - less.value) / (2.0 * STEP);
                let scale = difference
                    .abs()
                    .max(0.02 * largest(by_nodes(own).as_flattened()));
                assert!(
                    (by - difference).abs() < 2e-6 * scale,
                    "{} by {vertex} {axis}: {by} {difference}",
                    own.goal
                );
            }
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Vertices near these places.
fn near(parts: &MeshParts, places: &[[f64; 3]]) -> Vec<usize> {
    let far = |x: &[f64; 3], place: &[f64; 3]| -> f64 {
        x.iter().zip(place).map(|(a, b)| (a - b).powi(2)).sum()
    };
    let nearest = |place: &[f64; 3]| {
        let all = parts.coordinates.iter().enumerate();
        let all = all.min_by(|a, b| far(a.1, place).total_cmp(&far(b.1, place)));
        all.expect("a vertex").0
    };
    places.iter().map(nearest).collect()
}

#[test]
fn derivatives_in_the_plane_agree_with_differences_of_whole_solves() {
    let parts = irregular(square(8), 8);
    let places = [
        [0.43, 1.0, 0.0],
        [0.5, 0.5, 0.0],
        [1.0, 0.55, 0.0],
        [0.4, 0.0, 0.0],
        [0.0, 0.4, 0.0],
        [1.0, 1.0, 0.0],
    ];
    let vertices = near(&parts, &places);
    for mut problem in [pressed(2, None), linear(2, 0.3)] {
        problem.scene.probes = vec![probe("inside", [0.31, 0.71, 0.0])];
        problem.scene.body_force = [0.1, -0.2, 0.0];
        let goals = [
            "force.ball.y",
            "reaction.base.x",
            "displacement.inside.y",
            "strain_energy",
            "max_pressure.ball",
        ];
        assert_differences(&problem, &parts, &goals, &vertices);
    }
}

/// A ball that nothing rubs has no moment about its middle, a box has one.
#[test]
fn the_moment_of_a_box_agrees_with_differences_of_whole_solves() {
    let parts = irregular(square(8), 8);
    let mut problem = pressed(2, None);
    problem.scene.obstacles[0].shape = Shape::Box {
        centre: [0.43, 1.3, 0.0],
        half_sizes: [0.3, 0.3, 1.0],
        rounding: 0.25,
    };
    let vertices = near(
        &parts,
        &[[0.43, 1.0, 0.0], [0.25, 1.0, 0.0], [0.5, 0.6, 0.0]],
    );
    assert_differences(
        &problem,
        &parts,
        &["moment.ball.z", "force.ball.x"],
        &vertices,
    );
}

#[test]
fn derivatives_in_space_and_about_an_axis_agree_with_differences_of_whole_solves() {
    let parts = irregular(cube(3), 3);
    let vertices = near(&parts, &[[0.4, 0.6, 1.0], [0.4, 0.4, 0.4], [1.0, 0.4, 0.6]]);
    for problem in [pressed(3, Some(40.0)), linear(3, 0.5)] {
        assert_differences(
            &problem,
            &parts,
            &["force.ball.z", "strain_energy"],
            &vertices,
        );
    }
    let parts = irregular(square(8), 8);
    let vertices = near(&parts, &[[0.2, 1.0, 0.0], [0.5, 0.5, 0.0], [1.0, 0.5, 0.0]]);
    for problem in [turned(pressed(2, None)), turned(linear(2, 0.3))] {
        assert_differences(
            &problem,
            &parts,
            &["force.ball.y", "strain_energy"],
            &vertices,
        );
    }
}

#[test]
fn a_scene_that_asks_has_the_field_and_causes_are_told() {
    let mut problem = pressed(2, None);
    let questions = GoalQuestions {
        goals: vec!["force.ball.y".parse().expect("a goal")],
        parameters: vec!["mesh".parse().expect("a parameter")],
        ..GoalQuestions::default()
    };
    problem.scene.questions = vec![questions.clone()];
    let (session, reports) = crate::common::run(&problem.scene, &problem.steps, &problem.mesh);
    let own = &reports.last().expect("a report").goals[0];
    let field = session.field(FieldName::MeshGradient).expect("a field");
    assert_eq!(
        (field.components, &field.values[..]),
        (3, by_nodes(own).as_flattened())
    );
    let size = field.values.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(
        (own.derivatives[0].1 - size).abs() <= 1e-12 * size,
        "{own:?}"
    );
    problem.scene.questions = Vec::new();
    problem.scene.obstacles[0].friction = 0.2;
    problem.steps[0].increments = 1;
    let refused = problem.solved().answer(&questions, &CancelToken::new());
    assert!(
        matches!(refused, Err(GoalError::Absent { .. })),
        "{refused:?}"
    );
}
