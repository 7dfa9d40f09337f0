//! Linear bodies press where they met at rest; rubber meets what is there.

use super::scenes::{between, joined, linear_of, rubber};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::scenes::{HELD_IN_PLANE, support};
use crate::common::{assert_converged, solve_one};
use signorini::report::WarningKind;
use signorini::scene::SupportTarget;
use signorini::{Scene, Step};

/// A block of a third of a square on a square of five facets a side, pressed by a hundredth and led
/// along it by `way`; whether its sliding is doubted. Both are carried by `carried` besides.
fn is_doubted(law: Scene, way: f64, carried: f64) -> bool {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| {
        [0.2 + x / 3.0, 1.0 + y / 3.0, z]
    });
    let parts = joined(&[("up_", upper), ("low_", unit_grid(5, 5))]);
    let scene = Scene {
        supports: vec![
            support("up_y1", HELD_IN_PLANE),
            support("low_y0", HELD_IN_PLANE),
        ],
        contacts: between("up_y0", "low_y1"),
        ..law
    };
    let target = |name: &str, [x, y]: [f64; 2]| SupportTarget {
        name: name.to_owned(),
        displacement: [Some(x), Some(y), None],
        ..SupportTarget::default()
    };
    let step = Step {
        supports: vec![
            target("up_y1", [way + carried, -0.01]),
            target("low_y0", [carried, 0.0]),
        ],
        ..Step::default()
    };
    let report = solve_one(&scene, &step, &mesh(parts));
    assert_converged(&report);
    let mut kinds = report.warnings.iter().map(|one| one.kind);
    kinds.any(|kind| kind == WarningKind::LargeSliding)
}

#[test]
fn linear_bodies_that_have_slid_by_more_than_a_facet_are_doubted() {
    let linear = || linear_of(0.3, [("up_body", 1.0), ("low_body", 2.0)]);
    let of_rubber = || rubber([("up_body", 1.0), ("low_body", 2.0)], Some(10.0));
    // Facets of the carrier are a ninth long.
    assert!(!is_doubted(linear(), 0.05, 0.0));
    assert!(!is_doubted(linear(), 0.05, 1.0));
    assert!(is_doubted(linear(), 0.15, 0.0));
    assert!(is_doubted(linear(), 1.5, 0.0));
    assert!(!is_doubted(of_rubber(), 0.15, 0.0));
}
