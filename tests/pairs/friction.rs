//! Friction between soft bodies.

use std::sync::Arc;

use super::objectivity::{mesh as disc_on_slab, turned};
use super::scenes::{between, joined, linear, linear_of, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, obstacle, plane, pull, support, traction};
use crate::common::{assert_converged, close, solve};
use signorini::scene::ContactPair;
use signorini::{Mesh, Scene, Step, StepReport, Termination};

/// The same contacts with a coefficient of friction.
fn rough(mut contacts: Vec<ContactPair>, friction: f64) -> Vec<ContactPair> {
    contacts.iter_mut().for_each(|one| one.friction = friction);
    contacts
}

/// A low block on a long one, whose meshes do not match.
fn block_on_block() -> Arc<Mesh> {
    let low = moved(unit_grid(10, 3), |[x, y, z]| [3.0 * x - 1.0, y - 1.0, z]);
    let up = moved(unit_grid(5, 3), |[x, y, z]| [x, 0.4 * y, z]);
    mesh(joined(&[("low_", low), ("up_", up)]))
}

/// A block on another one that friction alone holds, pressed by one and pulled by `pull`.
fn pulled(pull: f64, tresca: Option<f64>) -> StepReport {
    let mut scene = Scene {
        supports: vec![support("low_y0", HELD_IN_PLANE)],
        contacts: rough(between("up_y0", "low_y1"), 0.2),
        tractions: vec![traction("up_y1", [pull, -1.0, 0.0])],
        ..linear([("low_body", 10.0), ("up_body", 10.0)])
    };
    if tresca.is_some() {
        scene.contacts[0].friction = 0.0;
        scene.contacts[0].tresca = tresca;
    }
    scene.solver.tolerance = 1e-10;
    solve(&scene, &[Step::default()], &block_on_block()).remove(0)
}

/// Sticks a millionth below the `limit` and slides a millionth above.
fn check_limit(limit: f64, tresca: Option<f64>) {
    let report = pulled(limit * (1.0 - 1e-6), tresca);
    assert_converged(&report);
    let [across, up, _] = report.contacts["pair"].force;
    assert!(close(across, -limit * (1.0 - 1e-6), 1e-8), "{across}");
    assert!(close(up, 1.0, 1e-8), "{up}");
    let above = pulled(limit * (1.0 + 1e-6), tresca);
    assert_eq!(above.termination, Termination::NotConverged);
}

#[test]
fn a_block_on_a_block_sticks_just_below_the_limit_of_friction_and_slides_just_above() {
    check_limit(0.2, None);
}

#[test]
fn a_block_on_a_block_sticks_just_below_its_bound_and_slides_just_above() {
    check_limit(0.05, Some(0.05));
}

/// A coarse block pressed and pushed along a long one, a node of which its bound opens and zero
/// traction closes: it rests in between. Energies of an independent solver (`benches/peers`),
/// whose bound is min(b, k p) with k = 1e9.
#[test]
fn a_node_that_its_bound_opens_and_nothing_else_does_rests_in_between() {
    let low = moved(unit_grid(10, 3), |[x, y, z]| [3.0 * x - 1.0, y - 1.0, z]);
    let up = moved(unit_grid(2, 1), |[x, y, z]| [x, 0.4 * y, z]);
    let blocks = mesh(joined(&[("low_", low), ("up_", up)]));
    for (bound, push, energy) in [
        (0.01, 0.01, 7.196_807_990e-5),
        (0.1, 0.04, 9.295_553_643e-4),
    ] {
        let mut scene = Scene {
            supports: vec![
                support("low_y0", HELD_IN_PLANE),
                support("up_y1", [Some(push), Some(-0.004), None]),
            ],
            contacts: between("up_y0", "low_y1"),
            ..linear_of(0.3, [("low_body", 10.0), ("up_body", 1.0)])
        };
        scene.contacts[0].tresca = Some(bound);
        scene.solver.tolerance = 1e-10;
        let report = solve(&scene, &[Step::default()], &blocks).remove(0);
        assert_converged(&report);
        let found = report.strain_energy;
        assert!(close(found, energy, 1e-8), "{found} {energy}");
    }
}

/// A block of rubber pressed and pushed along a stiff block, or along a plane in its place.
fn pushed(is_pair: bool) -> Vec<StepReport> {
    let law = rubber([("low_body", 1e6), ("up_body", 1.0)], None);
    let mut scene = Scene {
        supports: vec![support("up_y1", HELD_IN_PLANE)],
        ..law
    };
    scene.solver.tolerance = 1e-9;
    let body = if is_pair {
        scene.supports.push(support("low_y0", HELD_IN_PLANE));
        scene.contacts = rough(between("up_y0", "low_y1"), 0.3);
        block_on_block()
    } else {
        scene.materials.remove(0);
        let mut floor = obstacle("pair", "up_y0", plane([0.0; 3], [0.0, 1.0, 0.0]));
        floor.friction = 0.3;
        scene.obstacles = vec![floor];
        let up = moved(unit_grid(5, 3), |[x, y, z]| [x, 0.4 * y, z]);
        mesh(joined(&[("up_", up)]))
    };
    let steps = [
        pull("up_y1", [Some(0.0), Some(-0.04), None], 1),
        pull("up_y1", [Some(0.015), Some(-0.04), None], 1),
    ];
    let reports = solve(&scene, &steps, &body);
    reports.iter().for_each(assert_converged);
    reports
}

