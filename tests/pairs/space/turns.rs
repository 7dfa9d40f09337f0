//! Scenes in space turned as a whole.

use std::sync::Arc;

use signorini::{EdgeOffset, Mesh, MeshParts, Scene, StepReport};

use crate::common::meshes::{moved, unit_box};
use crate::common::rounded::offsets;
use crate::common::scenes::{pull, support};
use crate::common::{assert_converged, solve};
use crate::scenes::{between, joined, rubber};

const HELD: [Option<f64>; 3] = [Some(0.0); 3];

/// x turned by `angle` about z, then about x.
fn turned([x, y, z]: [f64; 3], angle: f64) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    let [x, y] = [cosine * x - sine * y, sine * x + cosine * y];
    [x, cosine * y - sine * z, sine * y + cosine * z]
}

/// A block with a round sole over a slab.
fn parts() -> MeshParts {
    let block = moved(unit_box([2, 3, 2]), |[x, y, z]| {
        let at = [x - 0.47, y - 0.5, z];
        [at[0], at[1], z + sole(at) * (1.0 - z)]
    });
    let slab = moved(unit_box([3, 3, 1]), |[x, y, z]| {
        [1.6 * (x - 0.5), 1.6 * (y - 0.5), 0.5 * (z - 1.0)]
    });
    joined(&[("block_", block), ("slab_", slab)])
}

/// Height of the sole.
fn sole([x, y, _]: [f64; 3]) -> f64 {
    0.4 * ((x - 0.03).powi(2) + y * y)
}

/// The bodies, edges of the sole on its surface, all of it turned.
fn mesh(angle: f64) -> Arc<Mesh> {
    let parts = parts();
    let middles = offsets(&parts, |ends| {
        let is_on = |at: &[f64; 3]| (at[2] - sole(*at)).abs() < 1e-12;
        let middle = [0, 1, 2].map(|i| 0.5 * (ends[0][i] + ends[1][i]));
        let raised = [middle[0], middle[1], sole(middle)];
        ends.iter().all(is_on).then_some(raised)
    });
    let turned_offset = |edge: EdgeOffset| EdgeOffset {
        offset: turned(edge.offset, angle),
        ..edge
    };
    let offsets = middles.into_iter().map(turned_offset).collect();
    let parts = moved(parts, |x| turned(x, angle));
    Arc::new(Mesh::second_order(parts, offsets).expect("a valid mesh"))
}

/// The block pressed on the slab and pushed along it, all of it turned.
fn slid(angle: f64) -> StepReport {
    let mut scene = Scene {
        supports: vec![support("slab_z0", HELD), support("block_z1", HELD)],
        contacts: between("block_z0", "slab_z1"),
        ..rubber([("block_body", 1.0), ("slab_body", 1.0)], Some(10.0))
    };
    scene.solver.tolerance = 1e-12;
    let to = |way: [f64; 3]| pull("block_z1", turned(way, angle).map(Some), 1);
    let steps = [to([0.0, 0.0, -0.1]), to([0.1, 0.04, -0.1])];
    let mut reports = solve(&scene, &steps, &mesh(angle));
    let report = reports.remove(1);
    assert_converged(&report);
    report
}

#[test]
fn a_scene_in_space_that_is_turned_as_a_whole_has_the_forces_turned() {
    let plain = slid(0.0);
    let expected = plain.contacts["pair"].force;
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(plain.sqp_iterations <= 6, "{}", plain.sqp_iterations);
    for angle in [0.4, 1.9, -1.0, 20.0 * std::f64::consts::PI] {
        let report = slid(angle);
        let turned = turned(expected, angle);
        let found = report.contacts["pair"].force;
        let miss = [0, 1, 2].map(|i| found[i] - turned[i]);
        let miss = norm(miss) / norm(expected);
        assert!(miss < 1e-11, "{angle} {miss:e}");
    }
}
