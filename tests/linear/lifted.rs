//! Obstacles that lift off and come back, and bodies carried away and brought back: what
//! statics knows of neither.

use crate::common::meshes::{cube, file, mesh};
use crate::common::scenes::{HELD, elastic, mooney_rivlin, obstacle, press, push, rubber, support};
use crate::common::{
    assert_converged, assert_converged_at_last, close, difference, open, take, values,
};
use signorini::scene::{Choice, ContactSpace, Shape, SupportTarget};
use signorini::{FieldName, Scene, Step, StepReport};

fn ball(scene: Scene) -> Scene {
    Scene {
        supports: vec![
            support("z0", HELD),
            support("x0", [Some(0.0), None, None]),
            support("y0", [None, Some(0.0), None]),
        ],
        obstacles: vec![obstacle(
            "ball",
            "z1",
            Shape::Sphere {
                centre: [0.0, 0.0, 1.0],
                radius: 1.0,
            },
        )],
        ..scene
    }
}

/// Whether two increments are the same to `relative`.
fn assert_equal((a, b): (&StepReport, &StepReport), name: &str, relative: f64) {
    assert!(
        close(a.strain_energy, b.strain_energy, relative),
        "{a:?} {b:?}"
    );
    for axis in 0..3 {
        let [one, other] = [a, b].map(|report| report.obstacles[name].force[axis]);
        let whole = a.obstacles[name].force[2].abs();
        assert!((one - other).abs() <= relative * whole, "{one} {other}");
    }
}

#[test]
fn a_press_behind_any_lift_equals_the_first_one() {
    let mesh = file("indent_l1");
    for scene in [elastic(0.5), elastic(0.3), rubber(mooney_rivlin(), None)] {
        let mut session = open(&ball(scene), &mesh);
        let down = push("ball", [0.0, 0.0, -0.02]);
        let first = take(&mut session, &down).remove(0);
        assert_converged(&first);
        let moved = values(&session, FieldName::Displacement);
        for height in [0.001, 3.0, 1e6] {
            // Twice in the air: the second time nothing moves any more.
            for lift in [height, 2.0 * height] {
                let air = take(&mut session, &push("ball", [0.0, 0.0, lift])).remove(0);
                assert_converged_at_last(&air);
                assert!(air.strain_energy < 1e-12 * first.strain_energy);
            }
            let again = take(&mut session, &down).remove(0);
            assert_converged_at_last(&again);
            assert_equal((&first, &again), "ball", 1e-7);
            let back = values(&session, FieldName::Displacement);
            assert!(difference(&moved, &back) < 1e-7);
        }
    }
}

#[test]
fn a_tool_that_comes_back_to_just_touch_leaves_a_body_at_rest() {
    for space in [ContactSpace::Quadratic, ContactSpace::Linear] {
        let mut scene = rubber(mooney_rivlin(), None);
        scene.supports = vec![support("z0", HELD)];
        scene.obstacles = vec![press("z1")];
        scene.solver.contact_space = Choice::Named(space);
        let mut session = open(&scene, &mesh(cube(6)));
        let mut reports = Vec::new();
        for height in [-0.05, 0.0] {
            let step = Step {
                increments: 2,
                ..push("press", [0.0, 0.0, height])
            };
            reports.extend(take(&mut session, &step));
        }
        for report in &reports {
            assert_converged(report);
            assert!(report.sqp_iterations <= 8, "{}", report.sqp_iterations);
        }
        // Halfway back is where it has been: no iteration, and all that contact is.
        let [there, again] = [&reports[0], &reports[2]];
        assert_eq!(
            (again.sqp_iterations, again.active_vertices),
            (0, there.active_vertices)
        );
        let areas = [there, again].map(|report| report.obstacles["press"].contact_area);
        assert!(
            (1.025..1.035).contains(&areas[0]) && close(areas[1], areas[0], 1e-12),
            "{areas:?}"
        );
    }
}

/// A plate with rounded edges comes to touch exactly: gaps are rounding, whatever their sign.
#[test]
fn a_rounded_plate_led_to_just_touch_leaves_an_elastic_body_at_rest() {
    for height in [0.2, 0.3, 0.4, 0.55] {
        let mut scene = ball(elastic(0.5));
        scene.obstacles[0].shape = Shape::Box {
            centre: [0.0, 0.0, height + 0.05],
            half_sizes: [3.0, 3.0, 0.05],
            rounding: 0.02,
        };
        let mut session = open(&scene, &file("indent_l1"));
        let step = Step {
            increments: 4,
            ..push("ball", [0.0, 0.0, -height])
        };
        for report in take(&mut session, &step) {
            assert_converged(&report);
            assert!(report.strain_energy < 1e-20, "{height}");
        }
    }
}

/// What a deep press has seen is no measure of a light one.
#[test]
fn rubber_let_go_to_a_light_press_is_pressed_as_if_never_deeper() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let mesh = mesh(cube(4));
    for depth in [1e-4, 1e-6] {
        let light = push("press", [0.0, 0.0, -depth]);
        let fresh = take(&mut open(&scene, &mesh), &light).remove(0);
        let mut session = open(&scene, &mesh);
        take(&mut session, &push("press", [0.0, 0.0, -0.1]));
        let behind = take(&mut session, &light).remove(0);
        assert_converged(&behind);
        assert_equal((&fresh, &behind), "press", 1e-7);
    }
}

/// A step that moves the base.
fn carried(by: f64) -> Step {
    Step {
        supports: vec![SupportTarget {
            name: "z0".to_owned(),
            displacement: [Some(by), None, None],
            ..SupportTarget::default()
        }],
        ..Step::default()
    }
}

/// What a body has been through leaves no scale beside which any force would do.
#[test]
fn a_base_carried_far_away_and_back_is_pressed_as_before() {
    for poisson_ratio in [0.3, 0.5] {
        let mut scene = elastic(poisson_ratio);
        scene.supports = vec![support("z0", HELD)];
        scene.obstacles = vec![press("z1")];
        let mut session = open(&scene, &mesh(cube(3)));
        let down = push("press", [0.0, 0.0, -0.05]);
        let first = take(&mut session, &down).remove(0);
        assert_converged(&first);
        assert!(first.warnings.is_empty(), "{:?}", first.warnings);
        for far in [1e3, 1e6] {
            let there = take(&mut session, &carried(far)).remove(0);
            assert_converged(&there);
            let back = take(&mut session, &carried(0.0)).remove(0);
            assert_converged(&back);
            assert_equal((&first, &back), "press", 1e-6);
        }
    }
}

#[test]
fn a_body_whose_press_lifted_off_far_is_pressed_as_before() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let mut session = open(&scene, &mesh(cube(3)));
    let down = push("press", [0.0, 0.0, -0.05]);
    let first = take(&mut session, &down).remove(0);
    assert_converged(&first);
    let up = take(&mut session, &push("press", [0.0, 0.0, 2.0])).remove(0);
    assert_converged(&up);
    let again = take(&mut session, &down).remove(0);
    assert_converged(&again);
    assert_equal((&first, &again), "press", 1e-7);
}
