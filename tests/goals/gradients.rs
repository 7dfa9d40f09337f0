//! Derivatives of goals obey the identities that hold for them without any difference quotient,
//! and agree with differences of whole solves.

use std::sync::Arc;

use crate::common::meshes::{cube, file, irregular, mesh, square};
use crate::common::scenes::{
    HELD, elastic, hertz_sphere, mooney_rivlin, obstacle, probe, pull, push, rollers, rubber,
    support, traction,
};
use crate::common::{assert_converged, run, values};
use signorini::report::GoalReport;
use signorini::scene::{
    GoalQuestions, MaterialModel, ObstacleTarget, Pressure, RubberModel, SceneKind, Shape,
    SurfaceGeometry,
};
use signorini::{CancelToken, FieldName, Mesh, Scene, Session, Step};

/// A problem whose last increment is asked about.
#[derive(Clone)]
pub(crate) struct Problem {
    pub(crate) scene: Scene,
    pub(crate) steps: Vec<Step>,
    pub(crate) mesh: Arc<Mesh>,
}

impl Problem {
    pub(crate) fn solved(&self) -> Session {
        let (session, reports) = run(&self.scene, &self.steps, &self.mesh);
        reports.iter().for_each(assert_converged);
        session
    }

    /// Values and derivatives.
    pub(crate) fn ask(&self, goals: &[&str], parameters: &[&str]) -> Vec<GoalReport> {
        ask(&self.solved(), goals, parameters)
    }

    /// The value of one goal.
    fn value(&self, goal: &str) -> f64 {
        self.ask(&[goal], &[])[0].value
    }
}

pub(crate) fn ask(session: &Session, goals: &[&str], parameters: &[&str]) -> Vec<GoalReport> {
    let questions = GoalQuestions {
        goals: goals
            .iter()
            .map(|text| text.parse().expect("a goal"))
            .collect(),
        parameters: parameters
            .iter()
            .map(|text| text.parse().expect("a parameter"))
            .collect(),
        ..GoalQuestions::default()
    };
    let answer = session.answer(&questions, &CancelToken::new());
    answer.expect("an answer")
}

/// Rubber, bonded below, under a ball and beside a bar: in the plane or in space.
pub(crate) fn pressed(dimension: usize, bulk_modulus: Option<f64>) -> Problem {
    let mut scene = rubber(mooney_rivlin(), bulk_modulus);
    scene.solver.verify = false;
    scene.solver.tolerance = 1e-12;
    let (bottom, top) = [("y0", "y1"), ("z0", "z1")][dimension - 2];
    scene.supports = vec![support(bottom, HELD)];
    scene.supports[0].name = "base".to_owned();
    let up = |height: f64| match dimension {
        2 => [0.43, height, 0.0],
        _ => [0.43, 0.56, height],
    };
    let ball = Shape::Sphere {
        centre: up(1.6),
        radius: 0.6,
    };
    let side = match dimension {
        2 => [1.4, 0.55, 0.0],
        _ => [1.4, 0.45, 0.55],
    };
    let bar = Shape::Sphere {
        centre: side,
        radius: 0.4,
    };
    scene.obstacles = vec![obstacle("ball", top, ball), obstacle("bar", "x1", bar)];
    if dimension == 2 {
        scene.supports[0].displacement = [Some(0.0), Some(0.0), None];
    }
    let mut step = push("ball", up(-0.08).map(|x| if x < 0.0 { x } else { 0.0 }));
    step.obstacles.push(ObstacleTarget {
        name: "bar".to_owned(),
        translation: Some([-0.06, 0.0, 0.0]),
        ..ObstacleTarget::default()
    });
    step.increments = 2;
    let parts = match dimension {
        2 => irregular(square(8), 8),
        _ => irregular(cube(3), 3),
    };
    Problem {
        scene,
        steps: vec![step],
        mesh: mesh(parts),
    }
}

