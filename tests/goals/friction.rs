//! Goals under friction agree with differences of whole solves, where points stick and where they
//! slip, and say where they cannot know the way.

use crate::bounds::{asked, block};
use crate::common::meshes::{mesh, square};
use crate::common::scenes::{elastic, mooney_rivlin, rubber};
use crate::gradients::{
    Problem, ask, assert_differences, linear, pressed, set_c10, set_height, set_radius,
};
use signorini::report::GoalReport;
use signorini::scene::{AskedAt, GoalErrors, GoalQuestions, SceneKind, Shape};
use signorini::{CancelToken, GoalError, Scene, Step};

/// The ball of a problem, rough, pressed and dragged in one increment.
fn dragged(mut problem: Problem, friction: f64) -> Problem {
    problem.scene.obstacles[0].friction = friction;
    problem.steps[0].increments = 1;
    if let Some(translation) = &mut problem.steps[0].obstacles[0].translation {
        translation[0] += 0.005;
    }
    problem
}

fn set_friction(problem: &mut Problem, by: f64) {
    problem.scene.obstacles[0].friction += by;
}

fn set_tresca(problem: &mut Problem, by: f64) {
    if let Some(bound) = &mut problem.scene.obstacles[0].tresca {
        *bound += by;
    }
}

fn set_way(problem: &mut Problem, by: f64) {
    if let Some(translation) = &mut problem.steps[0].obstacles[0].translation {
        translation[0] += by;
    }
}

/// Points of the ball that stick and that slip.
fn counts(problem: &Problem) -> [u32; 2] {
    let (_, reports) = crate::common::run(&problem.scene, &problem.steps, &problem.mesh);
    let ball = &reports.last().expect("a report").obstacles["ball"];
    [ball.stick_vertices, ball.slip_vertices]
}

#[test]
fn a_dragged_ball_on_rubber_agrees_with_differences_of_whole_solves() {
    let problem = dragged(pressed(2, None), 0.5);
    let [stick, slip] = counts(&problem);
    assert!(stick > 0 && slip > 0, "{stick} {slip}");
    assert_differences(
        &problem,
        &[
            "force.ball.x",
            "force.ball.y",
            "moment.ball.z",
            "reaction.base.x",
            "force.bar.x",
        ],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("obstacle.ball.friction", 1e-5, &set_friction),
            ("obstacle.ball.translation.x", 1e-6, &set_way),
            ("obstacle.ball.translation.y", 1e-6, &set_height(2)),
            ("obstacle.ball.radius", 1e-5, &set_radius),
        ],
    );
}

#[test]
fn a_dragged_ball_on_a_linear_block_agrees_with_differences_of_whole_solves() {
    for ratio in [0.3, 0.5] {
        let problem = dragged(linear(2, ratio), 0.5);
        let [stick, slip] = counts(&problem);
        assert!(stick > 0 && slip > 0, "{stick} {slip}");
        assert_differences(
            &problem,
            &["force.ball.x", "force.ball.y", "displacement.inside.x"],
            &[
                ("obstacle.ball.friction", 1e-5, &set_friction),
                ("obstacle.ball.translation.x", 1e-6, &set_way),
                ("obstacle.ball.translation.y", 1e-6, &set_height(2)),
                ("obstacle.ball.radius", 1e-5, &set_radius),
            ],
        );
    }
}

#[test]
fn a_given_bound_of_tractions_agrees_with_differences_of_whole_solves() {
    for mut problem in [linear(2, 0.3), pressed(2, Some(30.0))] {
        problem = dragged(problem, 0.0);
        problem.scene.obstacles[0].tresca = Some(0.6);
        let [stick, slip] = counts(&problem);
        assert!(stick > 0 && slip > 0, "{stick} {slip}");
        assert_differences(
            &problem,
            &["force.ball.x", "force.ball.y"],
            &[
                ("obstacle.ball.tresca", 1e-5, &set_tresca),
                ("obstacle.ball.translation.x", 1e-6, &set_way),
            ],
        );
    }
}

#[test]
fn a_dragged_ball_in_space_agrees_with_differences_of_whole_solves() {
    for problem in [dragged(linear(3, 0.3), 0.2), dragged(pressed(3, None), 0.2)] {
        let [stick, slip] = counts(&problem);
        assert!(stick + slip > 0, "{stick} {slip}");
        assert_differences(
            &problem,
            &["force.ball.x", "force.ball.y", "moment.ball.z"],
            &[
                ("obstacle.ball.friction", 1e-5, &set_friction),
                ("obstacle.ball.translation.x", 1e-6, &set_way),
                ("obstacle.ball.radius", 1e-5, &set_radius),
            ],
        );
    }
}

