//! Rotations of rubber: the torsion of a cylinder, and a stressed body that turns
//! with all that holds it.
//!
//! Rivlin's torsion by tau per length of a cylinder of radius A that keeps its
//! height: torque pi A^4 tau (C10 + C01), so that the energy is half of torque
//! times angle; axial force -(pi / 2) A^4 tau^2 (C10 + 2 C01).

mod common;

use std::f64::consts::{PI, TAU};

use common::curved::cylinder;
use common::meshes::{cube, irregular, mesh};
use common::scenes::{HELD, mooney_rivlin, press, push, rubber, support, turned};
use common::{assert_converged, close, open, solve, take};
use signorini::scene::ObstacleTarget;
use signorini::{Step, StepReport};

const TWIST: f64 = 0.5;
/// Parts of ten turns: ten degrees each.
const INCREMENTS: u32 = 360;

/// Relative errors of energy and axial force for a mesh.
fn torsion((rings, layers): (usize, usize)) -> [f64; 2] {
    let height = 0.4;
    let mut scene = rubber(mooney_rivlin(), None);
    scene.supports = vec![support("z0", HELD), support("z1", HELD)];
    let step = Step {
        supports: vec![turned("z1", [0.0, 0.0, TWIST * height], [0.0; 3])],
        ..Step::default()
    };
    let reports = solve(&scene, &[step], &mesh(cylinder(rings, layers, height)));
    assert_converged(&reports[0]);
    let torque = PI * TWIST * 0.5;
    let axial = -0.5 * PI * TWIST * TWIST * 0.6;
    let energy = 0.5 * torque * TWIST * height;
    [
        (reports[0].strain_energy - energy).abs() / energy,
        (reports[0].supports["z1"].force[2] - axial).abs() / axial.abs(),
    ]
}

#[test]
fn a_twisted_cylinder_has_the_exact_torque_and_axial_force() {
    let errors = [(5, 1), (10, 2), (20, 4)].map(torsion);
    let [coarse, middle, fine] = errors;
    assert!(
        middle[0] <= coarse[0] / 3.8 && fine[0] <= middle[0] / 3.8,
        "{errors:?}"
    );
    assert!(
        fine.iter()
            .zip(coarse)
            .all(|(fine, coarse)| *fine <= coarse / 15.0),
        "{errors:?}"
    );
    assert!(fine.iter().all(|error| *error <= 1e-3), "{errors:?}");
}

/// What a rotation of everything leaves as it is.
fn invariants(report: &StepReport) -> [f64; 5] {
    let force = report.obstacles["press"].force;
    [
        report.strain_energy,
        report.volume_ratio,
        report.min_jacobian.expect("a rubber"),
        report.obstacles["press"].max_pressure,
        force.iter().map(|x| x * x).sum::<f64>().sqrt(),
    ]
}

#[test]
fn a_stressed_body_turns_ten_times_with_its_support_and_its_obstacle() {
    let mut scene = rubber(mooney_rivlin(), None);
    scene.solver.tolerance = 1e-11;
    scene.supports = vec![support("z0", HELD)];
    scene.obstacles = vec![press("z1")];
    let mut session = open(&scene, &mesh(irregular(cube(2), 2)));
    let pressed = take(&mut session, &push("press", [0.0, 0.0, -0.15]));
    assert_converged(&pressed[0]);
    let rotation = [12.0 / 13.0, 3.0 / 13.0, 4.0 / 13.0].map(|x| 10.0 * TAU * x);
    let turns = Step {
        increments: INCREMENTS,
        obstacles: vec![ObstacleTarget {
            name: "press".to_owned(),
            translation: None,
            rotation: Some(rotation),
        }],
        supports: vec![turned("z0", rotation, [0.0, 0.0, 0.85])],
        ..Step::default()
    };
    let reports = take(&mut session, &turns);
    let at_rest = invariants(&pressed[0]);
    for report in &reports {
        assert_converged(report);
        for (value, expected) in invariants(report).into_iter().zip(at_rest) {
            assert!(close(value, expected, 1e-9), "{report:?}");
        }
    }
}
