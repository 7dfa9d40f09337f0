//! Edges of one body over the middle of the other one's faces, whichever side carries.

use signorini::{MeshParts, Scene, Step, StepReport, Termination};

use crate::common::meshes::{mesh, moved, unit_box};
use crate::common::scenes::{pull, support};
use crate::common::{close, solve_one};
use crate::scenes::{between, joined, rubber};

const HELD: [Option<f64>; 3] = [Some(0.0); 3];

/// A block pressed by .05 into a cube of rubber of shear modulus one.
fn pressed(block: MeshParts, modulus: f64, carrier: [&str; 2]) -> StepReport {
    let body = mesh(joined(&[("low_", unit_box([3, 3, 2])), ("up_", block)]));
    let scene = Scene {
        supports: vec![support("low_z0", HELD), support("up_z1", HELD)],
        contacts: between(carrier[0], carrier[1]),
        ..rubber(
            [("low_body", 1.0), ("up_body", modulus)],
            Some(10.0 * modulus),
        )
    };
    let step: Step = pull("up_z1", [Some(0.0), Some(0.0), Some(-0.05)], 1);
    let report = solve_one(&scene, &step, &body);
    assert_eq!(report.termination, Termination::Converged);
    assert_eq!(report.cause, None);
    report
}

/// Force and programs from either side.
fn from_both(block: &MeshParts, modulus: f64) -> [(f64, u32); 2] {
    let sides = [["low_z1", "up_z0"], ["up_z0", "low_z1"]];
    sides.map(|carrier| {
        let report = pressed(block.clone(), modulus, carrier);
        let force = report.contacts["pair"].force[2].abs();
        (force, report.sqp_iterations)
    })
}

fn small() -> MeshParts {
    moved(unit_box([2, 2, 2]), |[x, y, z]| {
        [0.23 + 0.5 * x, 0.31 + 0.5 * y, 1.0 + 0.5 * z]
    })
}

#[test]
fn a_small_block_presses_into_a_larger_one_that_carries() {
    let [larger, smaller] = from_both(&small(), 1.0);
    assert!(larger.1 <= 8 && smaller.1 <= 8, "{larger:?} {smaller:?}");
    assert!(close(larger.0, smaller.0, 0.05), "{larger:?} {smaller:?}");
}

/// The edges of a stiff block cut faces of a third of the cube: either side makes of them what it can.
#[test]
fn a_stiff_small_block_presses_into_a_larger_one_that_carries() {
    let [larger, smaller] = from_both(&small(), 1000.0);
    assert!(larger.1 <= 20 && smaller.1 <= 8, "{larger:?} {smaller:?}");
    assert!(close(larger.0, smaller.0, 0.3), "{larger:?} {smaller:?}");
}

#[test]
fn blocks_that_overlap_by_their_corners_press_from_either_side() {
    let beside = moved(unit_box([3, 2, 2]), |[x, y, z]| {
        [0.43 + x, 0.41 + y, 1.0 + z]
    });
    let [first, second] = from_both(&beside, 1.0);
    assert!(first.1 <= 8 && second.1 <= 8, "{first:?} {second:?}");
    assert!(close(first.0, second.0, 0.05), "{first:?} {second:?}");
}
