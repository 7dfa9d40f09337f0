//! What results say of rubber: stresses, volumes and contact pressures of a block
//! that a plate squeezes evenly, and a support that travels.

use crate::common::meshes::{cube, mesh, square};
use crate::common::scenes::{HELD, elastic, obstacle, pull, push, support};
use crate::common::{assert_converged, difference, run, run_one, solve, values};
use signorini::report::WarningKind;
use signorini::scene::{Formulation, MaterialModel, RubberModel, Shape, SupportTarget};
use signorini::{Cause, FieldName, Scene, Step, StepReport, Termination};

fn neo_hookean() -> Scene {
    let mut scene = elastic(0.5);
    scene.materials[0].model = MaterialModel::Rubber {
        model: RubberModel::NeoHookean { shear_modulus: 1.0 },
        bulk_modulus: None,
        formulation: Formulation::Auto,
    };
    scene
}

/// Free to bulge, on three smooth planes under a smooth plate.
fn squeezed() -> (Scene, Step) {
    let mut scene = neo_hookean();
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("z0", [None, None, Some(0.0)]),
    ];
    let plate = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    scene.obstacles = vec![obstacle("plate", "z1", plate)];
    (scene, push("plate", [0.0, 0.0, -0.2]))
}

/// At stretch 0.8 of a neo-Hookean body of shear modulus one: 1 / l^2 - l per
/// undeformed and 1 / l - l^2 per deformed area.
const PRESSURE: f64 = 0.7625;
const DEFORMED: f64 = 0.61;

#[test]
fn an_even_squeeze_has_the_pressures_of_its_closed_form() {
    let (mut scene, step) = squeezed();
    // Pressure is known to some thirty times the tolerance.
    scene.solver.tolerance = 1e-10;
    let mesh = mesh(cube(2));
    let (session, report) = run_one(&scene, &step, &mesh);
    let plate = &report.obstacles["plate"];
    assert!((plate.max_pressure - DEFORMED).abs() < 1e-7, "{plate:?}");
    let undeformed = plate.max_pressure_undeformed.expect("finite strain");
    assert!((undeformed - PRESSURE).abs() < 1e-7, "{undeformed}");
    let deformed = plate.max_pressure_deformed.expect("finite strain");
    assert!((deformed - DEFORMED).abs() < 1e-7, "{deformed}");
    for (name, even) in [
        (FieldName::ContactPressure, DEFORMED),
        (FieldName::ContactPressureDeformed, DEFORMED),
        (FieldName::ContactPressureUndeformed, PRESSURE),
    ] {
        let field = values(&session, name);
        for (x, pressure) in mesh.coordinates().iter().zip(field) {
            let expected = if x[2] > 0.99 { even } else { 0.0 };
            assert!((pressure - expected).abs() < 1e-7, "{name:?}");
        }
    }
}

#[test]
fn an_even_squeeze_has_the_true_stress_and_keeps_the_volume_of_every_cell() {
    let (scene, step) = squeezed();
    let mesh = mesh(cube(2));
    let (session, report) = run_one(&scene, &step, &mesh);
    for stress in values(&session, FieldName::Stress).chunks_exact(6) {
        assert!(difference(stress, &[0.0, 0.0, -DEFORMED, 0.0, 0.0, 0.0]) < 1e-7);
    }
    for ratio in values(&session, FieldName::Jacobian) {
        assert!((ratio - 1.0).abs() < 1e-7, "{ratio}");
    }
    let least = report.min_jacobian.expect("finite strain");
    let bound = report.min_jacobian_bound.expect("finite strain");
    assert!((least - 1.0).abs() < 1e-7 && (bound - 1.0).abs() < 1e-7);
    assert!(bound <= least + 1e-14);
    assert!(session.field(FieldName::ErrorEstimate).is_none());
}

#[test]
fn a_linear_body_reports_nothing_of_finite_strain() {
    let (mut scene, step) = squeezed();
    scene.materials = elastic(0.5).materials;
    let (session, report) = run_one(&scene, &step, &mesh(cube(2)));
    assert_eq!(
        (report.min_jacobian, report.min_jacobian_bound),
        (None, None)
    );
    assert_eq!(report.stability, None);
    assert_eq!(report.obstacles["plate"].max_pressure_deformed, None);
    assert!(session.field(FieldName::ContactPressureDeformed).is_none());
}

