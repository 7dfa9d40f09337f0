//! What has no answer is refused with its cause.

use std::sync::Arc;

use crate::common::meshes::{irregular, mesh, square};
use crate::common::run;
use crate::common::scenes::{HELD, mooney_rivlin, obstacle, push, rubber, support};
use signorini::scene::{GoalQuestions, Shape};
use signorini::{CancelToken, GoalError, Mesh, Plan, Prepared, Reuse, Scene, Session};

fn scene(friction: f64) -> Scene {
    let mut scene: Scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("y0", HELD)];
    scene.supports[0].displacement[2] = None;
    let shape = Shape::Sphere {
        centre: [0.45, 1.5, 0.0],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "y1", shape)];
    scene.obstacles[0].friction = friction;
    scene
}

fn block(friction: f64) -> Session {
    let step = push("ball", [0.0, -0.05, 0.0]);
    run(&scene(friction), &[step], &mesh(irregular(square(4), 4))).0
}

fn parts(friction: f64) -> (Arc<Plan>, Arc<Mesh>, Arc<Prepared>) {
    let mesh = mesh(irregular(square(4), 4));
    let plan = Arc::new(Plan::new(&scene(friction), &[], &mesh).expect("a plan"));
    let prepared = Prepared::build(&plan, &mesh, &CancelToken::new()).expect("prepared");
    (plan, mesh, Arc::new(prepared))
}

fn refused(session: &Session, goal: &str, parameters: &[&str]) -> GoalError {
    let questions = GoalQuestions {
        goals: vec![goal.parse().expect("a goal")],
        parameters: parameters
            .iter()
            .map(|text| text.parse().expect("a parameter"))
            .collect(),
        ..GoalQuestions::default()
    };
    let answer = session.answer(&questions, &CancelToken::new());
    answer.expect_err("no answer")
}

#[test]
fn what_friction_counts_from_is_in_no_checkpoint() {
    let mut session = block(0.3);
    let bytes = session.export();
    let (plan, mesh, prepared) = parts(0.3);
    let again = Session::import(plan, mesh, prepared, Reuse::Reused, &bytes).expect("a session");
    let error = refused(&again, "force.ball.y", &[]);
    assert_eq!(error, GoalError::UnknownStart);
}

#[test]
fn names_that_the_scene_does_not_have_are_told() {
    let session = block(0.0);
    let texts = [
        refused(&session, "force.lid.y", &[]),
        refused(&session, "force.ball.z", &[]),
        refused(&session, "moment.ball.x", &[]),
        refused(&session, "force.ball.y", &["material.body.c30"]),
        refused(&session, "force.ball.y", &["material.body.bulk_modulus"]),
        refused(&session, "force.ball.y", &["obstacle.ball.tube_radius"]),
        refused(&session, "force.ball.y", &["obstacle.ball.force.y"]),
        refused(&session, "force.ball.y", &["pressure.0"]),
        refused(&session, "force.ball.y", &["support.y0.z"]),
    ]
    .map(|error| error.to_string());
    for text in texts {
        assert!(text.starts_with('`') && text.contains("`: "), "{text}");
    }
}

#[test]
fn a_goal_that_was_cancelled_says_so() {
    let cancel = CancelToken::new();
    cancel.cancel();
    let questions = GoalQuestions {
        goals: vec!["force.ball.y".parse().expect("a goal")],
        ..GoalQuestions::default()
    };
    let answer = block(0.0).answer(&questions, &cancel);
    assert!(matches!(answer, Err(GoalError::Stopped(_))), "{answer:?}");
}
