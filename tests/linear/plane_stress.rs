//! Sheets that nothing holds across their plane.

use std::f64::consts::PI;

use crate::common::meshes::{cook, mesh, moved, square, unit_grid};
use crate::common::refusals::violations;
use crate::common::scenes::{elastic, material, obstacle, probe, pull, push, support, traction};
use crate::common::{assert_converged, close, open, solve_one, values};
use signorini::scene::{Formulation, MaterialModel, Modulus, SceneKind, Shape};
use signorini::{FieldName, Scene, Step};

/// A sheet of Young's modulus one.
fn sheet(poisson_ratio: f64) -> Scene {
    Scene {
        kind: Some(SceneKind::PlaneStress),
        materials: vec![material(Modulus::Young(1.0), poisson_ratio)],
        ..elastic(poisson_ratio)
    }
}

#[test]
fn a_stretched_sheet_is_as_stiff_as_youngs_modulus_and_thins() {
    for ratio in [-0.3, 0.0, 0.3, 0.4999, 0.5] {
        let mut scene = sheet(ratio);
        scene.supports = vec![
            support("x0", [Some(0.0), None, None]),
            support("y0", [None, Some(0.0), None]),
            support("x1", [Some(0.0), None, None]),
        ];
        let step = pull("x1", [Some(1e-3), None, None], 1);
        let mut session = open(&scene, &mesh(square(3)));
        let report = crate::common::take(&mut session, &step).remove(0);
        assert_converged(&report);
        assert!(close(report.supports["x1"].force[0], 1e-3, 1e-7), "{ratio}");
        let volume = 1.0 + 1e-3 * (1.0 - 2.0 * ratio);
        assert!((report.volume_ratio - volume).abs() < 1e-9, "{ratio}");
        let stress = values(&session, FieldName::Stress);
        assert!(
            close(stress[0], 1e-3, 1e-6) && stress[2] == 0.0,
            "{stress:?}"
        );
        let jacobian = values(&session, FieldName::Jacobian);
        assert!((jacobian[0] - volume).abs() < 1e-9, "{ratio}");
    }
}

/// Bergan and Felippa, A triangular membrane element with rotational degrees of freedom, 1985: the
/// middle of the loaded side moves by 23.9 to 24.0.
#[test]
fn a_membrane_in_plane_stress_has_the_published_tip() {
    let mut scene = sheet(1.0 / 3.0);
    scene.supports = vec![support("x0", [Some(0.0), Some(0.0), None])];
    scene.tractions = vec![traction("x1", [0.0, 1.0 / 16.0, 0.0])];
    scene.probes = vec![probe("middle", [48.0, 52.0, 0.0])];
    let report = solve_one(&scene, &Step::default(), &mesh(cook(48)));
    let tip = report.probes["middle"].displacement[1];
    assert!(close(tip, 23.96, 2e-3), "{tip}");
}

/// Hertz with Young's modulus in the place of that of plane strain.
#[test]
fn a_sheet_under_a_disc_has_the_pressure_of_hertz() {
    for ratio in [0.3, 0.5] {
        let mut scene = sheet(ratio);
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        let disc = Shape::Cylinder {
            point: [0.0, 1.0, 0.0],
            axis: [0.0, 0.0, 1.0],
            radius: 1.0,
        };
        scene.obstacles = vec![obstacle("disc", "y1", disc)];
        // Finest where the disc touches.
        let graded = moved(unit_grid(120, 24), |[x, y, z]| {
            let (across, down) = (2.0 * x - 1.0, 1.0 - y);
            [2.0 * across * across.abs(), -2.0 * down * down, z]
        });
        let report = solve_one(&scene, &push("disc", [0.0, -0.02, 0.0]), &mesh(graded));
        assert_converged(&report);
        let disc = &report.obstacles["disc"];
        let expected = (-disc.force[1] / PI).sqrt();
        assert!(
            close(disc.max_pressure, expected, 2e-2),
            "{disc:?} {expected}"
        );
    }
}

#[test]
fn what_a_sheet_is_not_served_with_is_refused_by_key() {
    let mut scene = sheet(0.3);
    scene.supports = vec![support("x0", [Some(0.0), Some(0.0), None])];
    if let MaterialModel::LinearElastic { formulation, .. } = &mut scene.materials[0].model {
        *formulation = Formulation::Mixed;
    }
    let found = violations(&scene, &[], &mesh(square(2)));
    assert_eq!(found[0].path, "material.body.formulation", "{found:?}");
}
