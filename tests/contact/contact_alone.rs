//! Reports on contact alone say of contact what those on the whole body say, and leave nothing
//! behind that is not found when it is asked for.

use std::sync::Arc;

use crate::common::meshes::{file, mesh, unit_box};
use crate::common::refusals::unsupported;
use crate::common::scenes::{
    HELD, elastic, hertz_sphere, in_parts, obstacle, plane, push, support, traction, travel,
};
use crate::common::{assert_converged, close, open, run, take, values};
use signorini::scene::{Choice, ReportScope, ResponseMethod, SupportTarget};
use signorini::{
    CancelToken, FieldName, Mesh, Plan, Prepared, Reuse, Scene, Session, Step, StepReport,
};

/// The same scene with reports of that scope, answered by the response.
fn about(scope: ReportScope, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.solver.response = Choice::Named(ResponseMethod::Condensed);
    scene.solver.report = Choice::Named(scope);
    scene.solver.verify = scope == ReportScope::Whole;
    scene
}

/// A ball on a block, to a tolerance that leaves something.
fn ball(ratio: f64) -> Scene {
    let (mut scene, _) = hertz_sphere(ratio);
    scene.solver.tolerance = 1e-6;
    scene
}

fn moves() -> Vec<Step> {
    [
        [0.0, 0.0, -0.05],
        [0.02, 0.0, -0.052],
        [0.02, 0.05, -0.03],
        [0.0, 0.0, 0.1],
        [0.0, 0.0, -0.02],
    ]
    .map(|translation| push("ball", translation))
    .to_vec()
}

/// Asserts that obstacles of both reports are alike to 1e-10 of their forces.
fn assert_alike(whole: &StepReport, alone: &StepReport) {
    assert_converged(alone);
    assert!(alone.residuals.largest() <= alone.tolerance);
    for (name, one) in &whole.obstacles {
        let other = &alone.obstacles[name];
        let largest = one.force.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
        let pairs = [
            (one.force, other.force),
            (one.moment, other.moment),
            (one.centre_of_pressure, other.centre_of_pressure),
        ];
        for (a, b) in pairs.iter().flat_map(|(a, b)| a.iter().zip(b)) {
            assert!((a - b).abs() <= 1e-10 * largest.max(1.0), "{name}: {a} {b}");
        }
        let scalars = [
            (one.contact_area, other.contact_area),
            (one.max_pressure, other.max_pressure),
            (one.peak_pressure, other.peak_pressure),
        ];
        for (a, b) in scalars {
            assert!((a - b).abs() <= 1e-10, "{name}: {a} {b}");
        }
        // Powers of gaps near zero enlarge their rounding.
        let (a, b) = (one.deformed_contact_area, other.deformed_contact_area);
        assert!((a - b).abs() <= 1e-6 * a, "{name}: {a} {b}");
    }
}

/// Both reports of those steps, and the fields at their end.
fn assert_same_contact(scene: &Scene, steps: &[Step], body: &Arc<Mesh>) {
    let [(whole, all), (alone, few)] = [ReportScope::Whole, ReportScope::Contact]
        .map(|scope| run(&about(scope, scene), steps, body));
    assert_eq!(all.len(), few.len());
    for (one, other) in all.iter().zip(&few) {
        assert_alike(one, other);
        assert!(one.left_out.is_empty() && one.strain_energy.is_finite());
        assert!(other.left_out.contains(&"strain_energy") && other.strain_energy.is_nan());
    }
    for field in [FieldName::Displacement, FieldName::ContactPressure] {
        let [one, other] = [&whole, &alone].map(|session| values(session, field));
        let largest = one.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in one.iter().zip(&other) {
            assert!((a - b).abs() <= 1e-10 * largest, "{field:?}: {a} {b}");
        }
    }
}

#[test]
fn forces_are_those_of_a_report_on_the_whole_body() {
    for ratio in [0.5, 0.3] {
        assert_same_contact(&ball(ratio), &moves(), &file("indent_l1"));
    }
}

#[test]
fn loads_and_supports_may_change_between_steps() {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.tractions = vec![traction("x1", [0.05, 0.0, -0.02])];
    scene.obstacles = vec![obstacle(
        "lid",
        "z1",
        plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
    )];
    scene.solver.tolerance = 1e-6;
    let mut shifted = push("lid", [0.0, 0.0, -0.04]);
    shifted.supports = vec![SupportTarget {
        name: scene.supports[0].name.clone(),
        displacement: [Some(0.0), Some(0.01), Some(0.0)],
        ..SupportTarget::default()
    }];
    let mut unloaded = push("lid", [0.0, 0.0, -0.02]);
    unloaded.load = Some(0.25);
    let steps = [
        in_parts(push("lid", [0.0, 0.0, -0.03]), 2),
        shifted,
        unloaded,
    ];
    assert_same_contact(&scene, &steps, &mesh(unit_box([4, 4, 4])));
}