#[test]
fn a_body_on_a_travelling_support_travels_with_it_without_strain() {
    let mut scene = neo_hookean();
    scene.supports = vec![support("x0", HELD)];
    let motion = |translation, about| Step {
        increments: 2,
        supports: vec![SupportTarget {
            name: "x0".to_owned(),
            translation: Some(translation),
            rotation: Some([0.0, 0.0, 1e-5]),
            about: Some(about),
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let steps = [
        motion([0.5, 0.0, 2.0], [0.0; 3]),
        motion([0.0, 3.0, 0.0], [0.0, 1.0, 0.0]),
    ];
    let mesh = mesh(cube(2));
    let (session, reports) = run(&scene, &steps, &mesh);
    reports.iter().for_each(assert_converged);
    assert!(reports[3].strain_energy.abs() < 1e-12);
    let displacement = values(&session, FieldName::Displacement);
    for (x, u) in mesh.coordinates().iter().zip(displacement.chunks_exact(3)) {
        let moved = [-1e-5 * (x[1] - 1.0), 3.0 + 1e-5 * x[0], 0.0];
        // The tolerance is relative to the travel of 3.
        assert!(difference(u, &moved) < 1e-7, "{u:?} {moved:?}");
    }
}

#[test]
fn a_body_on_a_turning_support_turns_with_it_without_strain() {
    let mut scene = neo_hookean();
    scene.supports = vec![support("x0", HELD)];
    let turn = Step {
        increments: 4,
        supports: vec![SupportTarget {
            name: "x0".to_owned(),
            translation: Some([0.5, 0.0, 0.0]),
            rotation: Some([0.0, 0.0, 1.0]),
            about: Some([0.0, 1.0, 0.0]),
            ..SupportTarget::default()
        }],
        ..Step::default()
    };
    let mesh = mesh(cube(2));
    let (session, reports) = run(&scene, &[turn], &mesh);
    reports.iter().for_each(assert_converged);
    let last = &reports[3];
    assert!(last.strain_energy.abs() < 1e-12, "{}", last.strain_energy);
    let displacement = values(&session, FieldName::Displacement);
    let (sine, cosine) = 1.0_f64.sin_cos();
    for (x, u) in mesh.coordinates().iter().zip(displacement.chunks_exact(3)) {
        let arm = [x[0], x[1] - 1.0];
        let turned = [
            cosine * arm[0] - sine * arm[1] + 0.5,
            sine * arm[0] + cosine * arm[1] + 1.0,
            x[2],
        ];
        let moved: Vec<f64> = x.iter().zip(u).map(|(x, u)| x + u).collect();
        assert!(difference(&moved, &turned) < 1e-6, "{moved:?} {turned:?}");
    }
}

#[test]
fn a_cell_inside_out_is_no_result() {
    // Beyond half the height cells beside the free sides turn, though det F stays above zero at
    // the points of the rule and all residuals are met.
    let mut scene = neo_hookean();
    if let MaterialModel::Rubber { bulk_modulus, .. } = &mut scene.materials[0].model {
        *bulk_modulus = Some(50.0);
    }
    let held = [Some(0.0), Some(0.0), None];
    scene.supports = vec![support("y0", held), support("y1", held)];
    let pressed = pull("y1", [Some(0.0), Some(-0.6), None], 8);
    let reports = solve(&scene, &[pressed], &mesh(square(2)));
    let (last, before) = reports.split_last().expect("increments");
    before.iter().for_each(assert_converged);
    let end = (last.termination, last.cause);
    assert_eq!(end, (Termination::NotConverged, Some(Cause::InsideOut)));
    assert!((0.5..1.0).contains(&last.time), "{}", last.time);
    let site = last.cause_site.as_ref().and_then(|site| site.point);
    assert!(site.is_some() && last.cut_backs > 0);
}

#[test]
fn volume_that_an_incompressible_body_loses_at_a_point_is_said() {
    let mut scene = neo_hookean();
    let held = [Some(0.0), Some(0.0), None];
    scene.supports = vec![support("y0", held), support("y1", held)];
    let pressed = pull("y1", [Some(0.0), Some(-0.4), None], 8);
    let reports = solve(&scene, &[pressed], &mesh(square(2)));
    let is_said = |report: &StepReport| {
        let mut kinds = report.warnings.iter().map(|warning| warning.kind);
        kinds.any(|kind| kind == WarningKind::CoarseVolume)
    };
    for report in &reports {
        assert_converged(report);
        let least = report.min_jacobian.expect("a rubber");
        assert_eq!(is_said(report), least < 0.7, "{least}");
    }
    assert!(!is_said(&reports[0]) && reports.last().is_some_and(is_said));
}
