//! Sheets of rubber that nothing holds across their plane: closed forms of the textbooks' tests,
//! balance, a notch, a tool.

use std::sync::Arc;

use crate::common::meshes::{irregular, mesh, moved, square, unit_grid};
use crate::common::refusals::unsupported;
use crate::common::scenes::{material, obstacle, probe, pull, push, rubber, support, traction};
use crate::common::{assert_converged, close, open, solve, solve_one, take, values};
use signorini::scene::{Modulus, Pressure, RubberModel, SceneKind, Shape};
use signorini::{FieldName, Mesh, Plan, Scene, Step, StepReport};

fn sheet(model: RubberModel, bulk_modulus: Option<f64>) -> Scene {
    let mut scene = rubber(model, bulk_modulus);
    scene.kind = Some(SceneKind::PlaneStress);
    scene.solver.verify = true;
    scene.solver.tolerance = 1e-10;
    scene
}

fn unit_sheet() -> Arc<Mesh> {
    mesh(irregular(square(3), 3))
}

/// What the last increment of `step` reports.
fn last(scene: &Scene, step: Step) -> StepReport {
    let mut reports = solve(scene, &[step], &unit_sheet());
    reports.pop().expect("a report")
}

/// Rollers on two sides, the third one led.
fn pulled(mut scene: Scene) -> Scene {
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("x1", [Some(0.0), None, None]),
    ];
    scene.probes = vec![probe("corner", [1.0, 1.0, 0.0])];
    scene
}

/// A law and its nominal stress at a stretch.
type Uniaxial = (RubberModel, fn(f64) -> f64);

fn laws() -> [Uniaxial; 3] {
    let ogden = RubberModel::Ogden {
        mu: vec![0.5],
        alpha: vec![4.0],
    };
    [
        // Nominal stress of a stretch where the sides are free: Holzapfel 6.2.
        (RubberModel::NeoHookean { shear_modulus: 1.0 }, |l| {
            l - l.powi(-2)
        }),
        (RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 }, |l| {
            2.0 * (l - l.powi(-2)) * (0.4 + 0.1 / l)
        }),
        (ogden, |l| 0.5 * (l.powi(3) - l.powi(-3))),
    ]
}

#[test]
fn a_pulled_sheet_is_a_uniaxial_test() {
    for (model, stress) in laws() {
        for travel in [0.8, -0.4] {
            let scene = pulled(sheet(model.clone(), None));
            let mut session = open(&scene, &unit_sheet());
            let report = take(&mut session, &pull("x1", [Some(travel), None, None], 4))
                .pop()
                .expect("a report");
            assert_converged(&report);
            let stretch = 1.0_f64 + travel;
            let force = report.supports["x1"].force[0];
            assert!(close(force, stress(stretch), 1e-8), "{model:?} {force}");
            let across = 1.0 + report.probes["corner"].displacement[1];
            assert!((across - stretch.powf(-0.5)).abs() < 1e-8, "{model:?}");
            assert!((report.volume_ratio - 1.0).abs() < 1e-12);
            let true_stress = values(&session, FieldName::Stress);
            let expected = stretch * stress(stretch);
            assert!(close(true_stress[0], expected, 1e-7), "{true_stress:?}");
            assert!(true_stress[1].abs() < 1e-7 && true_stress[2] == 0.0);
        }
    }
}

/// l - l^-5 of a neo-Hookean law in both directions.
#[test]
fn a_sheet_pulled_along_both_sides_is_an_equibiaxial_test() {
    let mut scene = pulled(sheet(RubberModel::NeoHookean { shear_modulus: 1.0 }, None));
    scene.supports.push(support("y1", [None, Some(0.0), None]));
    let mut step = pull("x1", [Some(0.3), None, None], 3);
    step.supports
        .extend(pull("y1", [None, Some(0.3), None], 3).supports);
    let report = last(&scene, step);
    let expected = 1.3 - 1.3_f64.powi(-5);
    for (name, axis) in [("x1", 0), ("y1", 1)] {
        let force = report.supports[name].force[axis];
        assert!(close(force, expected, 1e-8), "{name} {force} {expected}");
    }
}

