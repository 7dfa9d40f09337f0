//! What a scene asks of its increments comes with their reports, and changes none of their bits.

use std::sync::Arc;

use crate::common::meshes::{irregular, mesh, square};
use crate::common::scenes::{HELD, mooney_rivlin, obstacle, push, rubber, support};
use crate::common::{assert_converged, close, run};
use signorini::report::{GoalReport, StepReport, Warning, WarningKind};
use signorini::scene::{AskedAt, GoalErrors, GoalQuestions, Shape};
use signorini::{
    CancelToken, FieldName, Plan, PlanEntry, Prepared, Reuse, Scene, SceneError, Session, Step,
};

/// A block in plane strain under a ball.
fn block(questions: Vec<GoalQuestions>) -> (Scene, Step) {
    let mut scene: Scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("y0", HELD)];
    scene.supports[0].displacement[2] = None;
    let shape = Shape::Sphere {
        centre: [0.45, 1.5, 0.0],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("ball", "y1", shape)];
    scene.questions = questions;
    let mut step = push("ball", [0.0, -0.05, 0.0]);
    step.increments = 2;
    (scene, step)
}

fn gradient(goals: &[&str], parameters: &[&str]) -> GoalQuestions {
    GoalQuestions {
        goals: goals
            .iter()
            .map(|text| text.parse().expect("a goal"))
            .collect(),
        parameters: parameters
            .iter()
            .map(|text| text.parse().expect("a parameter"))
            .collect(),
        errors: GoalErrors::Left,
        at: AskedAt::Increments,
    }
}

fn bound(goals: &[&str]) -> GoalQuestions {
    GoalQuestions {
        errors: GoalErrors::Bounded,
        ..gradient(goals, &[])
    }
}

fn named<'r>(report: &'r StepReport, goal: &str) -> &'r GoalReport {
    let mut all = report.goals.iter();
    all.find(|one| one.goal == goal).expect("the goal")
}

#[test]
fn a_goal_that_several_questions_name_is_answered_once_with_all_that_is_asked_of_it() {
    let (scene, step) = block(vec![
        gradient(&["force.ball.y"], &["material.body.c10"]),
        gradient(
            &["force.ball.x", "force.ball.y"],
            &["obstacle.ball.radius", "material.body.c10"],
        ),
        bound(&["force.ball.y"]),
    ]);
    let (_, reports) = run(&scene, &[step], &mesh(irregular(square(4), 4)));
    for report in &reports {
        assert_converged(report);
        assert_eq!((report.goals.len(), &report.goals_refused), (2, &None));
        let (both, one) = (named(report, "force.ball.y"), named(report, "force.ball.x"));
        assert_eq!((both.derivatives.len(), one.derivatives.len()), (2, 2));
        assert_eq!(both.derivatives[0].0, "material.body.c10");
        assert!(both.bound.is_some() && one.bound.is_none());
        assert!(close(both.value, report.obstacles["ball"].force[1], 1e-12));
    }
}

/// What is asked of the ends of steps is told there alone, and as it is told of all increments: dual
/// solutions begin elsewhere, and end within what derivatives and bounds are found to.
#[test]
fn ends_of_steps_are_asked_where_no_more_is_said() {
    let mesh = mesh(irregular(square(4), 4));
    let asked = |at: AskedAt| {
        let all = [
            gradient(&["force.ball.y"], &["material.body.c10"]),
            bound(&["force.ball.y"]),
        ];
        let (scene, step) = block(all.map(|one| GoalQuestions { at, ..one }).to_vec());
        run(&scene, &[step.clone(), step], &mesh).1
    };
    let [ends, all] = [AskedAt::default(), AskedAt::Increments].map(asked);
    let answered: Vec<usize> = ends.iter().map(|report| report.goals.len()).collect();
    assert_eq!(answered, [0, 1, 0, 1]);
    assert!(all.iter().all(|report| report.goals.len() == 1));
    assert!(ends.iter().all(|report| report.goals_refused.is_none()));
    for (end, other) in ends
        .iter()
        .zip(&all)
        .filter(|(end, _)| !end.goals.is_empty())
    {
        let [own, other] = [end, other].map(|report| named(report, "force.ball.y"));
        assert_eq!(own.value.to_bits(), other.value.to_bits());
        assert!(close(own.derivatives[0].1, other.derivatives[0].1, 1e-6));
        let [own, other] = [own, other].map(|one| one.bound.as_ref().expect("a bound").total());
        assert!(close(own, other, 1e-3));
    }
}

