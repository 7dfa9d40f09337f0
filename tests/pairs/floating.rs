//! Bodies that contact alone holds, between others.

use super::scenes::{between, joined, linear, rubber};
use crate::common::meshes::{file, mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, pull, support, traction};
use crate::common::{assert_converged, close, solve, solve_one};
use signorini::scene::ContactPair;
use signorini::{Mesh, Scene, Step, StepReport};
use std::sync::Arc;

/// Three bodies, one above the other, whose surfaces have a `kink` in the middle, so that they hold the
/// second one along them.
fn stack(kink: f64) -> Arc<Mesh> {
    let below = move |x: f64| 1.0 + kink * ((x - 0.5).abs() - 0.25);
    let above = move |x: f64| 3.0 - below(x);
    let low = moved(unit_grid(6, 4), move |[x, y, z]| [x, y * below(x), z]);
    let middle = moved(unit_grid(4, 4), move |[x, y, z]| {
        [x, below(x) + y * (above(x) - below(x)), z]
    });
    let up = moved(unit_grid(6, 4), move |[x, y, z]| {
        [x, above(x) + y * (3.0 - above(x)), z]
    });
    mesh(joined(&[("low_", low), ("mid_", middle), ("up_", up)]))
}

/// The contacts below and above the body in the middle, which carries both.
fn contacts() -> Vec<ContactPair> {
    let named = |name: &str, own: &str, other: &str| {
        let mut contact = between(own, other).remove(0);
        contact.name = name.to_owned();
        contact
    };
    vec![
        named("below", "mid_y0", "low_y1"),
        named("above", "mid_y1", "up_y0"),
    ]
}

/// Largest of the forces on the body in the middle, and what is left of their sum.
fn balance(report: &StepReport) -> (f64, f64) {
    let [below, above] = ["below", "above"].map(|name| report.contacts[name].force);
    let left = (below[0] + above[0]).hypot(below[1] + above[1]);
    (below[1].abs(), left)
}

#[test]
fn a_linear_block_between_two_others_passes_their_pressure_on() {
    for middle in [1.0, 1e3, 1e-3, 1e6] {
        let mut scene = Scene {
            supports: vec![
                support("low_y0", [None, Some(0.0), None]),
                support("low_x0", [Some(0.0), None, None]),
                support("up_y1", [None, Some(0.0), None]),
                support("up_x0", [Some(0.0), None, None]),
            ],
            contacts: contacts(),
            ..linear([("low_body", 1.0), ("mid_body", middle), ("up_body", 1.0)])
        };
        // Rounding of the stiff one's forces hides the rest.
        scene.solver.tolerance = if middle > 1e5 { 1e-9 } else { 1e-11 };
        let step = pull("up_y1", [None, Some(-0.01), None], 1);
        let reports = solve(&scene, &[step], &stack(0.0));
        let report = &reports[0];
        assert_converged(report);
        // Plane strain of incompressible bodies: 4 mu times the strain.
        let exact = 0.01 * 4.0 / (2.0 + 1.0 / middle);
        let (force, left) = balance(report);
        assert!(close(force, exact, 1e-9), "{middle} {force} {exact}");
        assert!(left < 1e-10 * exact, "{middle} {left:e}");
    }
}

#[test]
fn a_lens_of_rubber_between_two_blocks_passes_their_pressure_on() {
    let scene = {
        let roller = |name: &str| support(name, [Some(0.0), None, None]);
        let mut scene = Scene {
            supports: vec![
                support("low_y0", [None, Some(0.0), None]),
                support("up_y1", [None, Some(0.0), None]),
                roller("low_x0"),
                roller("low_x1"),
                roller("up_x0"),
                roller("up_x1"),
            ],
            contacts: contacts(),
            ..rubber(
                [("low_body", 1.0), ("mid_body", 1.0), ("up_body", 1.0)],
                Some(200.0),
            )
        };
        scene.solver.tolerance = 1e-10;
        scene
    };
    let step = pull("up_y1", [None, Some(-0.15), None], 1);
    let report = solve(&scene, &[step], &stack(0.4)).remove(0);
    assert_converged(&report);
    let (force, left) = balance(&report);
    assert!(force > 0.01 && left < 1e-8 * force, "{force} {left:e}");
    let [low, up] = ["low_y0", "up_y1"].map(|name| report.supports[name].force);
    assert!((low[1] + up[1]).abs() < 1e-8 * force, "{low:?} {up:?}");
    assert!(report.sqp_iterations <= 8, "{}", report.sqp_iterations);
}

#[test]
fn a_stiff_block_that_lies_on_a_soft_one_is_as_an_independent_code_has_it() {
    let mesh = file("pair_float");
    let mut scene = Scene {
        supports: vec![support("a_bot", HELD_IN_PLANE)],
        contacts: between("b_bot", "a_top"),
        tractions: vec![traction("b_top", [0.0, -0.05, 0.0])],
        ..linear([("a", 1.0), ("b", 1000.0)])
    };
    scene.solver.tolerance = 1e-11;
    let report = solve_one(&scene, &Step::default(), &mesh);
    // The load of a top of length .73.
    let [across, up, _] = report.contacts["pair"].force;
    assert!(
        close(up, 0.0365, 1e-9) && across.abs() < 1e-11,
        "{across:e} {up}"
    );
    assert!(close(report.strain_energy, 0.000159138215576, 1e-9));
}
