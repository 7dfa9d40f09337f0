//! Linear bodies whose response at the contact surface is known answer as programs do.

use std::sync::Arc;

use crate::common::meshes::{file, mesh, unit_box};
use crate::common::refusals::unsupported;
use crate::common::scenes::{
    HELD, elastic, hertz_sphere, in_parts, mooney_rivlin, obstacle, plane, push, rubber, support,
    traction, travel,
};
use crate::common::{assert_converged, close, open, run, take, values};
use signorini::scene::{Choice, ResponseMethod, Shape, SupportTarget};
use signorini::{FieldName, Mesh, Plan, Scene, Step, StepReport};

/// The same scene answered by that method.
fn by(method: ResponseMethod, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.solver.response = Choice::Named(method);
    scene
}

/// Increments by programs and by the response.
fn both(scene: &Scene, steps: &[Step], mesh: &Arc<Mesh>) -> [Vec<StepReport>; 2] {
    [ResponseMethod::Iterative, ResponseMethod::Condensed]
        .map(|method| run(&by(method, scene), steps, mesh).1)
}

/// Asserts forces alike to `relative`, and hardly an application by the response.
fn assert_alike([programs, response]: &[Vec<StepReport>; 2], relative: f64) {
    assert_eq!(programs.len(), response.len());
    for (one, other) in programs.iter().zip(response) {
        assert_converged(other);
        for (name, obstacle) in &one.obstacles {
            let largest = obstacle
                .force
                .iter()
                .fold(0.0_f64, |most, f| most.max(f.abs()));
            for (a, b) in obstacle.force.iter().zip(other.obstacles[name].force) {
                assert!((a - b).abs() <= relative * largest, "{name}: {a} {b}");
            }
        }
        // What is left of a body that was let go is rounding.
        let [a, b] = [one, other].map(|report| report.strain_energy + 1e-12);
        assert!(close(a, b, relative), "{a} {b}");
    }
    let applications = |reports: &[StepReport]| -> u32 {
        reports
            .iter()
            .map(|one| one.preconditioner_applications)
            .sum()
    };
    // One may follow where rounding left a little more than the tolerance.
    let [programs, response] = [programs, response].map(|reports| applications(reports));
    assert!(12 * response <= programs, "{response} {programs}");
}

#[test]
fn a_ball_that_moves_about_is_answered_without_an_application() {
    for ratio in [0.5, 0.3] {
        let (mut scene, _) = hertz_sphere(ratio);
        scene.solver.tolerance = 1e-7;
        let steps = [
            push("ball", [0.0, 0.0, -0.05]),
            push("ball", [0.02, 0.0, -0.052]),
            push("ball", [0.02, 0.05, -0.03]),
            push("ball", [0.0, 0.0, 0.1]),
            push("ball", [0.0, 0.0, -0.02]),
        ];
        assert_alike(&both(&scene, &steps, &file("indent_l1")), 1e-6);
    }
}

/// A block under a plane, with a traction on its side and a base that moves.
fn loaded_block() -> Scene {
    let mut scene = elastic(0.5);
    scene.supports = vec![support("z0", HELD)];
    scene.tractions = vec![traction("x1", [0.05, 0.0, -0.02])];
    scene.obstacles = vec![
        obstacle("lid", "z1", plane([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])),
        obstacle(
            "bar",
            "y1",
            Shape::Cylinder {
                point: [0.5, 1.2, 0.5],
                axis: [0.0, 0.0, 1.0],
                radius: 0.2,
            },
        ),
    ];
    scene.solver.tolerance = 1e-7;
    scene
}

#[test]
fn loads_and_supports_may_change_between_steps_and_two_tools_may_press() {
    let mut shifted = push("lid", [0.0, 0.0, -0.04]);
    shifted.supports = vec![SupportTarget {
        name: loaded_block().supports[0].name.clone(),
        displacement: [Some(0.0), Some(0.01), Some(0.0)],
        ..SupportTarget::default()
    }];
    let mut unloaded = push("bar", [0.0, -0.02, 0.0]);
    unloaded.load = Some(0.25);
    let steps = [
        push("lid", [0.0, 0.0, -0.03]),
        in_parts(push("bar", [0.0, -0.04, 0.0]), 2),
        shifted,
        unloaded,
    ];
    assert_alike(
        &both(&loaded_block(), &steps, &mesh(unit_box([4, 4, 4]))),
        1e-6,
    );
}

