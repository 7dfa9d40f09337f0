//! Results that a mechanic would doubt carry a warning, and those that are sound carry none.

use std::sync::Arc;

use crate::common::meshes::{cube, mesh, moved, unit_grid};
use crate::common::scenes::{
    HELD, elastic, in_parts, obstacle, plane, press, pull, push, rubber, support, traction,
};
use crate::common::{assert_converged, open, solve, solve_one, take};
use signorini::report::WarningKind;
use signorini::scene::{RubberModel, SceneKind, Shape};
use signorini::{Mesh, Scene, StepReport, Termination};

fn sphere(centre: [f64; 3], radius: f64) -> Shape {
    Shape::Sphere { centre, radius }
}

/// A block on its base with that obstacle over it.
fn block(shape: Shape) -> Scene {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![obstacle("tool", "z1", shape)];
    scene
}

fn coarse() -> Arc<Mesh> {
    mesh(cube(2))
}

/// What is doubted in a converged increment.
fn doubts(report: &StepReport) -> Vec<WarningKind> {
    assert_converged(report);
    report.warnings.iter().map(|warning| warning.kind).collect()
}

#[test]
fn a_sound_press_carries_no_warning() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let report = solve_one(&scene, &push("press", [0.0, 0.0, -0.02]), &coarse());
    assert_eq!(doubts(&report), []);
}

#[test]
fn an_obstacle_that_comes_near_and_touches_nothing_is_named() {
    let scene = block(sphere([0.5, 0.5, 3.0], 1.0));
    let report = solve_one(&scene, &push("tool", [0.0, 0.0, -0.5]), &coarse());
    assert_eq!(doubts(&report), [WarningKind::UntouchedObstacle]);
    let warning = &report.warnings[0];
    assert_eq!(warning.subject, "tool");
    let gap = warning.value.expect("the gap");
    assert!((gap - 0.5).abs() < 1e-12, "{gap}");
    // One that lifts off is meant to.
    let report = solve_one(&scene, &push("tool", [0.0, 0.0, 0.5]), &coarse());
    assert_eq!(doubts(&report), []);
}

#[test]
fn a_tool_smaller_than_the_faces_is_felt_or_doubted() {
    for radius in [0.3, 0.1, 0.05, 0.02] {
        for centre in [[0.5, 0.5], [0.35, 0.6], [0.25, 0.3], [0.62, 0.81]] {
            let depth = 0.3 * radius;
            let scene = block(sphere([centre[0], centre[1], 1.0 + radius], radius));
            let report = solve_one(&scene, &push("tool", [0.0, 0.0, -depth]), &coarse());
            assert_converged(&report);
            let tool = &report.obstacles["tool"];
            let felt = -tool.force[2] > 0.0;
            // Hertz: 4/3 E* sqrt(R) d^1.5, E* = 2 mu / (1 - nu), mu = 1.
            let modulus = 2.0 / (1.0 - 0.3);
            let true_force = 4.0 / 3.0 * modulus * radius.sqrt() * depth.powf(1.5);
            let error = tool.force_error.expect("a linear body");
            let is_bounded = felt || error >= true_force;
            assert!(is_bounded, "{radius} {centre:?} {error} {true_force}");
            let kinds = doubts(&report);
            let is_doubted = kinds.contains(&WarningKind::MissedContact)
                || kinds.contains(&WarningKind::CoarseContact);
            assert!(
                is_doubted,
                "{radius} {centre:?} {felt} {:?}",
                report.warnings
            );
        }
    }
}

#[test]
fn a_body_that_nothing_holds_and_nothing_touches_is_named() {
    let mut scene = block(sphere([0.5, 0.5, 3.0], 1.0));
    scene.supports.clear();
    let report = solve_one(&scene, &push("tool", [0.0, 0.0, 1.0]), &coarse());
    assert_eq!(doubts(&report), [WarningKind::FreeMotion]);
}

