//! What has no answer is refused with its cause.

use crate::common::meshes::{irregular, mesh, square};
use crate::common::run;
use crate::common::scenes::{HELD, mooney_rivlin, obstacle, push, rubber, support};
use signorini::scene::{GoalQuestions, Shape};
use signorini::{CancelToken, GoalError, Scene, Session};

fn block(friction: f64) -> Session {
    let mut scene: Scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("y0", HELD)];
    scene.supports[0].displacement[2] = None;
    let shape = Shape::Sphere {
        centre: [0.45, 1.5, 0.0],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "y1", shape)];
    scene.obstacles[0].friction = friction;
    let step = push("ball", [0.0, -0.05, 0.0]);
    run(&scene, &[step], &mesh(irregular(square(4), 4))).0
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
fn bodies_with_friction_depend_on_their_way() {
    let error = refused(&block(0.3), "force.ball.y", &[]);
    assert_eq!(error, GoalError::NeedsHistory("friction"));
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
