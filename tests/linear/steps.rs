//! Load steps: ramps, values that stay, moved obstacles and supports,
//! cancelling, unloading, and what a session does not repeat.

use std::sync::Arc;

use crate::common::meshes::{cube, file, irregular, mesh};
use crate::common::scenes::{
    HELD, cube_bend, elastic, hertz_plane, hertz_sphere, obstacle, push, small_indentation,
    support, traction,
};
use crate::common::{
    assert_converged, close, difference, open, run, run_one, solve, solve_one, take, values,
};
use signorini::scene::{ObstacleTarget, Shape, SupportTarget};
use signorini::{
    CancelToken, FieldName, IterationRecord, Mesh, Observer, Plan, Prepared, Reuse, Session,
    Silent, Step, StepReport, Termination,
};

fn block() -> Arc<Mesh> {
    mesh(irregular(cube(3), 3))
}

fn turn(name: &str, rotation: [f64; 3]) -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: name.to_owned(),
            rotation: Some(rotation),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

fn load(factor: f64) -> Step {
    Step {
        load: Some(factor),
        ..Step::default()
    }
}

fn displacement(session: &Session) -> Vec<f64> {
    values(session, FieldName::Displacement)
}

#[test]
fn increments_ramp_the_load() {
    let mut scene = cube_bend(0.5);
    scene.solver.tolerance = 1e-11;
    let step = Step {
        increments: 4,
        ..Step::default()
    };
    let reports = solve(&scene, &[step, load(2.0)], &block());
    assert_eq!(reports.len(), 5);
    let whole = reports[3].probes["corner"].displacement[2];
    for (index, report) in reports.iter().enumerate() {
        assert_converged(report);
        let part = [0.25, 0.5, 0.75, 1.0, 2.0][index];
        assert!((report.load - part).abs() < 1e-15);
        assert!((report.time - part).abs() < 1e-15);
        assert!(close(
            report.probes["corner"].displacement[2],
            part * whole,
            1e-9
        ));
        let place = [(1, 1), (1, 2), (1, 3), (1, 4), (2, 1)][index];
        assert_eq!((report.step, report.increment), place);
    }
}

#[test]
fn increments_ramp_an_obstacle() {
    let (scene, mesh) = small_indentation(3);
    let mut step = push("ball", [0.0, 0.0, -0.08]);
    step.increments = 4;
    let (session, reports) = run(&scene, std::slice::from_ref(&step), &mesh);
    let forces: Vec<f64> = reports
        .iter()
        .map(|r| -r.obstacles["ball"].force[2])
        .collect();
    assert!(
        forces.windows(2).all(|pair| pair[0] < pair[1]),
        "{forces:?}"
    );
    let pose = &session.obstacle_poses()[0];
    assert_eq!(
        (pose.name.as_str(), pose.translation),
        ("ball", [0.0, 0.0, -0.08])
    );
    let at_once = solve_one(&scene, &push("ball", [0.0, 0.0, -0.08]), &mesh);
    assert!(close(forces[3], -at_once.obstacles["ball"].force[2], 1e-6));
}

#[test]
fn what_a_step_does_not_name_keeps_its_value() {
    let (mut scene, mesh) = small_indentation(3);
    scene.tractions = vec![traction("x1", [0.01, 0.0, 0.0])];
    scene.solver.tolerance = 1e-10;
    let press = push("ball", [0.0, 0.0, -0.05]);
    let (session, reports) = run(&scene, &[press.clone(), load(3.0)], &mesh);
    assert!(close(reports[1].load, 3.0, 1e-15));
    assert!(difference(&session.obstacle_poses()[0].translation, &[0.0, 0.0, -0.05]) < 1e-15);
    let both = Step {
        load: Some(3.0),
        ..press
    };
    let (direct, _) = run_one(&scene, &both, &mesh);
    assert!(difference(&displacement(&session), &displacement(&direct)) < 1e-8);
}

#[test]
fn a_turned_plane_acts_like_a_tilted_one() {
    let angle = 0.1_f64;
    let floor = |normal| Shape::HalfSpace {
        point: [0.5, 0.5, 1.0],
        normal,
    };
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.solver.tolerance = 1e-10;
    scene.obstacles = vec![obstacle("lid", "z1", floor([0.0, 0.0, -1.0]))];
    let mesh = block();
    let mut step = turn("lid", [0.0, angle, 0.0]);
    step.increments = 2;
    let (turned, reports) = run(&scene, &[step], &mesh);
    assert!(reports[1].active_vertices > 0);
    scene.obstacles[0].shape = floor([-angle.sin(), 0.0, -angle.cos()]);
    let (tilted, _) = run_one(&scene, &Step::default(), &mesh);
    assert!(difference(&displacement(&turned), &displacement(&tilted)) < 1e-8);
}