#[test]
fn a_session_that_goes_on_elsewhere_makes_the_response_again_to_the_same_bits() {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.tolerance = 1e-7;
    let scene = by(ResponseMethod::Condensed, &scene);
    let body = file("indent_l1");
    let mut here = open(&scene, &body);
    take(&mut here, &push("ball", [0.0, 0.0, -0.06]));
    take(&mut here, &push("ball", [0.0, 0.0, -0.03]));
    let bytes = here.export();
    let mut there = open(&scene, &body);
    there.restore(&bytes).expect("of this scene");
    let next = push("ball", [0.05, 0.0, -0.05]);
    // Columns that only the first session knows change no bit.
    for session in [&mut here, &mut there] {
        take(session, &next);
    }
    for field in [FieldName::Displacement, FieldName::ContactPressure] {
        assert_eq!(values(&here, field), values(&there, field));
    }
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let answers = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("a pool").install(|| {
            let scene = by(ResponseMethod::Condensed, &loaded_block());
            let steps = [
                push("lid", [0.0, 0.0, -0.03]),
                push("bar", [0.0, -0.04, 0.0]),
            ];
            let (session, _) = run(&scene, &steps, &mesh(unit_box([4, 4, 4])));
            values(&session, FieldName::Displacement)
        })
    });
    assert_eq!(answers[0], answers[1]);
}

#[test]
fn a_small_body_is_answered_by_its_response_once_that_has_paid_for_itself() {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.tolerance = 1e-7;
    let steps: Vec<Step> = (0..16)
        .map(|i| push("ball", [0.0, 0.0, -0.05 - 0.0005 * f64::from(i % 4)]))
        .collect();
    let (_, reports) = run(&scene, &steps, &file("indent_l1"));
    assert!(reports[1].preconditioner_applications > 0);
    assert_eq!(reports[15].preconditioner_applications, 0);
    assert_eq!(reports[15].factorisations, 0);
    let made: u32 = reports[1..].iter().map(|one| one.factorisations).sum();
    assert_eq!(made, 1);
}

#[test]
fn a_tool_that_is_pushed_is_answered_by_programs() {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.tolerance = 1e-7;
    let scene = by(ResponseMethod::Condensed, &scene);
    let mut step = travel("ball", 1, [0.0; 3], [0.0; 3]);
    step.obstacles[0].force = [None, None, Some(-0.01)];
    let (_, reports) = run(
        &scene,
        &[push("ball", [0.0, 0.0, -0.03]), step],
        &file("indent_l1"),
    );
    assert_converged(&reports[1]);
    assert!(reports[1].preconditioner_applications > 0);
    let force = reports[1].obstacles["ball"].force[2];
    assert!(close(force.abs(), 0.01, 1e-6), "{force}");
}

/// The response that a plan of `scene` tells of.
fn planned(scene: &Scene, mesh: &Mesh) -> Option<String> {
    let plan = Plan::new(scene, &[], mesh).expect("a plan");
    let entries = plan.report().decisions.into_iter();
    let mut entries = entries.filter(|entry| entry.what == "response");
    entries.next().map(|entry| entry.choice)
}

#[test]
fn the_plan_says_from_which_step_on_and_refuses_what_has_no_response() {
    let body = file("indent_l1");
    let large = Mesh::new(unit_box([12, 12, 12])).expect("a mesh");
    let (scene, _) = hertz_sphere(0.5);
    let words = planned(&scene, &body).expect("a small body");
    assert!(
        words.starts_with("condensed on the contact surface from step "),
        "{words}"
    );
    assert_eq!(planned(&by(ResponseMethod::Iterative, &scene), &body), None);
    assert_eq!(planned(&scene, &large), None);
    let asked = planned(&by(ResponseMethod::Condensed, &scene), &large);
    assert_eq!(asked.as_deref(), Some("condensed on the contact surface"));

    let mut soft = rubber(mooney_rivlin(), None);
    (soft.supports, soft.obstacles) = (scene.supports.clone(), scene.obstacles.clone());
    let mut rough = scene.clone();
    rough.obstacles[0].friction = 0.3;
    let mut floating = scene;
    floating.supports.clear();
    for (scene, words) in [(soft, "linear"), (rough, "friction"), (floating, "rigid")] {
        let fault = unsupported(&by(ResponseMethod::Condensed, &scene), &body);
        assert_eq!(fault.path, "solver.response");
        assert!(fault.message.contains(words), "{}", fault.message);
    }
}

#[test]
fn supports_along_the_normal_are_held_and_idle_ones_left_out() {
    let (mut scene, _) = hertz_sphere(0.3);
    scene.solver.tolerance = 1e-7;
    let symmetry = scene.supports.iter_mut().skip(1);
    for support in symmetry {
        support.displacement = [None; 3];
        support.normal = Some(0.0);
    }
    let steps = [
        push("ball", [0.0, 0.0, -0.05]),
        push("ball", [0.01, 0.0, -0.04]),
    ];
    assert_alike(&both(&scene, &steps, &file("indent_l1")), 1e-6);
}