#[test]
fn a_rough_ball_about_an_axis_agrees_with_differences_of_whole_solves() {
    let mut problem = pressed(2, None);
    problem.scene.kind = Some(SceneKind::Axisymmetric);
    problem.scene.obstacles.pop();
    problem.scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0, 1.6, 0.0],
        radius: 0.6,
    };
    problem.scene.obstacles[0].friction = 0.2;
    problem.steps[0].obstacles.pop();
    problem.steps[0].increments = 1;
    assert_differences(
        &problem,
        &["force.ball.y", "reaction.base.y"],
        &[
            ("material.body.c10", 1e-5, &set_c10),
            ("obstacle.ball.friction", 1e-5, &set_friction),
            ("obstacle.ball.translation.y", 1e-6, &set_height(2)),
        ],
    );
}

/// The block of the bounds, under a rough ball that is dragged.
fn rough(body: Scene, friction: f64) -> (Scene, Step) {
    let (mut scene, mut step) = block(body, 0.03, 1);
    scene.obstacles[0].friction = friction;
    if let Some(translation) = &mut step.obstacles[0].translation {
        translation[0] = 0.01;
    }
    (scene, step)
}

#[test]
fn bounds_under_friction_are_above_the_true_errors() {
    let goals = ["force.ball.x", "force.ball.y", "reaction.base.x"];
    for (body, friction) in [
        (elastic(0.5), 0.3),
        (elastic(0.3), 1.0),
        (rubber(mooney_rivlin(), None), 0.3),
    ] {
        let problem = rough(body, friction);
        let reference = asked(&goals, &problem, &mesh(square(48)));
        let size = reference[1].value.abs();
        for count in [6, 12] {
            let found = asked(&goals, &problem, &mesh(square(count)));
            for (own, exact) in found.iter().zip(&reference) {
                let bound = own.bound.as_ref().expect("a bound");
                let error = (exact.value - own.value).abs();
                let told = (count, friction, &own.goal, error, bound.total());
                assert!(bound.total() >= error, "{told:?}");
                assert!(bound.total() <= 0.25 * size, "{told:?}");
                assert!(own.dual_residual <= 1e-4, "{own:?}");
            }
        }
    }
}

fn questions(parameters: &[&str]) -> GoalQuestions {
    GoalQuestions {
        goals: vec!["force.ball.y".parse().expect("a goal")],
        parameters: parameters
            .iter()
            .map(|text| text.parse().expect("a parameter"))
            .collect(),
        errors: GoalErrors::Bounded,
        at: AskedAt::Increments,
    }
}

/// Where something sticks behind several increments its place depends on them: values and bounds
/// are told, derivatives are not.
#[test]
fn derivatives_over_several_increments_are_refused_where_something_sticks() {
    let mut problem = dragged(pressed(2, None), 0.5);
    problem.steps[0].increments = 3;
    problem.scene.questions = vec![questions(&["material.body.c10"])];
    let (session, reports) = crate::common::run(&problem.scene, &problem.steps, &problem.mesh);
    let asked = session.answer(&questions(&["material.body.c10"]), &CancelToken::new());
    assert!(matches!(asked, Err(GoalError::NeedsHistory)), "{asked:?}");
    let first = &reports[0];
    assert_eq!(
        (first.goals[0].derivatives.len(), &first.goals_refused),
        (1, &None)
    );
    let last = reports.last().expect("a report");
    let told = |goal: &GoalReport| (goal.derivatives.len(), goal.bound.is_some());
    assert_eq!(told(&last.goals[0]), (0, true));
    let cause = last.goals_refused.as_ref().expect("a cause");
    assert!(
        cause.contains("friction over several increments"),
        "{cause}"
    );
}

/// In the plane what slips all over has forgotten where it was.
#[test]
fn derivatives_of_what_slips_all_over_need_no_history() {
    let mut problem = dragged(pressed(2, None), 0.1);
    problem.steps[0].increments = 2;
    if let Some(translation) = &mut problem.steps[0].obstacles[0].translation {
        translation[0] += 0.2;
    }
    let [stick, slip] = counts(&problem);
    assert!(stick == 0 && slip > 3, "{stick} {slip}");
    let found = ask(
        &problem.solved(),
        &["force.ball.x"],
        &["obstacle.ball.friction"],
    );
    assert_eq!(found[0].borderline, 0);
    assert_differences(
        &problem,
        &["force.ball.x", "force.ball.y"],
        &[
            ("obstacle.ball.friction", 1e-5, &set_friction),
            ("material.body.c10", 1e-5, &set_c10),
        ],
    );
}
