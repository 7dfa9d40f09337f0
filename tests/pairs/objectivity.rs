//! Scenes turned as a whole.

use std::sync::Arc;

use super::scenes::{between, rubber};
use crate::common::meshes::{curved_file, file_parts, moved};
use crate::common::scenes::{HELD_IN_PLANE, pull, support};
use crate::common::{assert_converged, solve};
use signorini::{EdgeOffset, Mesh, Scene, StepReport};

/// x turned by `angle` about the origin.
pub(crate) fn turned([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y, z]
}

/// A half disc over a slab, turned.
pub(crate) fn mesh(angle: f64) -> Arc<Mesh> {
    let straight = curved_file("pair_slide");
    let offsets = straight.edge_offsets().iter().map(|edge| EdgeOffset {
        ends: edge.ends,
        offset: turned(edge.offset, angle),
    });
    let parts = moved(file_parts("pair_slide"), |x| turned(x, angle));
    Arc::new(Mesh::second_order(parts, offsets.collect()).expect("a valid mesh"))
}

/// The disc pressed on the slab and pushed along it, all of it turned.
fn slid(angle: f64) -> StepReport {
    let mut scene = Scene {
        supports: vec![
            support("s_bot", HELD_IN_PLANE),
            support("d_top", HELD_IN_PLANE),
        ],
        contacts: between("d_con", "s_top"),
        ..rubber([("disc", 1.0), ("slab", 1.0)], None)
    };
    scene.solver.tolerance = 1e-12;
    let to = |x, y| {
        let [x, y, _] = turned([x, y, 0.0], angle);
        pull("d_top", [Some(x), Some(y), None], 1)
    };
    let mut reports = solve(&scene, &[to(0.0, -0.08), to(0.1, -0.08)], &mesh(angle));
    let report = reports.remove(1);
    assert_converged(&report);
    report
}

#[test]
fn a_scene_that_is_turned_as_a_whole_has_the_forces_turned() {
    let plain = slid(0.0);
    let expected = plain.contacts["pair"].force;
    let size = expected[0].hypot(expected[1]);
    for angle in [0.4, 1.9, 3.1, -1.0, 20.0 * std::f64::consts::PI] {
        let report = slid(angle);
        let back = turned(report.contacts["pair"].force, -angle);
        let miss = (back[0] - expected[0]).hypot(back[1] - expected[1]) / size;
        assert!(miss < 1e-11, "{angle} {miss:e}");
    }
}