/// A linear block under the same.
pub(crate) fn linear(dimension: usize, poisson_ratio: f64) -> Problem {
    let mut problem = pressed(dimension, None);
    problem.scene.materials = elastic(poisson_ratio).materials;
    problem.scene.tractions = vec![traction("x0", [0.03, -0.02, 0.0])];
    problem.scene.probes = vec![probe("inside", [0.3, 0.7, [0.0, 0.6][dimension - 2]])];
    problem.steps[0].increments = 1;
    problem
}

const AXES: [&str; 3] = ["x", "y", "z"];

fn forces(names: &[&str], dimension: usize) -> Vec<String> {
    let axes = |name: &&str| {
        let name = (*name).to_owned();
        AXES[..dimension]
            .iter()
            .map(move |axis| format!("force.{name}.{axis}"))
    };
    names.iter().flat_map(axes).collect()
}

fn motions(names: &[&str], dimension: usize) -> Vec<String> {
    let axes = |name: &&str| {
        let name = (*name).to_owned();
        AXES[..dimension]
            .iter()
            .map(move |axis| format!("obstacle.{name}.translation.{axis}"))
    };
    names.iter().flat_map(axes).collect()
}

fn borrowed(texts: &[String]) -> Vec<&str> {
    texts.iter().map(String::as_str).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, x| most.max(x.abs()))
}

