//! Goals where bodies press on each other or are tied: what one body feels is what it hands on, and
//! derivatives agree with differences of whole solves.

use crate::common::meshes::{joined, mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, elastic, obstacle, push, rubber, support};
use crate::common::{close, run};
use crate::gradients::{Change, Problem, assert_differences, set_height, set_radius};
use signorini::Scene;
use signorini::scene::{
    ContactPair, GoalErrors, GoalQuestions, Material, MaterialModel, Modulus, RubberModel, Shape,
    Tie,
};

/// A block on another one whose top is a little curved, under a ball.
fn stacked(scene: Scene) -> Problem {
    let top = |x: f64| 0.8 - 0.1 * (x - 0.45) * (x - 0.45);
    let low = moved(unit_grid(5, 4), move |[x, y, z]| [x, y * top(x), z]);
    let up = moved(unit_grid(7, 4), move |[x, y, z]| {
        [x, top(x) + y * (1.5 - top(x)), z]
    });
    let mut scene = Scene {
        supports: vec![
            support("low_y0", HELD_IN_PLANE),
            support("up_x0", [Some(0.0), None, None]),
        ],
        obstacles: vec![obstacle(
            "ball",
            "up_y1",
            Shape::Sphere {
                centre: [0.42, 2.1, 0.0],
                radius: 0.6,
            },
        )],
        ..scene
    };
    scene.supports[0].name = "base".to_owned();
    scene.solver.tolerance = 1e-12;
    Problem {
        scene,
        steps: vec![push("ball", [0.0, -0.12, 0.0])],
        mesh: mesh(joined(&[("low_", low), ("up_", up)])),
    }
}

pub(crate) fn touching(scene: Scene, carrier: [&str; 2]) -> Problem {
    stacked(Scene {
        contacts: vec![ContactPair {
            name: "joint".to_owned(),
            between: carrier.map(str::to_owned),
            carries: Some(carrier[0].to_owned()),
            ..ContactPair::default()
        }],
        ..scene
    })
}

pub(crate) fn tied(scene: Scene) -> Problem {
    stacked(Scene {
        ties: vec![Tie {
            name: "joint".to_owned(),
            between: ["up_y0", "low_y1"].map(str::to_owned),
            ..Tie::default()
        }],
        ..scene
    })
}

/// Both bodies of the law of a scene, the upper one stiffer.
fn both(mut scene: Scene) -> Scene {
    let own = scene.materials.remove(0);
    scene.materials = ["low_body", "up_body"]
        .map(|group| Material {
            group: group.to_owned(),
            ..own.clone()
        })
        .into();
    add_to_modulus(&mut scene, 1, 0.3);
    scene
}

pub(crate) fn of_rubber() -> Scene {
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    both(rubber(law, Some(40.0)))
}

pub(crate) fn linear() -> Scene {
    both(elastic(0.5))
}

/// Changes the modulus of the body of that number.
fn set_modulus(body: usize) -> impl Fn(&mut Problem, f64) {
    move |problem: &mut Problem, by: f64| add_to_modulus(&mut problem.scene, body, by)
}

fn add_to_modulus(scene: &mut Scene, body: usize, by: f64) {
    if let MaterialModel::Rubber {
        model: RubberModel::NeoHookean { shear_modulus },
        ..
    }
    | MaterialModel::LinearElastic {
        modulus: Modulus::Shear(shear_modulus),
        ..
    } = &mut scene.materials[body].model
    {
        *shear_modulus += by;
    }
}

fn assert_derivatives(problem: &Problem, goals: &[&str]) {
    let changes: [Change<'_>; 4] = [
        ("material.low_body.shear_modulus", 1e-5, &set_modulus(0)),
        ("material.up_body.shear_modulus", 1e-5, &set_modulus(1)),
        ("obstacle.ball.radius", 1e-5, &set_radius),
        ("obstacle.ball.translation.y", 1e-5, &set_height(2)),
    ];
    assert_differences(problem, goals, &changes);
}

