//! Grooves that stand open above a flat surface.

use std::sync::Arc;

use signorini::report::WarningKind;
use signorini::{Mesh, Scene};

use crate::common::meshes::{mesh, moved, unit_box, unit_grid};
use crate::common::scenes::{pull, support};
use crate::common::{assert_converged, run_one};
use crate::scenes::{between, joined, linear, rubber};

/// Radius of the groove and height of its edges above the flat.
const RADIUS: f64 = 0.1;

/// The lower side of a block from -.5 to .5 whose middle half of cells is a half circle.
fn outline(s: f64) -> [f64; 2] {
    if s <= 0.25 {
        [-0.5 + (0.5 - RADIUS) * s / 0.25, 0.0]
    } else if s >= 0.75 {
        [RADIUS + (0.5 - RADIUS) * (s - 0.75) / 0.25, 0.0]
    } else {
        let (sin, cos) = (std::f64::consts::PI * (1.5 - 2.0 * s)).sin_cos();
        [RADIUS * cos, RADIUS * sin]
    }
}

/// A block with a groove `height` above a flat one.
fn plane(height: f64) -> Arc<Mesh> {
    let upper = moved(unit_grid(16, 6), |[s, t, z]| {
        let [x, y] = outline(s);
        [
            x * (1.0 - t) + (s - 0.5) * t,
            (y + height) * (1.0 - t) + (height + 0.8) * t,
            z,
        ]
    });
    let lower = moved(unit_grid(8, 3), |[s, t, z]| {
        [1.2 * s - 0.6, 0.4 * t - 0.4, z]
    });
    mesh(joined(&[("a_", lower), ("b_", upper)]))
}

/// The same in space, along y.
fn space(height: f64) -> Arc<Mesh> {
    let upper = moved(unit_box([16, 2, 4]), |[s, y, t]| {
        let [x, z] = outline(s);
        [
            x * (1.0 - t) + (s - 0.5) * t,
            0.3 * y,
            (z + height) * (1.0 - t) + (height + 0.8) * t,
        ]
    });
    let lower = moved(unit_box([6, 2, 2]), |[s, y, t]| {
        [1.2 * s - 0.6, 0.3 * y, 0.4 * t - 0.4]
    });
    mesh(joined(&[("a_", lower), ("b_", upper)]))
}

/// Asserts that a block whose groove stands open is not held where it is lifted by a hundredth of the radius.
fn assert_free(scene: Scene, body: &Arc<Mesh>) {
    let is_solid = body.cell_kind().dimension() == 3;
    let (base, foot, head) = if is_solid {
        ("a_z0", "a_z1", "b_z")
    } else {
        ("a_y0", "a_y1", "b_y")
    };
    let (bottom, top) = (format!("{head}0"), format!("{head}1"));
    let z = is_solid.then_some(0.0);
    let scene = Scene {
        supports: vec![
            support(base, [Some(0.0), Some(0.0), z]),
            support(&top, [Some(0.0), Some(0.0), z]),
        ],
        contacts: between(&bottom, foot),
        ..scene
    };
    let up = 0.01 * RADIUS;
    let motion = if is_solid {
        [None, None, Some(up)]
    } else {
        [None, Some(up), None]
    };
    let (_, report) = run_one(&scene, &pull(&top, motion, 1), body);
    assert_converged(&report);
    let found = &report.contacts["pair"];
    let is_told = report
        .warnings
        .iter()
        .any(|one| one.kind == WarningKind::UntouchedObstacle);
    assert!(
        is_told && found.force.iter().all(|part| *part == 0.0),
        "{:?}",
        found.force
    );
}

#[test]
fn an_open_groove_does_not_pull() {
    for height in [0.02, 0.05, 0.12] {
        let body = plane(height);
        assert_free(rubber([("a_body", 20.0), ("b_body", 1.0)], None), &body);
        assert_free(linear([("a_body", 20.0), ("b_body", 1.0)]), &body);
    }
}

#[test]
fn an_open_groove_in_space_does_not_pull() {
    for height in [0.05, 0.12] {
        let body = space(height);
        assert_free(rubber([("a_body", 20.0), ("b_body", 1.0)], None), &body);
        assert_free(linear([("a_body", 20.0), ("b_body", 1.0)]), &body);
    }
}

/// Two half rounds of radius R that overlap by more than half of it: rays of a round carrier meet inside it.
#[test]
fn a_round_tip_presses_however_deep_it_begins() {
    let tip = |overlap: f64| {
        let upper = moved(unit_grid(16, 10), |[s, t, z]| {
            let (sin, cos) = (std::f64::consts::PI * (1.0 + s)).sin_cos();
            let [x, y] = [RADIUS * cos, RADIUS * (1.0 + sin) - overlap];
            [
                x * (1.0 - t) + (2.0 * s - 1.0) * RADIUS * t,
                y * (1.0 - t) + (0.7 - overlap) * t,
                z,
            ]
        });
        let lower = moved(unit_grid(24, 8), |[s, t, z]| {
            [2.0 * s - 1.0, 0.8 * t - 0.8, z]
        });
        mesh(joined(&[("a_", lower), ("b_", upper)]))
    };
    let scene = Scene {
        supports: vec![
            support("a_y0", [Some(0.0), Some(0.0), None]),
            support("b_y1", [Some(0.0), Some(0.0), None]),
        ],
        contacts: between("b_y0", "a_y1"),
        ..rubber([("a_body", 5.0), ("b_body", 1.0)], Some(20.0))
    };
    let (_, report) = run_one(
        &scene,
        &pull("b_y1", [None, Some(0.0), None], 1),
        &tip(0.055),
    );
    assert_converged(&report);
    assert!(report.contacts["pair"].force[1].abs() > 0.01);
}