#[test]
fn a_turned_cylinder_acts_like_one_along_another_axis() {
    let roll = |axis| Shape::Cylinder {
        point: [0.5, 0.5, 1.95],
        axis,
        radius: 1.0,
    };
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.solver.tolerance = 1e-10;
    scene.obstacles = vec![obstacle("roll", "z1", roll([1.0, 0.0, 0.0]))];
    let mesh = block();
    let (turned, _) = run_one(
        &scene,
        &turn("roll", [0.0, 0.0, 0.5 * std::f64::consts::PI]),
        &mesh,
    );
    scene.obstacles[0].shape = roll([0.0, 1.0, 0.0]);
    let (across, _) = run_one(&scene, &Step::default(), &mesh);
    assert!(difference(&displacement(&turned), &displacement(&across)) < 1e-8);
}

fn slide(value: f64) -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "x1".to_owned(),
            displacement: [None, None, Some(value)],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

#[test]
fn a_moved_support_ends_where_a_displaced_one_starts() {
    let mut scene = elastic(0.5);
    scene.solver.tolerance = 1e-10;
    scene.supports = vec![support("x0", HELD), support("x1", [None, None, Some(0.1)])];
    let mesh = block();
    let (moved, reports) = run(&scene, &[Step::default(), slide(-0.2)], &mesh);
    assert_converged(&reports[1]);
    scene.supports[1].displacement[2] = Some(-0.2);
    let (direct, report) = run_one(&scene, &Step::default(), &mesh);
    assert!(difference(&displacement(&moved), &displacement(&direct)) < 1e-8);
    let force = reports[1].supports["x1"].force[2];
    assert!(close(force, report.supports["x1"].force[2], 1e-7) && force < 0.0);
}

