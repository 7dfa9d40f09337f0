//! Linear bodies whose gaps are linear about rest: what was apart there is told.

use signorini::report::WarningKind;
use signorini::{Scene, Step};

use super::scenes::{between, joined, linear};
use crate::common::meshes::{mesh, moved, unit_grid};
use crate::common::run_one;
use crate::common::scenes::{pull, support};

/// Two unit squares `gap` apart, pressed together by .05 beyond it; their force and whether a warning
/// tells of it.
fn pressed(gap: f64) -> (f64, bool) {
    let upper = moved(unit_grid(3, 3), |[x, y, z]| [x, y + 1.0 + gap, z]);
    let body = mesh(joined(&[("a_", unit_grid(4, 4)), ("b_", upper)]));
    let roller = |name: &str| support(name, [None, Some(0.0), None]);
    let scene = Scene {
        supports: vec![
            roller("a_y0"),
            support("a_x0", [Some(0.0), None, None]),
            support("b_x0", [Some(0.0), None, None]),
            roller("b_y1"),
        ],
        contacts: between("b_y0", "a_y1"),
        ..linear([("a_body", 1.0), ("b_body", 1.0)])
    };
    let step: Step = pull("b_y1", [None, Some(-gap - 0.05), None], 1);
    let (_, report) = run_one(&scene, &step, &body);
    let mut told = report.warnings.iter();
    let told =
        told.any(|one| one.kind == WarningKind::LargeStrain && one.message.contains("at rest"));
    (report.contacts["pair"].force[1].abs(), told)
}

/// The exact force does not depend on the gap: it does by a tenth of itself where the warning stands.
#[test]
fn linear_bodies_that_were_apart_at_rest_are_warned_of() {
    let (touching, none) = pressed(0.0);
    let (near, still_none) = pressed(0.001);
    let (far, told) = pressed(0.1);
    assert!(!none && !still_none && told);
    assert!((near / touching - 1.0).abs() < 2e-3, "{near} {touching}");
    assert!((far / touching - 1.0).abs() > 0.03, "{far} {touching}");
}
