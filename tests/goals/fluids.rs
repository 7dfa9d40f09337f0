//! Goals beside fluids: near a state the same nodes are wet, so that derivatives agree with differences
//! of whole solves, the fluid's own pressure among the parameters.

use crate::bodies::{of_rubber, touching};
use crate::common::assert_converged;
use crate::common::meshes::{mesh, square};
use crate::common::scenes::{obstacle, plane, push};
use crate::gradients::{Change, Problem, assert_differences, linear, pressed, set_c10, set_height};
use signorini::report::{StepReport, Tightness};
use signorini::scene::{Fluid, GoalErrors, GoalQuestions, MaterialModel, Modulus};

/// A block under a ball and a bar whose left side and lid water wets up to the ball.
pub(crate) fn wet(mut problem: Problem) -> Problem {
    problem.scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["x0".to_owned(), "y1".to_owned()],
        from: vec!["x0".to_owned()],
        dry: vec!["x1".to_owned()],
        pressure: 0.04,
        ..Fluid::default()
    }];
    problem
}

fn last(problem: &Problem) -> StepReport {
    let (_, reports) = crate::common::run(&problem.scene, &problem.steps, &problem.mesh);
    reports.iter().for_each(assert_converged);
    reports.into_iter().last().expect("a report")
}

fn set_water(problem: &mut Problem, by: f64) {
    problem.scene.fluids[0].pressure += by;
}

fn set_shear(problem: &mut Problem, by: f64) {
    if let MaterialModel::LinearElastic {
        modulus: Modulus::Shear(shear),
        ..
    } = &mut problem.scene.materials[0].model
    {
        *shear += by;
    }
}

const GOALS: [&str; 5] = [
    "force.ball.x",
    "force.ball.y",
    "reaction.base.x",
    "reaction.base.y",
    "strain_energy",
];

fn assert_wet_differences(problem: Problem, law: Change<'_>) {
    let problem = wet(problem);
    let water = &last(&problem).fluids["water"];
    assert_eq!(water.tightness, Tightness::Tight);
    assert!(water.wet_area > 1.1, "{}", water.wet_area);
    let changes: [Change<'_>; 3] = [
        law,
        ("fluid.water.pressure", 1e-6, &set_water),
        ("obstacle.ball.translation.y", 1e-6, &set_height(2)),
    ];
    assert_differences(&problem, &GOALS, &changes);
}

#[test]
fn a_wet_block_of_rubber_agrees_with_differences_of_whole_solves() {
    assert_wet_differences(
        pressed(2, Some(40.0)),
        ("material.body.c10", 1e-5, &set_c10),
    );
}

#[test]
fn a_wet_linear_block_agrees_with_differences_of_whole_solves() {
    assert_wet_differences(
        linear(2, 0.3),
        ("material.body.shear_modulus", 1e-5, &set_shear),
    );
}

#[test]
fn goals_beside_fluids_are_the_numbers_of_the_report_with_a_bound() {
    let mut problem = wet(pressed(2, Some(40.0)));
    problem.scene.questions = vec![GoalQuestions {
        goals: vec!["force.ball.y".parse().expect("a goal")],
        parameters: Vec::new(),
        errors: GoalErrors::Bounded,
        ..GoalQuestions::default()
    }];
    let report = last(&problem);
    let goal = &report.goals[0];
    let force = report.obstacles["ball"].force[1];
    assert!((goal.value - force).abs() < 1e-12 * force.abs());
    let bound = goal.bound.as_ref().expect("a bound").total();
    assert!(
        bound > 1e-4 * force.abs() && bound < 0.5 * force.abs(),
        "{bound}"
    );
}

/// A plate covers the lid of a block that water wets from one side up to the edge of the lid: the function
/// of that edge presses under the plate, too.
#[test]
fn where_a_front_ends_is_in_the_bound() {
    let solved = |count: usize| {
        let mut problem = wet(linear(2, 0.3));
        problem.mesh = mesh(square(count));
        problem.scene.tractions.clear();
        problem.scene.obstacles = vec![obstacle(
            "ball",
            "y1",
            plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]),
        )];
        problem.steps = vec![push("ball", [0.0, -0.05, 0.0])];
        problem.scene.questions = vec![GoalQuestions {
            goals: vec!["force.ball.y".parse().expect("a goal")],
            parameters: Vec::new(),
            errors: GoalErrors::Bounded,
            ..GoalQuestions::default()
        }];
        let goal = last(&problem).goals.remove(0);
        (goal.value, goal.bound.expect("a bound").total())
    };
    let (exact, _) = solved(32);
    for count in [4, 8] {
        let (value, bound) = solved(count);
        let error = (value - exact).abs();
        assert!(
            error <= bound && bound < 10.0 * error,
            "{count}: {error:e} {bound:e}"
        );
    }
}

/// What is wet of the other surface goes along with what it slides over.
#[test]
fn derivatives_beside_fluids_between_bodies_are_refused() {
    let mut problem = touching(of_rubber(), ["up_y0", "low_y1"]);
    problem.scene.fluids = vec![Fluid {
        name: "water".to_owned(),
        on: vec!["up_y0".to_owned(), "low_y1".to_owned(), "low_x1".to_owned()],
        from: vec!["low_x1".to_owned()],
        dry: vec!["up_x0".to_owned()],
        pressure: 1e-3,
        ..Fluid::default()
    }];
    problem.scene.questions = vec![GoalQuestions {
        goals: vec!["force.ball.y".parse().expect("a goal")],
        parameters: vec![
            "material.up_body.shear_modulus"
                .parse()
                .expect("a parameter"),
        ],
        ..GoalQuestions::default()
    }];
    let report = last(&problem);
    assert!(report.goals[0].derivatives.is_empty());
    let refused = report.goals_refused.expect("a cause");
    assert!(
        refused.contains("fluids that come between bodies"),
        "{refused}"
    );
}