#[test]
fn a_block_pushed_along_a_stiff_block_is_the_block_pushed_along_a_plane() {
    let (pair, tool) = (pushed(true), pushed(false));
    for (pair, tool) in pair.iter().zip(&tool) {
        let (found, expected) = (&pair.contacts["pair"], &tool.obstacles["pair"]);
        let friction = found.friction.expect("friction");
        for i in 0..2 {
            let miss = (found.force[i] - expected.force[i]).abs();
            assert!(miss < 1e-5 * expected.force[1], "{:?}", found.force);
        }
        let [found, expected] = [friction.dissipated_total, expected.dissipated_total];
        assert!(close(found, expected, 2e-5), "{found} {expected}");
        let counts = [friction.stick_vertices, friction.slip_vertices];
        let tool = &tool.obstacles["pair"];
        assert_eq!(counts, [tool.stick_vertices, tool.slip_vertices]);
        assert!(pair.sqp_iterations <= 6, "{}", pair.sqp_iterations);
    }
}

/// The disc pressed on the slab and pushed along it with friction, all of it turned.
fn slid(angle: f64) -> Vec<StepReport> {
    let mut scene = Scene {
        supports: vec![
            support("s_bot", HELD_IN_PLANE),
            support("d_top", HELD_IN_PLANE),
        ],
        contacts: rough(between("d_con", "s_top"), 0.3),
        ..rubber([("disc", 1.0), ("slab", 1.0)], None)
    };
    scene.solver.tolerance = 1e-11;
    let to = |x, y| {
        let [x, y, _] = turned([x, y, 0.0], angle);
        pull("d_top", [Some(x), Some(y), None], 1)
    };
    let steps = [to(0.0, -0.08), to(0.03, -0.08), to(0.1, -0.08)];
    let reports = solve(&scene, &steps, &disc_on_slab(angle));
    reports.iter().for_each(assert_converged);
    reports
}

#[test]
fn friction_between_bodies_turns_with_them() {
    let plain = slid(0.0);
    let last = |reports: &[StepReport]| reports.last().expect("a report").clone();
    let expected = last(&plain).contacts["pair"].force;
    assert!(expected[0].abs() > 0.2 * expected[1].abs(), "{expected:?}");
    let size = expected[0].hypot(expected[1]);
    for angle in [0.4, 1.9, -1.0] {
        let report = last(&slid(angle));
        let back = turned(report.contacts["pair"].force, -angle);
        let miss = (back[0] - expected[0]).hypot(back[1] - expected[1]) / size;
        assert!(miss < 1e-9, "{angle} {miss:e}");
    }
}

/// A narrow block pressed on a wide one of `facets` and dragged over it in `increments`, the `carrier`
/// first.
fn dragged(
    [facets, increments]: [usize; 2],
    [carrier, other]: [&str; 2],
    friction: f64,
) -> Vec<StepReport> {
    let wide = moved(unit_grid(facets, 4), |[x, y, z]| [3.0 * x, y - 1.0, z]);
    let narrow = moved(unit_grid(8, 8), |[x, y, z]| [0.7 + 0.5 * x, y, z]);
    let scene = Scene {
        supports: vec![
            support("w_y0", HELD_IN_PLANE),
            support("n_y1", HELD_IN_PLANE),
        ],
        contacts: rough(between(carrier, other), friction),
        ..rubber([("w_body", 8.0), ("n_body", 2.0)], Some(100.0))
    };
    let steps = [
        pull("n_y1", [Some(0.0), Some(-0.05), None], 2),
        pull("n_y1", [Some(1.0), Some(-0.05), None], increments as u32),
    ];
    let parts = mesh(joined(&[("w_", wide), ("n_", narrow)]));
    solve(&scene, &steps, &parts)
}

#[test]
fn a_narrow_block_is_dragged_over_a_wide_surface_whichever_carries() {
    let carriers = [["w_y1", "n_y0"], ["n_y0", "w_y1"]];
    let [by_wide, by_narrow] = carriers.map(|both| dragged([12, 20], both, 0.2));
    for (wide, narrow) in by_wide.iter().zip(&by_narrow) {
        assert_converged(wide);
        let [own, other] = [wide, narrow].map(|report| report.supports["w_y0"].force);
        assert!(close(own[1], other[1], 0.02), "{own:?} {other:?}");
        assert!(wide.sqp_iterations <= 6, "{}", wide.sqp_iterations);
    }
    // It slides after some increments.
    for report in by_wide.iter().skip(8) {
        let [along, up, _] = report.supports["w_y0"].force;
        assert!(close(along.abs(), 0.2 * up, 0.02), "{along} {up}");
    }
}

#[test]
fn a_function_that_a_block_leaves_behind_presses_on_nothing() {
    let reports = dragged([6, 20], ["w_y1", "n_y0"], 0.0);
    for report in &reports {
        assert_converged(report);
        assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
    }
}