#[test]
fn the_density_of_the_error_adds_up_to_its_bound_and_no_result_changes() {
    let mesh = mesh(irregular(square(4), 4));
    let (scene, step) = block(vec![bound(&["force.ball.y", "force.ball.x"])]);
    let (session, reports) = run(&scene, std::slice::from_ref(&step), &mesh);
    let last = reports.last().expect("a report");
    let field = session.field(FieldName::ErrorDensity).expect("a density");
    let area = |cell: usize| {
        let [a, b, c, _] = mesh.corners(cell);
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
    };
    let whole: f64 = (0..mesh.cell_count())
        .map(|cell| field.values[cell] * area(cell))
        .sum();
    let bound = named(last, "force.ball.y").bound.as_ref().expect("a bound");
    assert!(close(whole, bound.discretisation, 1e-12));
    let (plain, _) = block(Vec::new());
    let (unasked, others) = run(&plain, &[step], &mesh);
    assert!(unasked.field(FieldName::ErrorDensity).is_none());
    let other = others.last().expect("a report");
    assert_eq!(other.obstacles, last.obstacles);
    assert_eq!(
        (other.sqp_iterations, other.strain_energy.to_bits()),
        (last.sqp_iterations, last.strain_energy.to_bits())
    );
}

#[test]
fn a_session_that_goes_on_elsewhere_has_the_density_anew() {
    let mesh = mesh(irregular(square(4), 4));
    let (scene, step) = block(vec![bound(&["force.ball.y"])]);
    let (mut session, _) = run(&scene, &[step], &mesh);
    let plan = Arc::new(Plan::new(&scene, &[], &mesh).expect("a plan"));
    let prepared = Prepared::build(&plan, &mesh, &CancelToken::new()).expect("prepared");
    let bytes = session.export();
    let again = Session::import(plan, mesh, Arc::new(prepared), Reuse::Reused, &bytes);
    let again = again.expect("a session");
    let [first, second] =
        [&session, &again].map(|one| one.field(FieldName::ErrorDensity).expect("a density"));
    // Dual solutions of bounds are found to 1e-4, here from different beginnings.
    for (a, b) in first.values.iter().zip(&second.values) {
        assert!(close(*a, *b, 1e-3), "{a} {b}");
    }
}

#[test]
fn a_contact_about_to_close_makes_derivatives_one_sided() {
    // The ball touches the surface at a vertex, and does not press.
    let (mut scene, mut step) = block(vec![gradient(&["force.ball.y"], &["material.body.c10"])]);
    scene.obstacles[0].shape = Shape::HalfSpace {
        point: [0.0, 1.0, 0.0],
        normal: [0.0, -1.0, 0.0],
    };
    step.obstacles.clear();
    let (_, reports) = run(&scene, &[step], &mesh(square(4)));
    let warnings = &reports.last().expect("a report").warnings;
    let one_sided = |warning: &&Warning| warning.kind == WarningKind::OneSided;
    let found = warnings.iter().find(one_sided).expect("a warning");
    assert!(found.value.expect("a count") > 0.0, "{found:?}");
}