/// Asserts that derivatives agree with central differences of whole solves.
pub(crate) fn assert_differences(problem: &Problem, goals: &[&str], changes: &[Change<'_>]) {
    let names: Vec<&str> = changes.iter().map(|change| change.0).collect();
    let found = problem.ask(goals, &names);
    for (place, (name, step, change)) in changes.iter().enumerate() {
        let [more, less] = [*step, -*step].map(|by| {
            let mut moved = problem.clone();
            change(&mut moved, by);
            moved.ask(goals, &[])
        });
        for ((own, more), less) in found.iter().zip(&more).zip(&less) {
            let difference = (more.value - less.value) / (2.0 * step);
            let scale = difference.abs().max(1e-3 * own.value.abs());
            let error = (own.derivatives[place].1 - difference).abs() / scale;
            assert!(
                error < 2e-6,
                "{} by {name}: {} by differences {difference}, {error:.1e}",
                own.goal,
                own.derivatives[place].1,
            );
        }
    }
}

/// Name, step, and what the step does to a problem.
pub(crate) type Change<'a> = (&'a str, f64, &'a dyn Fn(&mut Problem, f64));

pub(crate) fn set_c10(problem: &mut Problem, by: f64) {
    if let MaterialModel::Rubber {
        model: RubberModel::MooneyRivlin { c10, .. },
        ..
    } = &mut problem.scene.materials[0].model
    {
        *c10 += by;
    }
}

fn set_bulk(problem: &mut Problem, by: f64) {
    if let MaterialModel::Rubber {
        bulk_modulus: Some(bulk),
        ..
    } = &mut problem.scene.materials[0].model
    {
        *bulk += by;
    }
}

pub(crate) fn set_radius(problem: &mut Problem, by: f64) {
    if let Shape::Sphere { radius, .. } = &mut problem.scene.obstacles[0].shape {
        *radius += by;
    }
}

pub(crate) fn set_height(dimension: usize) -> impl Fn(&mut Problem, f64) {
    move |problem: &mut Problem, by: f64| {
        let target = &mut problem.steps[0].obstacles[0];
        if let Some(translation) = &mut target.translation {
            translation[dimension - 1] += by;
        }
    }
}

#[test]
fn what_one_obstacle_feels_of_another_the_other_feels_of_it() {
    for (dimension, problem) in [
        (2, pressed(2, None)),
        (3, pressed(3, Some(40.0))),
        (2, linear(2, 0.5)),
        (3, linear(3, 0.3)),
    ] {
        let names = ["ball", "bar"];
        let (goals, parameters) = (forces(&names, dimension), motions(&names, dimension));
        let found = problem.ask(&borrowed(&goals), &borrowed(&parameters));
        let most = largest(
            found
                .iter()
                .flat_map(|one| one.derivatives.iter().map(|own| own.1)),
        );
        for (i, row) in found.iter().enumerate() {
            for (j, column) in found.iter().enumerate() {
                let [own, other] = [row.derivatives[j].1, column.derivatives[i].1];
                assert!(
                    (own - other).abs() < 1e-9 * most,
                    "{dimension}: {} {} {own} {other}",
                    row.goal,
                    column.goal
                );
            }
            assert_eq!(row.borderline, 0);
        }
    }
}

#[test]
fn forces_of_goals_are_those_of_the_report() {
    for problem in [pressed(2, None), pressed(3, None), linear(3, 0.5)] {
        let (session, reports) = run(&problem.scene, &problem.steps, &problem.mesh);
        let last = reports.last().expect("a report");
        let found = ask(
            &session,
            &["force.ball.y", "moment.ball.z", "reaction.base.x"],
            &[],
        );
        let expected = [
            last.obstacles["ball"].force[1],
            last.obstacles["ball"].moment[2],
            last.supports["base"].force[0],
        ];
        for (own, expected) in found.iter().zip(expected) {
            let error = (own.value - expected).abs();
            assert!(
                error <= 1e-10 * last.obstacles["ball"].force[1].abs() + 1e-12,
                "{own:?}"
            );
            assert!(own.solver_error.abs() < 1e-8, "{own:?}");
        }
    }
}

#[test]
fn a_body_that_is_moved_with_its_tools_feels_nothing() {
    for (dimension, problem) in [(2, pressed(2, Some(30.0))), (3, pressed(3, None))] {
        let goals = forces(&["ball", "bar"], dimension);
        let goals = [borrowed(&goals), vec!["reaction.base.x"]].concat();
        for axis in &AXES[..dimension] {
            let parameters = [
                format!("support.base.{axis}"),
                format!("obstacle.ball.translation.{axis}"),
                format!("obstacle.bar.translation.{axis}"),
            ];
            for own in problem.ask(&goals, &borrowed(&parameters)) {
                let sum: f64 = own.derivatives.iter().map(|own| own.1).sum();
                let most = largest(own.derivatives.iter().map(|own| own.1));
                assert!(sum.abs() < 2e-9 * most.max(0.1), "{own:?}");
            }
        }
    }
}

#[test]
fn a_force_is_its_own_derivative_by_all_moduli_together() {
    for (dimension, bulk) in [(2, None), (2, Some(30.0)), (3, Some(40.0))] {
        let problem = pressed(dimension, bulk);
        let constants = [
            "material.body.c10",
            "material.body.c01",
            "material.body.bulk_modulus",
        ];
        let moduli = [Some(0.4), Some(0.1), bulk];
        let count = moduli.iter().flatten().count();
        for own in problem.ask(&["force.ball.y", "force.bar.x"], &constants[..count]) {
            let terms = own.derivatives.iter().zip(moduli.iter().flatten());
            let sum: f64 = terms
                .map(|(derivative, modulus)| derivative.1 * modulus)
                .sum();
            assert!(
                (sum - own.value).abs() < 2e-9 * own.value.abs(),
                "{own:?} {sum}"
            );
        }
    }
}

#[test]
fn the_nominal_stress_of_a_strip_answers_its_constants_as_rivlin_says() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-11;
    scene.supports = rollers();
    scene.supports.push(support("x1", [Some(0.0), None, None]));
    let stretch: f64 = 1.4;
    let problem = Problem {
        scene,
        steps: vec![pull("x1", [Some(stretch - 1.0), None, None], 2)],
        mesh: mesh(irregular(cube(2), 2)),
    };
    let found = problem.ask(
        &["reaction.x1.x"],
        &["material.body.c10", "material.body.c01", "support.x1.x"],
    );
    let slope = 0.8 * (1.0 + 2.0 * stretch.powi(-3)) + 0.2 * 3.0 * stretch.powi(-4);
    let expected = [
        2.0 * (stretch - stretch.powi(-2)),
        2.0 * (1.0 - stretch.powi(-3)),
        slope,
    ];
    for ((_, own), expected) in found[0].derivatives.iter().zip(expected) {
        assert!((own - expected).abs() < 1e-8 * expected, "{own} {expected}");
    }
}