#[test]
fn a_translated_support_moves_like_a_displaced_one() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("x0", HELD), support("x1", [None, None, Some(0.0)])];
    let mesh = block();
    let translated = Step {
        supports: vec![SupportTarget {
            name: "x1".to_owned(),
            translation: Some([0.0, 0.0, -0.2]),
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let (moved, reports) = run(&scene, &[translated, Step::default()], &mesh);
    let (slid, same) = run(&scene, &[slide(-0.2), Step::default()], &mesh);
    assert_converged(&reports[1]);
    assert_eq!(displacement(&moved), displacement(&slid));
    for (name, own) in &reports[1].supports {
        let other = same[1].supports[name];
        assert_eq!(own.force.map(f64::to_bits), other.force.map(f64::to_bits));
    }
    let arm = reports[1].supports["x1"].reference_point;
    assert!(difference(&arm, &[0.0, 0.0, -0.2]) < 1e-15, "{arm:?}");
}

/// Cancels its own solve after some iterations.
struct Impatient {
    token: CancelToken,
    left: u32,
}

impl Observer for Impatient {
    fn iteration(&mut self, _record: &IterationRecord) {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.token.cancel();
        }
    }
}

fn interrupted(session: &mut Session, step: &Step, iterations: u32) -> Vec<StepReport> {
    let token = CancelToken::new();
    let mut observer = Impatient {
        token: token.clone(),
        left: iterations,
    };
    let mut run = session.begin_step(step).expect("a valid step");
    std::iter::from_fn(|| session.advance(&mut run, &mut observer, &token)).collect()
}

#[test]
fn cancelling_returns_the_last_good_state_and_the_session_goes_on() {
    let (mut scene, mesh) = small_indentation(3);
    scene.solver.tolerance = 1e-10;
    let mut session = open(&scene, &mesh);
    take(&mut session, &push("ball", [0.0, 0.0, -0.03]));
    let before = displacement(&session);
    let deeper = push("ball", [0.0, 0.0, -0.06]);
    let reports = interrupted(&mut session, &deeper, 5);
    assert_eq!(reports.len(), 1);
    assert_eq!(reports[0].termination, Termination::Cancelled);
    assert_eq!(reports[0].krylov_iterations, 5);
    assert_eq!(displacement(&session), before);
    assert!(difference(&session.obstacle_poses()[0].translation, &[0.0, 0.0, -0.03]) < 1e-15);
    // What a step leaves out keeps the value that was reached.
    let still = take(&mut session, &Step::default());
    assert_converged(&still[0]);
    assert!(difference(&displacement(&session), &before) < 1e-8);
    let again = take(&mut session, &deeper);
    assert_converged(&again[0]);
    let (direct, _) = run_one(&scene, &deeper, &mesh);
    assert!(difference(&displacement(&session), &displacement(&direct)) < 1e-8);
}

#[test]
fn a_cancelled_token_stops_before_the_first_iteration() {
    let mut session = open(&cube_bend(0.5), &block());
    let token = CancelToken::new();
    token.expire();
    let mut run = session.begin_step(&Step::default()).expect("a valid step");
    let report = session
        .advance(&mut run, &mut Silent, &token)
        .expect("a report");
    assert_eq!(report.termination, Termination::DeadlineExceeded);
    assert_eq!(report.krylov_iterations, 0);
    assert!(session.advance(&mut run, &mut Silent, &token).is_none());
}

#[test]
fn a_rejected_step_leaves_the_session_as_it_was() {
    let mut session = open(&cube_bend(0.5), &block());
    take(&mut session, &load(1.0));
    let before = displacement(&session);
    assert!(session.begin_step(&push("ball", [0.0; 3])).is_err());
    assert!(session.check_step(&push("ball", [0.0; 3])).is_err());
    assert_eq!(displacement(&session), before);
    let next = take(&mut session, &Step::default());
    assert_eq!((next[0].step, next[0].krylov_iterations), (2, 0));
}

#[test]
fn unloading_returns_to_the_undeformed_state() {
    for poisson_ratio in [0.5, 0.3] {
        let mut scene = cube_bend(poisson_ratio);
        scene.solver.tolerance = 1e-12;
        let (session, reports) = run(&scene, &[load(1.0), load(0.0)], &block());
        assert_converged(&reports[1]);
        assert!(displacement(&session).iter().all(|u| u.abs() < 1e-10));
    }
}

#[test]
fn withdrawing_the_obstacle_returns_to_the_undeformed_state() {
    let (mut scene, mesh) = small_indentation(3);
    scene.solver.tolerance = 1e-12;
    let steps = [
        push("ball", [0.0, 0.0, -0.05]),
        push("ball", [0.0, 0.0, 0.5]),
    ];
    let (session, reports) = run(&scene, &steps, &mesh);
    assert!(reports[0].active_vertices > 0);
    assert_converged(&reports[1]);
    assert_eq!(reports[1].active_vertices, 0);
    assert!(displacement(&session).iter().all(|u| u.abs() < 1e-10));
    assert!(
        values(&session, FieldName::ContactPressure)
            .iter()
            .all(|&p| p.abs() < 1e-10)
    );
}

#[test]
fn a_step_that_changes_nothing_takes_no_iterations() {
    let (indentation, small) = small_indentation(3);
    let mut driven = elastic(0.5);
    driven.supports = vec![support("x0", HELD), support("x1", [None, None, Some(0.1)])];
    let pressed = push("ball", [0.0, 0.0, -0.05]);
    let cases = [
        (cube_bend(0.5), Step::default(), block()),
        (cube_bend(0.3), Step::default(), block()),
        (indentation, pressed, small),
        (driven, Step::default(), block()),
    ];
    for (scene, step, mesh) in cases {
        let (session, reports) = run(&scene, &[step, Step::default()], &mesh);
        assert_converged(&reports[1]);
        assert_eq!(reports[1].krylov_iterations, 0);
        assert!(session.bytes() > 0);
    }
}

#[test]
fn twenty_obstacle_updates_factorise_the_body_once_and_its_response_once() {
    let (scene, _) = hertz_sphere(0.5);
    let mut session = open(&scene, &file("indent_l1"));
    let mut factorisations = Vec::new();
    for update in 1..=20 {
        let depth = 0.05 * f64::from(update) / 20.0;
        for report in take(&mut session, &push("ball", [0.0, 0.0, -depth])) {
            assert_converged(&report);
            factorisations.push(report.factorisations);
        }
    }
    assert_eq!(factorisations[0], 1);
    factorisations.retain(|&count| count > 0);
    assert_eq!(factorisations, [1, 1]);
}

#[test]
fn a_session_on_kept_data_names_what_it_reuses_and_gives_the_same_bits() {
    let (scene, step) = hertz_plane(0.5);
    let mesh = file("hemi_l1");
    let plan = Arc::new(Plan::new(&scene, &[], &mesh).expect("a valid scene"));
    let prepared = Prepared::build(&plan, &mesh, &CancelToken::new()).expect("a solvable scene");
    let prepared = Arc::new(prepared);
    let mut results = [Reuse::Built, Reuse::Reused].map(|reuse| {
        let mut session = Session::new(plan.clone(), mesh.clone(), prepared.clone(), reuse);
        let report = take(&mut session, &step).remove(0);
        (report, displacement(&session))
    });
    let [(first, field), (second, same_field)] = &mut results;
    assert!(first.reused.is_empty() && first.factorisations == 1);
    assert!(second.factorisations == 0 && second.seconds.factorise.to_bits() == 0);
    for part in ["p1_factor", "contact_compliance", "pressure_metric"] {
        assert!(second.reused.iter().any(|name| name == part), "{part}");
    }
    assert_eq!(field, same_field);
}

#[test]
fn a_cancelled_token_stops_the_preparation() {
    let mesh = block();
    let plan = Plan::new(&cube_bend(0.5), &[], &mesh).expect("a valid scene");
    let token = CancelToken::new();
    token.cancel();
    let stopped = Prepared::build(&plan, &mesh, &token).expect_err("the token is cancelled");
    assert_eq!(
        stopped,
        signorini::PrepareError::Stopped(Termination::Cancelled)
    );
}