/// With W = mu/2 (i1 - 3) + K/2 (J - 1)^2 and lateral stretches alike, found by their own equation
/// mu/3 J^(-5/3) (m^2 - l^2) + K (J - 1) = 0, J = l m^2; the force is -2 of it times m^2 / l.
#[test]
fn a_compressible_sheet_thins_as_a_rod_does() {
    let (stretch, bulk): (f64, f64) = (1.5, 2.0);
    let defect = |m: f64| {
        let volume = stretch * m * m;
        volume.powf(-5.0 / 3.0) * (m * m - stretch * stretch) / 3.0 + bulk * (volume - 1.0)
    };
    let (mut least, mut most) = (0.5, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        if defect(middle) < 0.0 {
            least = middle;
        } else {
            most = middle;
        }
    }
    let volume = stretch * least * least;
    let along = 2.0 / 3.0 * volume.powf(-5.0 / 3.0) * (stretch * stretch - least * least);
    let expected = (along + bulk * (volume - 1.0)) * least * least;
    let model = RubberModel::NeoHookean { shear_modulus: 1.0 };
    let scene = pulled(sheet(model, Some(bulk)));
    let report = last(&scene, pull("x1", [Some(0.5), None, None], 2));
    let force = report.supports["x1"].force[0];
    assert!(close(force, expected, 1e-8), "{force} {expected}");
    assert!(close(report.volume_ratio, volume, 1e-8));
}

/// Against plane strain, whose sheet cannot thin: softer; and with steel beside rubber.
#[test]
fn a_tool_and_a_dead_load_meet_a_sheet_in_balance() {
    let mut scene = sheet(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
    scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
    scene.tractions = vec![traction("x1", [0.02, 0.0, 0.0])];
    let disc = Shape::Cylinder {
        point: [0.0, 1.5, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 0.5,
    };
    scene.obstacles = vec![obstacle("disc", "y1", disc)];
    let wide = moved(unit_grid(16, 8), |[x, y, z]| [2.0 * x - 1.0, y, z]);
    let wide = mesh(wide);
    let step = push("disc", [0.0, -0.3, 0.0]);
    let report = solve_one(&scene, &step, &wide);
    assert_converged(&report);
    let (disc, floor) = (&report.obstacles["disc"], &report.supports["y0"]);
    assert!((disc.force[1] + floor.force[1]).abs() < 1e-7, "{disc:?}");
    assert!(
        (disc.force[0] + floor.force[0] + 0.02).abs() < 1e-7,
        "{disc:?}"
    );
    scene.kind = Some(SceneKind::PlaneStrain);
    let held = solve_one(&scene, &step, &wide);
    let ratio = held.obstacles["disc"].force[1] / disc.force[1];
    assert!(ratio > 1.2 && ratio < 3.0, "{ratio}");
}

#[test]
fn a_sheet_of_small_strain_is_one_of_linear_elasticity() {
    let step = push("disc", [0.0, -1e-4, 0.0]);
    let disc = Shape::Cylinder {
        point: [0.0, 2.0, 0.0],
        axis: [0.0, 0.0, 1.0],
        radius: 1.0,
    };
    let mut forces = Vec::new();
    for is_rubber in [false, true] {
        let mut scene = sheet(RubberModel::NeoHookean { shear_modulus: 1.0 }, None);
        if !is_rubber {
            scene.materials = vec![material(Modulus::Shear(1.0), 0.5)];
        }
        scene.supports = vec![support("y0", [Some(0.0), Some(0.0), None])];
        scene.obstacles = vec![obstacle("disc", "y1", disc.clone())];
        let report = solve_one(&scene, &step, &unit_sheet());
        forces.push(report.obstacles["disc"].force[1]);
    }
    assert!(close(forces[0], forces[1], 1e-3), "{forces:?}");
}

#[test]
fn a_pressure_that_follows_a_sheet_is_refused() {
    let mut scene = pulled(sheet(RubberModel::NeoHookean { shear_modulus: 1.0 }, None));
    let on = vec!["y1".to_owned()];
    scene.pressures = vec![Pressure { on, value: 0.1 }];
    let found = unsupported(&scene, &unit_sheet());
    assert!(
        found.path == "pressure[0]" && found.message.contains("sheet"),
        "{found:?}"
    );
}

#[test]
fn a_plan_of_a_sheet_names_what_is_per_thickness_and_the_bulk_modulus_of_the_body() {
    let mut scene = sheet(RubberModel::NeoHookean { shear_modulus: 1.0 }, Some(7.0));
    scene = pulled(scene);
    let plan = Plan::new(&scene, &[], &unit_sheet()).expect("a plan");
    let report = plan.report();
    let choice = |what: &str| {
        let mut all = report.decisions.iter().filter(|entry| entry.what == what);
        all.next().map(|entry| entry.choice.clone())
    };
    assert!(choice("measure").expect("a sheet").contains("thickness"));
    assert_eq!(
        choice("material").as_deref(),
        Some("neo-hookean, bulk modulus 7")
    );
}