#[test]
fn names_that_a_scene_lacks_are_told_by_their_keys() {
    let questions = vec![
        bound(&["reaction.top.y"]),
        gradient(&["force.lid.y"], &["load"]),
        gradient(
            &["force.ball.y"],
            &[
                "material.body.c30",
                "material.core.c10",
                "obstacle.ball.tube_radius",
                "pressure.0",
                "traction.wind.x",
                "support.y1.x",
            ],
        ),
    ];
    let (scene, step) = block(questions);
    let faults = match Plan::new(&scene, &[step], &mesh(square(4))) {
        Err(SceneError::Invalid(faults)) => faults,
        other => panic!("{other:?}"),
    };
    let told: Vec<String> = faults
        .iter()
        .map(|one| format!("{}: {}", one.path, one.message))
        .collect();
    let expected = [
        "accuracy.bound: `reaction.top.y`: the scene has no support of that name",
        "gradient[0].of: `force.lid.y`: the scene has no obstacle or contact between bodies of that name",
        "gradient[1].to: `material.body.c30`: the law has no such finite constant",
        "gradient[1].to: `material.core.c10`: the scene has no material of that group",
        "gradient[1].to: `obstacle.ball.tube_radius`: the shape has no such number",
        "gradient[1].to: `pressure.0`: the scene has no such pressure; they are counted from 0",
        "gradient[1].to: `traction.wind.x`: the scene has no traction of that name or place",
        "gradient[1].to: `support.y1.x`: the scene has no support of that name",
    ];
    assert_eq!(told, expected);
}

#[test]
fn a_plan_says_what_questions_cost() {
    let (scene, step) = block(vec![
        gradient(&["force.ball.y"], &["load", "material.body.c10"]),
        bound(&["force.ball.y", "force.ball.x"]),
    ]);
    let mesh = mesh(square(4));
    let plan = Plan::new(&scene, std::slice::from_ref(&step), &mesh).expect("a plan");
    let report = plan.report();
    let entry = |entry: &&PlanEntry| entry.what == "goals";
    let told = report.decisions.iter().find(entry).expect("its cost");
    assert!(
        told.choice.starts_with("2 goals by 2 parameters, "),
        "{told:?}"
    );
    let predicted: u32 = told.choice["2 goals by 2 parameters, ".len()..]
        .split(' ')
        .next()
        .and_then(|count| count.parse().ok())
        .expect("a count");
    let (_, reports) = run(&scene, &[step], &mesh);
    let goals = &reports.last().expect("a report").goals;
    let taken: u32 = goals.iter().map(|goal| goal.applications).sum();
    assert!(
        taken <= 4 * predicted && predicted <= 8 * taken,
        "{taken} {predicted}"
    );
    let (plain, step) = block(Vec::new());
    let plan = Plan::new(&plain, &[step], &mesh).expect("a plan");
    assert!(
        plan.report()
            .decisions
            .iter()
            .all(|one| one.what != "goals")
    );
}

/// A parameter without a derivative, and a goal without a dual problem, keep no other from theirs.
#[test]
fn what_has_no_answer_keeps_nothing_else_from_having_one() {
    let (scene, step) = block(vec![gradient(
        &["force.ball.y", "reaction.y0.y"],
        &[
            "material.body.c10",
            "obstacle.ball.friction",
            "obstacle.ball.force.y",
            "obstacle.ball.radius",
        ],
    )]);
    let (_, reports) = run(&scene, &[step], &mesh(irregular(square(4), 4)));
    let last = reports.last().expect("a report");
    let cause = last.goals_refused.as_ref().expect("causes");
    for parameter in ["obstacle.ball.friction", "obstacle.ball.force.y"] {
        assert!(cause.contains(&format!("`{parameter}`: ")), "{cause}");
    }
    assert!(cause.contains("`translation` and `rotation`"), "{cause}");
    let force = named(last, "force.ball.y");
    let told: Vec<&str> = force.derivatives.iter().map(|one| &*one.0).collect();
    assert_eq!(told, ["material.body.c10", "obstacle.ball.radius"]);
    assert!(force.derivatives.iter().all(|one| one.1 != 0.0));
    // What presses from above is held from below; each is known to 1e-6.
    let base = named(last, "reaction.y0.y");
    for (own, other) in force.derivatives.iter().zip(&base.derivatives) {
        assert!(close(own.1, -other.1, 2e-6), "{own:?} {other:?}");
    }
}