/// Nothing else acts on the upper block along y: its contact hands on what the ball exerts, and so do
/// the derivatives.
fn assert_handed_on(problem: &Problem, sign: f64) {
    let parameters = [
        "material.low_body.shear_modulus",
        "obstacle.ball.translation.y",
        "support.base.y",
    ];
    let found = problem.ask(
        &["force.ball.y", "force.joint.y", "reaction.base.y"],
        &parameters,
    );
    let [ball, joint, base] = &found[..] else {
        panic!("three goals");
    };
    assert!(ball.value < -0.01);
    assert!(close(joint.value, sign * ball.value, 1e-9));
    assert!(close(base.value, -ball.value, 1e-9));
    for place in 0..parameters.len() {
        let [of_ball, of_joint, of_base] =
            [ball, joint, base].map(|goal| goal.derivatives[place].1);
        assert!(
            close(of_joint, sign * of_ball, 1e-8),
            "{of_joint} {of_ball}"
        );
        assert!(close(of_base, -of_ball, 1e-8), "{of_base} {of_ball}");
    }
}

#[test]
fn a_contact_between_bodies_hands_on_what_a_ball_exerts() {
    for scene in [of_rubber(), linear()] {
        assert_handed_on(&touching(scene, ["up_y0", "low_y1"]), -1.0);
    }
    // The force is that on the body named first.
    assert_handed_on(&touching(of_rubber(), ["low_y1", "up_y0"]), 1.0);
}

#[test]
fn rubber_on_rubber_agrees_with_differences_of_whole_solves() {
    let problem = touching(of_rubber(), ["up_y0", "low_y1"]);
    assert_derivatives(
        &problem,
        &[
            "force.ball.y",
            "force.joint.x",
            "reaction.base.y",
            "strain_energy",
        ],
    );
}

#[test]
fn linear_bodies_agree_with_differences_of_whole_solves() {
    let problem = touching(linear(), ["up_y0", "low_y1"]);
    assert_derivatives(&problem, &["force.ball.y", "reaction.base.x"]);
}

#[test]
fn tied_bodies_agree_with_differences_of_whole_solves() {
    for scene in [of_rubber(), linear()] {
        assert_derivatives(
            &tied(scene),
            &["force.ball.y", "reaction.base.y", "reaction.base.x"],
        );
    }
}

/// The upper body is led sideways over the lower one.
fn dragged(scene: Scene, change: impl Fn(&mut ContactPair)) -> Problem {
    let mut problem = touching(scene, ["up_y0", "low_y1"]);
    change(&mut problem.scene.contacts[0]);
    problem.scene.supports[1].displacement[0] = Some(0.01);
    let (_, reports) = run(&problem.scene, &problem.steps, &problem.mesh);
    let joint = &reports[0].contacts["joint"];
    let friction = joint.friction.as_ref().expect("friction");
    assert!(friction.stick_vertices > 0 && friction.slip_vertices > 0);
    problem
}

fn set_coefficient(problem: &mut Problem, by: f64) {
    problem.scene.contacts[0].friction += by;
}

fn set_bound(problem: &mut Problem, by: f64) {
    if let Some(bound) = &mut problem.scene.contacts[0].tresca {
        *bound += by;
    }
}

const RUBBED: [&str; 5] = [
    "force.joint.x",
    "force.joint.y",
    "reaction.base.x",
    "force.ball.y",
    "strain_energy",
];

#[test]
fn bodies_that_rub_against_each_other_agree_with_differences_of_whole_solves() {
    for scene in [of_rubber(), linear()] {
        let problem = dragged(scene, |contact| contact.friction = 0.2);
        assert_derivatives(&problem, &RUBBED);
        let own: Change<'_> = ("contact.joint.friction", 1e-6, &set_coefficient);
        assert_differences(&problem, &RUBBED, &[own]);
    }
}

#[test]
fn bodies_that_rub_with_a_given_bound_agree_with_differences_of_whole_solves() {
    let problem = dragged(of_rubber(), |contact| contact.tresca = Some(0.05));
    assert_derivatives(&problem, &RUBBED);
    let own: Change<'_> = ("contact.joint.tresca", 1e-7, &set_bound);
    assert_differences(&problem, &RUBBED, &[own]);
}

/// As scene files ask: with the ends of steps.
#[test]
fn scenes_with_ties_may_ask_for_bounds_and_derivatives() {
    let mut problem = tied(linear());
    problem.scene.questions = vec![GoalQuestions {
        goals: vec!["reaction.base.y".parse().expect("a goal")],
        parameters: vec!["support.base.y".parse().expect("a parameter")],
        errors: GoalErrors::Bounded,
        ..GoalQuestions::default()
    }];
    let (_, reports) = run(&problem.scene, &problem.steps, &problem.mesh);
    let report = reports.last().expect("a report");
    let goal = report.goals.first().expect("a goal");
    assert!(
        goal.bound.is_some() && goal.derivatives.len() == 1,
        "{:?}",
        report.goals_refused
    );
}