#[test]
fn rubber_in_the_plane_agrees_with_differences_of_whole_solves() {
    assert_differences(
        &pressed(2, Some(30.0)),
        &["force.ball.y", "force.bar.x", "reaction.base.y"],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("material.body.bulk_modulus", 1e-3, &set_bulk),
            ("obstacle.ball.radius", 1e-5, &set_radius),
            ("obstacle.ball.translation.y", 1e-5, &set_height(2)),
        ],
    );
}

#[test]
fn rubber_in_space_under_pressure_agrees_with_differences_of_whole_solves() {
    let mut problem = pressed(3, None);
    problem.scene.pressures = vec![Pressure {
        on: vec!["y0".to_owned()],
        value: 0.05,
    }];
    let set_pressure = |problem: &mut Problem, by: f64| problem.scene.pressures[0].value += by;
    assert_differences(
        &problem,
        &["force.ball.z", "reaction.base.x"],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("obstacle.ball.translation.z", 1e-5, &set_height(3)),
            ("pressure.0", 1e-5, &set_pressure),
        ],
    );
}

#[test]
fn a_linear_block_agrees_with_differences_of_whole_solves() {
    let set_ratio = |problem: &mut Problem, by: f64| {
        if let MaterialModel::LinearElastic { poisson_ratio, .. } =
            &mut problem.scene.materials[0].model
        {
            *poisson_ratio += by;
        }
    };
    let set_traction = |problem: &mut Problem, by: f64| problem.scene.tractions[0].value[0] += by;
    for ratio in [0.3, 0.48] {
        assert_differences(
            &linear(2, ratio),
            &["force.ball.y", "displacement.inside.x"],
            &[
                ("material.body.poisson_ratio", 1e-5, &set_ratio),
                ("traction.0.x", 1e-4, &set_traction),
                ("obstacle.ball.radius", 1e-5, &set_radius),
            ],
        );
    }
}

#[test]
fn the_pose_of_a_pushed_ball_follows_in_all_derivatives() {
    let mut problem = pressed(2, None);
    problem.scene.obstacles.pop();
    problem.scene.probes = vec![probe("inside", [0.3, 0.7, 0.0])];
    problem.steps[0].obstacles = vec![ObstacleTarget {
        name: "ball".to_owned(),
        force: [None, Some(-0.25), None],
        ..ObstacleTarget::default()
    }];
    let set_force = |problem: &mut Problem, by: f64| {
        if let Some(force) = &mut problem.steps[0].obstacles[0].force[1] {
            *force += by;
        }
    };
    assert_differences(
        &problem,
        &["displacement.inside.y", "force.ball.y"],
        &[
            ("obstacle.ball.force.y", 1e-5, &set_force),
            ("material.body.c10", 1e-5, &set_c10),
        ],
    );
}

/// The base of a block pushed against a ball at rest.
fn pushed_base(mut problem: Problem, spring: f64) -> Problem {
    problem.scene.obstacles.pop();
    problem.scene.supports[0].displacement[1] = None;
    problem.scene.supports[0].load.stiffness[1] = (spring > 0.0).then_some(spring);
    problem.scene.probes = vec![probe("inside", [0.3, 0.7, 0.0])];
    problem.steps[0].obstacles.clear();
    problem.scene.supports[0].load.force[1] = Some(0.2);
    problem
}

#[test]
fn the_place_of_a_pushed_or_sprung_support_follows_in_all_derivatives() {
    let set_force = |problem: &mut Problem, by: f64| {
        if let Some(force) = &mut problem.scene.supports[0].load.force[1] {
            *force += by;
        }
    };
    for spring in [0.0, 0.7] {
        let problem = pushed_base(pressed(2, None), spring);
        assert_differences(
            &problem,
            &["displacement.inside.y", "force.ball.y", "reaction.base.x"],
            &[
                ("support.base.force.y", 1e-5, &set_force),
                ("material.body.c10", 1e-5, &set_c10),
                ("obstacle.ball.radius", 1e-5, &set_radius),
            ],
        );
    }
}

