//! Two blocks in a closed box, on a floor that is flat or rises in its middle.

use super::scenes::{between, carried_along, rubber};
use crate::common::meshes::file;
use crate::common::scenes::{pull, support};
use crate::common::{assert_converged, close, solve};
use signorini::{Scene, StepReport};

/// The box of bulk modulus `bulk` squeezed by a tenth of a block, on a floor that rises by `bump`.
fn squeezed(bulk: f64, bump: f64) -> StepReport {
    let mesh = file("pair_box_6_8");
    let floor = |[x, ..]: [f64; 3]| {
        let rise = bump * (std::f64::consts::PI * x).sin().powi(2);
        [0.0, rise, 0.0]
    };
    let floor = carried_along(&mesh, "a_bot", floor);
    let scene = Scene {
        supports: vec![
            signorini::scene::Support {
                displacement: [None, Some(0.0), None],
                ..floor
            },
            support("b_top", [None, Some(0.0), None]),
            support("a_left", [Some(0.0), None, None]),
            support("a_right", [Some(0.0), None, None]),
            support("b_left", [Some(0.0), None, None]),
            support("b_right", [Some(0.0), None, None]),
        ],
        contacts: between("b_bot", "a_top"),
        ..rubber([("a", 1.0), ("b", 1.0)], Some(bulk))
    };
    let step = pull("b_top", [None, Some(-0.1), None], 1);
    let mut reports = solve(&scene, &[step], &mesh);
    let report = reports.remove(0);
    assert_converged(&report);
    report
}

#[test]
fn a_closed_box_of_two_blocks_stays_even_at_eighty_moduli() {
    let report = squeezed(1000.0, 0.0);
    let force = report.contacts["pair"].force;
    assert!(close(force[1], 83.4564324736, 1e-8), "{force:?}");
    assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
    assert!(close(
        report.contacts["pair"].mean_pressure.unwrap_or_default(),
        force[1],
        1e-6
    ));
}

#[test]
fn a_box_on_a_floor_that_rises_is_as_an_independent_code_has_it() {
    let report = squeezed(50.0, 0.06);
    let force = report.contacts["pair"].force;
    // That code measures by closest points, and the surface of six and eight cells is rough.
    assert!(close(force[1], 5.27202435256, 2e-3), "{force:?}");
    assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
}