#[test]
fn a_body_that_a_plate_pushes_before_it_is_named() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.obstacles = vec![press("z1")];
    let report = solve_one(&scene, &push("press", [0.0, 0.0, -0.1]), &coarse());
    assert!(doubts(&report).contains(&WarningKind::FreeMotion));
    // Onto another one it is held.
    let floor = plane([0.0; 3], [0.0, 0.0, 1.0]);
    scene.obstacles.push(obstacle("floor", "z0", floor));
    let report = solve_one(&scene, &push("press", [0.0, 0.0, -0.1]), &coarse());
    assert!(!doubts(&report).contains(&WarningKind::FreeMotion));
}

#[test]
fn a_tool_moved_through_the_body_at_once_does_not_come_out_on_the_other_side() {
    let scene = block(sphere([0.5, 0.5, 1.3], 0.25));
    let reports = solve(&scene, &[push("tool", [0.0, 0.0, -50.0])], &coarse());
    let mut kinds = reports[0].warnings.iter().map(|warning| warning.kind);
    let is_named = kinds.any(|kind| kind == WarningKind::PassedThrough);
    let has_stopped = reports[0].termination == Termination::NotConverged;
    assert!(has_stopped || is_named, "{:?}", reports[0]);
}

#[test]
fn a_tool_that_begins_inside_the_body_is_named() {
    let scene = block(sphere([0.5, 0.5, 1.2], 0.3));
    let report = solve_one(&scene, &signorini::Step::default(), &coarse());
    let named = report
        .warnings
        .iter()
        .find(|w| w.kind == WarningKind::BeginsInside);
    let depth = named.and_then(|warning| warning.value).expect("the depth");
    assert!((depth - 0.1).abs() < 1e-3, "{depth}");
}

#[test]
fn strains_of_a_linear_law_beyond_ten_percent_are_named() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let report = solve_one(&scene, &push("press", [0.0, 0.0, -0.5]), &coarse());
    assert_eq!(doubts(&report), [WarningKind::LargeStrain]);
    let strain = report.warnings[0].value.expect("the strain");
    assert!((0.4..0.8).contains(&strain), "{strain}");
}

#[test]
fn a_body_carried_so_far_that_its_strains_drown_is_named() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("y0", [Some(1e9), Some(0.0), None])];
    scene.tractions = vec![traction("y1", [0.0, 1e-4, 0.0])];
    let far = mesh(moved(unit_grid(2, 2), |x| x));
    let report = solve_one(&scene, &signorini::Step::default(), &far);
    let found = doubts(&report);
    assert!(found.contains(&WarningKind::LostDigits), "{report:?}");
}

#[test]
fn a_tool_that_lifts_off_has_not_passed_through_the_body() {
    for (travel, is_named) in [(0.8, false), (-50.0, true)] {
        let mut session = open(&block(sphere([0.5, 0.5, 1.3], 0.3)), &mesh(cube(4)));
        take(&mut session, &push("tool", [0.0, 0.0, -0.1]));
        let report = take(&mut session, &push("tool", [0.0, 0.0, travel])).remove(0);
        let mut kinds = report.warnings.iter().map(|warning| warning.kind);
        let has_passed = kinds.any(|kind| kind == WarningKind::PassedThrough);
        let has_stopped = report.termination == Termination::NotConverged;
        assert_eq!(has_passed || has_stopped, is_named, "{report:?}");
    }
}

/// Lengths of one round strains away of 1e-10: the forces are those of a press a thousand
/// times as deep to the digits that are left, or that is said.
#[test]
fn rubber_that_is_hardly_pressed_ends_and_says_what_is_lost() {
    let law = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let mut scene = rubber(law, None);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let force = |depth: f64| {
        let report = solve_one(&scene, &push("press", [0.0, 0.0, -depth]), &coarse());
        assert_eq!(report.termination, Termination::Converged, "{depth:e}");
        let is_doubted = report
            .warnings
            .iter()
            .any(|w| w.kind == WarningKind::LostDigits);
        assert_eq!(is_doubted, depth < 1e-8, "{depth:e} {:?}", report.warnings);
        report.obstacles["press"].force[2] / depth
    };
    let exact = force(1e-6);
    for (depth, accuracy) in [(1e-8, 1e-5), (1e-10, 1e-3), (1e-12, 0.1)] {
        let relative = force(depth) / exact - 1.0;
        assert!(relative.abs() < accuracy, "{depth:e} {relative:e}");
    }
}