#[test]
fn rubber_about_an_axis_agrees_with_differences_of_whole_solves() {
    let mut problem = pressed(2, None);
    problem.scene.kind = Some(SceneKind::Axisymmetric);
    problem.scene.obstacles.pop();
    problem.scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0, 1.6, 0.0],
        radius: 0.6,
    };
    problem.steps[0].obstacles.pop();
    assert_differences(
        &problem,
        &["force.ball.y", "reaction.base.y"],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("obstacle.ball.radius", 1e-5, &set_radius),
            ("obstacle.ball.translation.y", 1e-5, &set_height(2)),
        ],
    );
}

#[test]
fn the_moment_of_a_box_agrees_with_differences_of_whole_solves() {
    let mut problem = pressed(2, None);
    problem.scene.obstacles[0].shape = Shape::Box {
        centre: [0.43, 1.3, 0.0],
        half_sizes: [0.3, 0.3, 1.0],
        rounding: 0.25,
    };
    assert_differences(
        &problem,
        &["moment.ball.z", "force.ball.x"],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("obstacle.ball.translation.y", 1e-5, &set_height(2)),
        ],
    );
}

#[test]
fn energy_and_largest_pressure_agree_with_differences_of_whole_solves() {
    let goals = ["strain_energy", "max_pressure.ball"];
    for bulk in [None, Some(30.0)] {
        let problem = pressed(2, bulk);
        let report = run(&problem.scene, &problem.steps, &problem.mesh).1;
        let last = report.last().expect("a report");
        let found = problem.ask(&goals, &[]);
        for (own, exact) in [
            (found[0].value, last.strain_energy),
            (found[1].value, last.obstacles["ball"].max_pressure),
        ] {
            assert!((own - exact).abs() < 1e-9 * exact, "{own} {exact}");
        }
        assert_differences(
            &problem,
            &goals,
            &[
                ("material.body.c10", 1e-5, &set_c10),
                ("obstacle.ball.radius", 1e-5, &set_radius),
                ("obstacle.ball.translation.y", 1e-6, &set_height(2)),
            ],
        );
    }
    for problem in [linear(2, 0.5), linear(3, 0.3), pressed(3, Some(40.0))] {
        assert_differences(
            &problem,
            &goals,
            &[("obstacle.ball.radius", 1e-5, &set_radius)],
        );
    }
}

#[test]
fn a_ball_on_a_half_space_answers_its_depth_and_radius_as_hertz_says() {
    let (mut scene, step) = hertz_sphere(0.3);
    scene.solver.verify = false;
    scene.obstacles[0].surface = SurfaceGeometry::AsMeshed;
    let problem = Problem {
        scene,
        steps: vec![step],
        mesh: file("indent_l2"),
    };
    let parameters = [
        "obstacle.ball.translation.z",
        "obstacle.ball.radius",
        "obstacle.ball.centre.z",
    ];
    let found = &problem.ask(&["force.ball.z"], &parameters)[0];
    // The block is some contact radii deep: both are a little more than on a half-space.
    let by_depth = -found.derivatives[0].1;
    // The lowest point stays where it is when the centre rises with the radius.
    let by_radius = found.derivatives[1].1 + found.derivatives[2].1;
    assert!(
        (by_depth * 0.05 / found.value - 1.5).abs() < 0.12,
        "{found:?}"
    );
    assert!((by_radius / found.value - 0.5).abs() < 0.12, "{found:?}");
}

#[test]
fn who_asks_changes_nothing_of_what_follows() {
    let problem = pressed(2, None);
    let further = push("ball", [0.0, -0.1, 0.0]);
    let [asked, not] = [true, false].map(|asks| {
        let mut session = problem.solved();
        if asks {
            ask(&session, &["force.ball.y"], &["material.body.c10"]);
        }
        crate::common::take(&mut session, &further);
        values(&session, FieldName::Displacement)
    });
    assert_eq!(asked, not);
}

#[test]
fn the_value_of_a_goal_needs_no_parameter() {
    assert!(linear(2, 0.3).value("force.ball.y") < 0.0);
}