#[test]
fn whoever_asks_for_fields_on_the_way_changes_no_bit() {
    let scene = about(ReportScope::Contact, &ball(0.5));
    let body = file("indent_l1");
    let [mut silent, mut asked, mut completed] = [(); 3].map(|()| open(&scene, &body));
    for step in moves() {
        let report = take(&mut silent, &step);
        take(&mut asked, &step);
        values(&asked, FieldName::Displacement);
        let other = take(&mut completed, &step);
        completed.complete();
        for (name, one) in &report[0].obstacles {
            assert_eq!(one, &other[0].obstacles[name]);
        }
    }
    let field = FieldName::Displacement;
    let expected = values(&silent, field);
    assert_eq!(expected, values(&asked, field));
    assert_eq!(expected, values(&completed, field));
    silent.complete();
    assert_eq!(expected, values(&silent, field));
}

#[test]
fn a_checkpoint_holds_the_whole_body_and_goes_on_with_the_same_bits() {
    let scene = about(ReportScope::Contact, &ball(0.5));
    let body = file("indent_l1");
    let mut here = open(&scene, &body);
    for step in &moves()[..3] {
        take(&mut here, step);
    }
    let before = values(&here, FieldName::Pressure);
    let bytes = here.export();
    let mut there = open(&scene, &body);
    there.restore(&bytes).expect("of this scene");
    assert_eq!(before, values(&there, FieldName::Pressure));
    for session in [&mut here, &mut there] {
        take(session, &push("ball", [0.05, 0.0, -0.05]));
    }
    for field in [FieldName::Displacement, FieldName::ContactPressure] {
        assert_eq!(values(&here, field), values(&there, field));
    }
}

#[test]
fn every_sixty_fourth_step_is_about_the_whole_body() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![obstacle(
        "lid",
        "z1",
        plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]),
    )];
    let steps: Vec<Step> = (0..66)
        .map(|i| push("lid", [0.0, 0.0, -0.02 - 0.0002 * f64::from(i % 5)]))
        .collect();
    let scene = about(ReportScope::Contact, &scene);
    let (_, reports) = run(&scene, &steps, &mesh(unit_box([2, 2, 2])));
    for (number, report) in (1..).zip(&reports) {
        assert_converged(report);
        assert_eq!(report.left_out.is_empty(), number == 64, "{number}");
        assert_eq!(report.error_estimate.is_some(), number == 64, "{number}");
    }
}

#[test]
fn a_step_that_pushes_its_tool_begins_from_the_whole_body() {
    let mut pushed = travel("ball", 1, [0.0; 3], [0.0; 3]);
    pushed.obstacles[0].force = [None, None, Some(-0.01)];
    let steps = [push("ball", [0.0, 0.0, -0.03]), pushed];
    let scene = about(ReportScope::Contact, &ball(0.5));
    let (_, reports) = run(&scene, &steps, &file("indent_l1"));
    assert_converged(&reports[1]);
    assert!(!reports[0].left_out.is_empty() && reports[1].left_out.is_empty());
    let force = reports[1].obstacles["ball"].force[2];
    assert!(close(force.abs(), 0.01, 1e-5), "{force}");
}

#[test]
fn a_scene_that_has_no_response_is_refused_with_its_reason() {
    let body = file("indent_l1");
    let alone = about(ReportScope::Contact, &ball(0.5));
    let mut rough = alone.clone();
    rough.obstacles[0].friction = 0.3;
    let mut verified = alone.clone();
    verified.solver.verify = true;
    let mut iterative = alone;
    iterative.solver.response = Choice::Named(ResponseMethod::Iterative);
    for (scene, words) in [
        (rough, "friction"),
        (verified, "verified"),
        (iterative, "iterative"),
    ] {
        let fault = unsupported(&scene, &body);
        assert_eq!(fault.path, "solver.report");
        assert!(fault.message.contains(words), "{}", fault.message);
    }
}

#[test]
fn sessions_of_one_body_share_its_response_and_give_the_bits_of_one_alone() {
    let scene = about(ReportScope::Contact, &ball(0.5));
    let body = file("indent_l1");
    let plan = Arc::new(Plan::new(&scene, &[], &body).expect("a valid scene"));
    let prepared = Prepared::build(&plan, &body, &CancelToken::new()).expect("a solvable scene");
    let prepared = Arc::new(prepared);
    let [mut first, mut second] =
        [(); 2].map(|()| Session::new(plan.clone(), body.clone(), prepared.clone(), Reuse::Reused));
    let mut alone = open(&scene, &body);
    let [press, aside] = [
        push("ball", [0.0, 0.0, -0.05]),
        push("ball", [0.0, 0.05, -0.05]),
    ];
    let made = take(&mut first, &aside)[0].factorisations;
    let found = take(&mut second, &press)[0].factorisations;
    take(&mut alone, &press);
    assert_eq!((made, found), (1, 0));
    let field = FieldName::Displacement;
    assert_eq!(values(&second, field), values(&alone, field));
    let own = alone.bytes();
    assert!(second.bytes() < own * 3 / 4, "{} {own}", second.bytes());
    drop(first);
    assert!(second.bytes() > own * 3 / 4, "{} {own}", second.bytes());
}