/// Gaps of a body of length one are rounded whatever it is pressed by.
#[test]
fn an_elastic_body_that_is_hardly_pressed_ends_and_says_what_is_lost() {
    let mut scene = elastic(0.3);
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let force = |depth: f64| {
        let report = solve_one(&scene, &push("press", [0.0, 0.0, -depth]), &coarse());
        let is_doubted = doubts(&report).contains(&WarningKind::LostDigits);
        assert_eq!(is_doubted, depth < 1e-8, "{depth:e}");
        report.obstacles["press"].force[2] / depth
    };
    let exact = force(1e-3);
    for (depth, accuracy) in [(1e-8, 1e-6), (1e-10, 1e-4), (1e-12, 0.01)] {
        let relative = force(depth) / exact - 1.0;
        assert!(relative.abs() < accuracy, "{depth:e} {relative:e}");
    }
}

/// All sides of a block are held up to their rim, and its top is pressed: beside the rim the
/// body lies inside the lid, a large part of what the lid displaces.
#[test]
fn a_body_that_bulges_far_between_the_nodes_of_pressed_faces_is_named() {
    let mut scene = elastic(0.499);
    scene.supports = ["z0", "x0", "x1", "y0", "y1"]
        .map(|side| support(side, HELD))
        .to_vec();
    scene.obstacles = vec![press("z1")];
    let names_bulges = |depth: f64, scene: &Scene| {
        let report = solve_one(scene, &push("press", [0.0, 0.0, -depth]), &mesh(cube(4)));
        let mut warnings = report.warnings.iter();
        warnings.any(|warning| warning.message.contains("bulges"))
    };
    assert!(names_bulges(0.06, &scene));
    // Free sides have no such rim.
    scene.supports.truncate(1);
    assert!(!names_bulges(0.06, &scene));
}

/// A ball on the edge of a block that may press its top only; on the middle of it all is well.
#[test]
fn a_tool_sunk_into_a_side_that_it_may_not_press_is_named() {
    for (place, is_named) in [(0.5, false), (1.1, true)] {
        let scene = block(sphere([place, 0.5, 1.4], 0.5));
        let mut session = open(&scene, &mesh(cube(4)));
        let report = take(&mut session, &push("tool", [0.0, 0.0, -0.2])).remove(0);
        let mut warnings = report.warnings.iter();
        let sides = |w: &&signorini::report::Warning| w.message.contains("`on` does not name");
        assert_eq!(report.termination, Termination::Converged);
        assert_eq!(
            warnings.find(sides).is_some(),
            is_named,
            "{:?}",
            report.warnings
        );
    }
}

/// A needle's head, whose way is long against its size.
#[test]
fn a_small_tool_moved_far_through_the_body_is_named() {
    for (height, travel) in [(1.03, -10.0), (1.5, -7.3), (1.021, -3.0)] {
        let scene = block(sphere([0.45, 0.55, height], 0.02));
        let report = solve_one(&scene, &push("tool", [0.0, 0.0, travel]), &coarse());
        let mut kinds = report.warnings.iter().map(|warning| warning.kind);
        let is_named = kinds.any(|kind| kind == WarningKind::PassedThrough);
        let has_stopped = report.termination == Termination::NotConverged;
        assert!(has_stopped || is_named, "{report:?}");
    }
}

