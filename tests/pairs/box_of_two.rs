//! Two blocks in a closed box: pressure far above the shear modulus.

use super::scenes::{between, rubber};
use crate::common::meshes::file;
use crate::common::scenes::{pull, support};
use crate::common::{close, solve};
use signorini::{Scene, Termination};

#[test]
fn a_closed_box_of_two_blocks_stays_even_at_eighty_moduli() {
    let mesh = file("pair_box_6_8");
    let scene = Scene {
        supports: vec![
            support("a_bot", [None, Some(0.0), None]),
            support("b_top", [None, Some(0.0), None]),
            support("a_left", [Some(0.0), None, None]),
            support("a_right", [Some(0.0), None, None]),
            support("b_left", [Some(0.0), None, None]),
            support("b_right", [Some(0.0), None, None]),
        ],
        contacts: between("b_bot", "a_top"),
        ..rubber([("a", 1.0), ("b", 1.0)], Some(1000.0))
    };
    let step = pull("b_top", [None, Some(-0.1), None], 1);
    let reports = solve(&scene, &[step], &mesh);
    let report = reports.last().expect("a report");
    assert_eq!(report.termination, Termination::Converged);
    let force = report.contacts["pair"].force;
    assert!(close(force[1], 83.4564324736, 1e-8), "{force:?}");
    assert!(report.sqp_iterations <= 6, "{}", report.sqp_iterations);
    assert!(close(
        report.contacts["pair"].mean_pressure.unwrap_or_default(),
        force[1],
        1e-6
    ));
}
