//! Meshes that are refined until a force is known where all steps are solved on each of them: under
//! friction, beside fluids, and where bodies touch or are tied.

use std::sync::Arc;

use crate::bodies::{linear, of_rubber, tied, touching};
use crate::common::meshes::{mesh, square};
use crate::common::run;
use crate::common::scenes::{
    HELD_IN_PLANE, elastic, mooney_rivlin, obstacle, push, rubber, support,
};
use crate::fluids::wet;
use crate::gradients::Problem;
use signorini::adapted::{
    Accuracy, AccuracyLimits, Adapted, AdaptionError, End, Problem as Asked, Target, Watch, adapt,
};
use signorini::report::{GoalReport, Silent};
use signorini::scene::{GoalErrors, GoalQuestions, SceneKind, Shape};
use signorini::{CancelToken, Mesh, Scene};

/// A block bonded below, pressed by a rough ball off its middle, which then moves on.
fn rough(body: Scene, friction: f64, moves: [[f64; 3]; 2]) -> Problem {
    let shape = Shape::Sphere {
        centre: [0.4, 2.0, 0.0],
        radius: 1.0,
    };
    let mut scene = Scene {
        supports: vec![support("y0", HELD_IN_PLANE)],
        obstacles: vec![obstacle("ball", "y1", shape)],
        ..body
    };
    scene.obstacles[0].friction = friction;
    scene.solver.verify = false;
    scene.solver.tolerance = 1e-9;
    Problem {
        scene,
        steps: moves.map(|to| push("ball", to)).to_vec(),
        mesh: mesh(square(4)),
    }
}

fn refined(problem: &Problem, goal: &str, tolerance: f64) -> Result<Adapted, AdaptionError> {
    let goal = goal.parse().expect("a goal");
    let accuracy = Accuracy {
        targets: vec![Target { goal, tolerance }],
        limits: AccuracyLimits::default(),
    };
    let watch = Watch {
        rounds: &mut |_| (),
        observer: &mut Silent,
        room: &mut |_| true,
        cancel: &CancelToken::new(),
    };
    let asked = Asked {
        scene: &problem.scene,
        steps: &problem.steps,
        mesh: &problem.mesh,
    };
    adapt(asked, &accuracy, watch)
}

/// The goal with its bound after all steps on a mesh.
fn bounded(problem: &Problem, goal: &str, mesh: &Arc<Mesh>) -> GoalReport {
    let (session, _) = run(&problem.scene, &problem.steps, mesh);
    let questions = GoalQuestions {
        goals: vec![goal.parse().expect("a goal")],
        errors: GoalErrors::Bounded,
        ..GoalQuestions::default()
    };
    let mut answers = session
        .answer(&questions, &CancelToken::new())
        .expect("answers");
    answers.remove(0)
}

/// Asserts that a goal is reached within `tolerance`, that its value is that of all steps on the last
/// mesh, and that it is as near to that of a `fine` mesh as both bounds say.
fn assert_reached(problem: &Problem, (goal, tolerance): (&str, f64), fine: &Arc<Mesh>) {
    let found = refined(problem, goal, tolerance).expect("a result");
    assert_eq!(found.end, End::Reached);
    assert!(found.rounds.len() > 1);
    let own = &found.rounds.last().expect("a round").goals[0];
    assert!(own.bound <= tolerance * own.value.abs(), "{own:?}");
    let whole = bounded(problem, goal, found.hierarchy.mesh());
    assert_eq!(whole.value.to_bits(), own.value.to_bits());
    let exact = bounded(problem, goal, fine);
    let left = exact.bound.as_ref().expect("a bound").total();
    let error = (own.value - exact.value).abs();
    assert!(error <= own.bound + left, "{error} {own:?} {left}");
    assert!(left <= 2.0 * own.bound, "{left} {own:?}");
}

#[test]
fn the_drag_of_a_rough_ball_is_reached_on_meshes_that_go_the_way_again() {
    let moves = [[0.0, -0.05, 0.0], [0.02, -0.05, 0.0]];
    let problem = rough(elastic(0.3), 0.3, moves);
    assert_reached(&problem, ("force.ball.x", 0.03), &mesh(square(40)));
    let problem = rough(rubber(mooney_rivlin(), None), 0.3, moves);
    assert_reached(&problem, ("force.ball.y", 0.03), &mesh(square(32)));
}

/// Pressed, then half lifted: what sticks on the way back has another force than on the way there.
#[test]
fn a_rough_ball_about_an_axis_that_is_lifted_again_is_reached() {
    let moves = [[0.0, -0.08, 0.0], [0.0, -0.05, 0.0]];
    let mut problem = rough(rubber(mooney_rivlin(), None), 0.1, moves);
    problem.scene.kind = Some(SceneKind::Axisymmetric);
    problem.scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0, 2.0, 0.0],
        radius: 1.0,
    };
    assert_reached(&problem, ("force.ball.y", 0.03), &mesh(square(32)));
    let mut straight = problem.clone();
    straight.steps.remove(0);
    let [lifted, straight] =
        [&problem, &straight].map(|one| bounded(one, "force.ball.y", &mesh(square(8))).value);
    assert!(
        (lifted - straight).abs() > 1e-5 * lifted.abs(),
        "{lifted} {straight}"
    );
}

#[test]
fn the_force_on_a_wet_block_is_reached() {
    let moves = [[0.0, -0.04, 0.0], [0.0, -0.08, 0.0]];
    let problem = wet(rough(elastic(0.3), 0.0, moves));
    assert_reached(&problem, ("force.ball.y", 0.03), &mesh(square(48)));
}

/// Bodies that touch, rub or are tied: the mesh of both is refined.
#[test]
fn the_force_on_two_bodies_is_reached() {
    let mut rubbing = touching(linear(), ["up_y0", "low_y1"]);
    rubbing.scene.contacts[0].friction = 0.2;
    for problem in [
        touching(of_rubber(), ["up_y0", "low_y1"]),
        rubbing,
        tied(linear()),
    ] {
        let fine = refined(&problem, "force.ball.y", 0.004).expect("a result");
        assert_reached(&problem, ("force.ball.y", 0.02), fine.hierarchy.mesh());
    }
}