#[test]
fn a_tool_that_slips_in_between_nodes_is_named() {
    let wide = moved(unit_grid(12, 6), |[x, y, _]| [2.0 * x, y, 0.0]);
    for radius in [0.05, 0.1] {
        let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
        scene.kind = Some(SceneKind::PlaneStrain);
        scene.supports = vec![
            support("y0", [Some(0.0), Some(0.0), None]),
            support("x0", [Some(0.0), None, None]),
            support("x1", [Some(0.0), None, None]),
        ];
        let shape = Shape::Cylinder {
            point: [1.0, 1.0 + radius, 0.0],
            axis: [0.0, 0.0, 1.0],
            radius,
        };
        scene.obstacles = vec![obstacle("tool", "y1", shape)];
        let step = in_parts(push("tool", [0.0, -0.3, 0.0]), 5);
        for report in solve(&scene, &[step], &mesh(wide.clone())) {
            let force = report.obstacles["tool"].force[1];
            let is_doubted = report.warnings.iter().any(|warning| {
                let kinds = [
                    WarningKind::PassedThrough,
                    WarningKind::MissedContact,
                    WarningKind::CoarseContact,
                ];
                kinds.contains(&warning.kind)
            });
            let has_stopped = report.termination != Termination::Converged;
            assert!(
                is_doubted || has_stopped,
                "{radius} {force} {:?}",
                report.warnings
            );
        }
    }
}

/// Smaller than the space between any points of a cell that are looked at.
#[test]
fn a_needle_that_lies_in_a_cell_is_named() {
    for radius in [0.02, 0.002] {
        let scene = block(sphere([0.4, 0.55, 1.0 + radius], radius));
        let report = solve_one(&scene, &push("tool", [0.0, 0.0, -0.1]), &coarse());
        assert_eq!(doubts(&report), [WarningKind::PassedThrough], "{radius}");
        let depth = report.warnings[0].value.expect("the depth");
        assert!((depth - 0.1).abs() < 1e-3, "{depth}");
    }
}

#[test]
fn a_body_carried_through_a_tool_is_named() {
    let mut scene = block(sphere([2.0, 0.5, 0.9], 0.2));
    scene.obstacles[0].on = vec!["x1".to_owned(), "z1".to_owned()];
    for (travel, is_through) in [(3.0, true), (0.3, false)] {
        let step = pull("z0", [Some(travel), Some(0.0), Some(0.0)], 1);
        let kinds = doubts(&solve_one(&scene, &step, &coarse()));
        let is_named = kinds.contains(&WarningKind::PassedThrough);
        assert_eq!(is_named, is_through, "{kinds:?}");
    }
}

/// A tool that ends on the far side presses there; one that slides as deep all the way is sound.
#[test]
fn a_body_carried_through_a_tool_that_then_presses_is_named() {
    let mut scene = block(sphere([2.0, 0.5, 0.9], 0.2));
    scene.obstacles[0].on = ["x0", "x1", "z1"].map(str::to_owned).to_vec();
    let step = pull("z0", [Some(2.15), Some(0.0), Some(0.0)], 1);
    let report = solve_one(&scene, &step, &mesh(cube(4)));
    assert!(report.obstacles["tool"].force[0] > 0.0, "{report:?}");
    assert!(doubts(&report).contains(&WarningKind::PassedThrough));
    let mut session = open(&block(sphere([0.3, 0.5, 1.3], 0.3)), &mesh(cube(4)));
    for x in [0.0, 0.4] {
        let report = take(&mut session, &push("tool", [x, 0.0, -0.05])).remove(0);
        assert!(!doubts(&report).contains(&WarningKind::PassedThrough));
    }
}

/// The wall goes into the edge that the base holds: nothing can press there.
#[test]
fn a_support_that_holds_the_body_inside_an_obstacle_is_named() {
    let mut scene = block(Shape::HalfSpace {
        point: [1.0, 0.0, 0.0],
        normal: [-1.0, 0.0, 0.0],
    });
    scene.obstacles[0].on = vec!["x1".to_owned()];
    let report = solve_one(&scene, &push("tool", [-0.05, 0.0, 0.0]), &coarse());
    let mut missed = report.warnings.iter();
    let missed = missed.find(|warning| warning.kind == WarningKind::MissedContact);
    let depth = missed.and_then(|warning| warning.value).expect("the depth");
    assert!((depth - 0.05).abs() < 1e-12, "{depth}");
}
