//! Faults of scenes of rubber, each refused with the path of its key; and what
//! only rubber can bear, refused without it.

mod laws;

use crate::common::meshes::{cube, mesh, square};
use crate::common::refusals::{block, unsupported, violations};
use crate::common::scenes::{HELD, cube_bend, obstacle, support};
use signorini::scene::{
    Choice, ContactMethod, DisplacementMethod, Formulation, MaterialModel, Pressure, Profile,
    RubberModel, SaddleMethod, SceneKind, Shape, SupportTarget, ToleranceRule,
};
use signorini::{Plan, PlanReport, Scene, SceneError, Step};

/// The bent cube of a law.
fn rubber(model: RubberModel, bulk_modulus: Option<f64>) -> Scene {
    let mut scene = cube_bend(0.5);
    scene.materials[0].model = MaterialModel::Rubber {
        model,
        bulk_modulus,
        formulation: Formulation::Auto,
    };
    scene
}

fn mooney_rivlin(c10: f64, c01: f64) -> Scene {
    rubber(RubberModel::MooneyRivlin { c10, c01 }, None)
}

fn yeoh(c10: f64, c20: f64, c30: f64) -> Scene {
    rubber(RubberModel::Yeoh { c10, c20, c30 }, None)
}

fn ogden(mu: &[f64], alpha: &[f64]) -> Scene {
    let (mu, alpha) = (mu.to_vec(), alpha.to_vec());
    rubber(RubberModel::Ogden { mu, alpha }, None)
}

fn polynomial(change: impl FnOnce(&mut [f64; 9])) -> Scene {
    let mut coefficients = [0.0; 9];
    coefficients[0] = 0.4;
    change(&mut coefficients);
    rubber(RubberModel::Polynomial { coefficients }, None)
}

fn gent(shear_modulus: f64, limit: f64) -> Scene {
    let law = RubberModel::Gent {
        shear_modulus,
        limit,
    };
    rubber(law, None)
}

fn arruda_boyce(mu: f64, locking_stretch: f64) -> Scene {
    let law = RubberModel::ArrudaBoyce {
        mu,
        locking_stretch,
    };
    rubber(law, None)
}

/// One fault, on `path`, whose message has `word`.
fn assert_refused(scene: &Scene, path: &str, word: &str) {
    let found = violations(scene, &[], &block());
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].path, path);
    assert!(found[0].message.contains(word), "{}", found[0]);
}

fn assert_planned(scene: &Scene) -> PlanReport {
    match Plan::new(scene, &[], &block()) {
        Ok(plan) => plan.report(),
        Err(error) => panic!("{error}"),
    }
}

fn assert_unsupported(scene: &Scene, path: &str, word: &str) {
    let found = unsupported(scene, &block());
    assert_eq!(found.path, path);
    assert!(found.message.contains(word), "{found}");
}

#[test]
fn the_shear_modulus_at_rest_is_above_zero() {
    let rest = "shear modulus at rest";
    assert_refused(&mooney_rivlin(0.2, -0.2), "material.body.c10", rest);
    assert_refused(
        &mooney_rivlin(f64::MAX, f64::MAX),
        "material.body.c10",
        rest,
    );
    assert_refused(&yeoh(-1.0, 1.0, 1.0), "material.body.c10", rest);
    assert_refused(&ogden(&[1.0, 2.0], &[2.0, -2.0]), "material.body.mu", rest);
    let opposed = polynomial(|c| c[1] = -0.4);
    assert_refused(&opposed, "material.body.c10", rest);
    let path = "material.body.shear_modulus";
    assert_refused(&gent(0.0, 30.0), path, "above zero");
    assert_refused(&arruda_boyce(-1.0, 3.0), "material.body.mu", "above zero");
    let soft = RubberModel::NeoHookean { shear_modulus: 0.0 };
    assert_refused(&rubber(soft, None), path, "above zero");
}

#[test]
fn a_negative_second_coefficient_is_no_fault_while_the_sum_is_above_zero() {
    assert_planned(&mooney_rivlin(0.5, -0.1));
}

#[test]
fn coefficients_are_finite() {
    let nan = f64::NAN;
    let infinite = f64::INFINITY;
    for (scene, key) in [
        (mooney_rivlin(nan, 0.1), "c10"),
        (mooney_rivlin(0.1, nan), "c01"),
        (yeoh(0.1, infinite, 0.0), "c20"),
        (yeoh(0.1, 0.0, nan), "c30"),
        (polynomial(|c| c[3] = nan), "c11"),
        (polynomial(|c| c[8] = infinite), "c03"),
        (ogden(&[nan], &[2.0]), "mu"),
        (ogden(&[1.0], &[nan]), "alpha"),
    ] {
        let path = format!("material.body.{key}");
        assert_refused(&scene, &path, "must be finite");
    }
}

#[test]
fn chains_have_a_length() {
    let path = "material.body.limit";
    for limit in [0.0, -1.0, 1e-4, f64::NAN, f64::INFINITY] {
        assert_refused(&gent(1.0, limit), path, "at least 0.001");
    }
    let path = "material.body.locking_stretch";
    for stretch in [1.0, 0.0, -2.0, f64::NAN, f64::INFINITY] {
        assert_refused(&arruda_boyce(1.0, stretch), path, "above one");
    }
}

#[test]
fn terms_of_ogden_come_in_pairs_and_are_three_at_most() {
    let path = "material.body.mu";
    assert_refused(&ogden(&[1.0; 4], &[2.0; 4]), path, "1 to 3 terms, not 4");
    assert_refused(
        &ogden(&[1.0; 2], &[2.0]),
        "material.body.alpha",
        "2 exponents",
    );
    assert_refused(
        &ogden(&[1.0; 2], &[2.0, 0.0]),
        "material.body.alpha",
        "must not be zero",
    );
}

#[test]
fn a_bulk_modulus_is_above_zero_or_infinite() {
    let law = || RubberModel::NeoHookean { shear_modulus: 1.0 };
    for bulk_modulus in [0.0, -1.0, f64::NAN, 1e-310] {
        let scene = rubber(law(), Some(bulk_modulus));
        assert_refused(&scene, "material.body.bulk_modulus", "above zero");
    }
    let soft = rubber(law(), Some(0.6));
    let path = "material.body.bulk_modulus";
    assert_unsupported(&soft, path, "two thirds of the shear modulus");
    let infinite = rubber(law(), Some(f64::INFINITY));
    assert_planned(&infinite);
}

#[test]
fn rubber_is_always_mixed() {
    let mut scene = mooney_rivlin(0.4, 0.1);
    let MaterialModel::Rubber {
        formulation,
        bulk_modulus,
        ..
    } = &mut scene.materials[0].model
    else {
        unreachable!("the cube is rubber");
    };
    (*formulation, *bulk_modulus) = (Formulation::Displacement, Some(1.0));
    assert_refused(
        &scene,
        "material.body.formulation",
        "rubber needs the mixed",
    );
}

#[test]
fn methods_that_do_not_serve_rubber_are_refused_by_name() {
    type Change = fn(&mut Scene);
    let cases: [(&str, &str, Change); 5] = [
        ("solver.saddle", "minres", |scene| {
            scene.solver.saddle = Choice::Named(SaddleMethod::Minres)
        }),
        ("solver.contact", "mprgp", |scene| {
            scene.solver.contact = Choice::Named(ContactMethod::Mprgp)
        }),
        (
            "solver.displacement_preconditioner",
            "hierarchical-ssor",
            |scene| {
                scene.solver.displacement_preconditioner =
                    Choice::Named(DisplacementMethod::HierarchicalSsor);
            },
        ),
        ("solver.tolerance", "discretisation", |scene| {
            scene.solver.tolerance_rule = ToleranceRule::Discretisation;
        }),
        ("manufactured.field", "linear", |scene| {
            scene.tractions.clear();
            scene.manufactured = Some("A1m".into());
        }),
    ];
    for (path, word, change) in cases {
        let mut scene = mooney_rivlin(0.4, 0.1);
        scene.solver.verify = false;
        change(&mut scene);
        assert_unsupported(&scene, path, word);
    }
}

#[test]
fn the_volume_rule_of_rubber_has_degree_two_to_twelve() {
    for degree in [1, 13] {
        let mut scene = mooney_rivlin(0.4, 0.1);
        scene.solver.quadrature_degree = Some(degree);
        let path = "solver.quadrature_degree";
        assert_refused(&scene, path, "between 2 and 12 for rubber");
    }
}

#[test]
fn a_follower_pressure_acts_on_the_surface_of_rubber() {
    let pressure = |on: &str, value| {
        let on = vec![on.to_owned()];
        vec![Pressure { on, value }]
    };
    let mut scene = cube_bend(0.5);
    scene.pressures = pressure("z1", 1.0);
    assert_unsupported(&scene, "pressure[0]", "without rubber");
    let mut scene = mooney_rivlin(0.4, 0.1);
    scene.pressures = pressure("z1", 1.0);
    assert!(Plan::new(&scene, &[], &mesh(cube(1))).is_ok());
    scene.pressures = pressure("top", 1.0);
    assert_refused(&scene, "pressure[0].on", "no group of surface facets");
    scene.pressures = pressure("z1", f64::NAN);
    assert_refused(&scene, "pressure[0].value", "must be finite");
}

#[test]
fn an_axisymmetric_body_is_made_of_triangles_right_of_its_axis() {
    let mut scene = mooney_rivlin(0.4, 0.1);
    scene.kind = Some(SceneKind::Axisymmetric);
    assert_refused(&scene, "kind", "does not fit the mesh");
    let mut plane = cube_bend(0.5);
    plane.kind = Some(SceneKind::Axisymmetric);
    plane.tractions.clear();
    plane.probes.clear();
    plane.supports = vec![support("y0", [None, Some(0.0), None])];
    let mut parts = square(2);
    parts.coordinates.iter_mut().for_each(|x| x[0] -= 0.5);
    match Plan::new(&plane, &[], &mesh(parts)) {
        Err(SceneError::Invalid(all)) => {
            assert_eq!(all[0].path, "kind");
            assert!(all[0].message.contains("x >= 0"), "{}", all[0]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn rubber_that_touches_an_obstacle_is_planned_with_its_law() {
    let mut scene = rubber(RubberModel::NeoHookean { shear_modulus: 1.0 }, Some(50.0));
    scene.tractions.clear();
    scene.supports = vec![support("z0", HELD)];
    let shape = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    scene.obstacles = vec![obstacle("lid", "z1", shape)];
    scene.solver.quadrature_degree = Some(5);
    let report = assert_planned(&scene);
    let choice = |what: &str| {
        let mut entries = report.decisions.iter();
        let entry = entries.find(|entry| entry.what == what).expect(what);
        entry.choice.clone()
    };
    assert_eq!(choice("material"), "neo-hookean, bulk modulus 50");
    assert_eq!(choice("volume rule"), "degree 5");
    let left_out = |what: &str| {
        report
            .left_out
            .iter()
            .any(|entry| entry.what.contains(what))
    };
    assert!(!left_out("refactorisation"));
}

#[test]
fn a_linear_scene_pays_for_nothing_of_rubber() {
    let report = assert_planned(&cube_bend(0.5));
    let left_out = |what: &str| {
        report
            .left_out
            .iter()
            .any(|entry| entry.what.contains(what))
    };
    assert!(left_out("refactorisation"));
    let names = report.decisions.iter().map(|entry| entry.what.as_str());
    for what in ["material", "volume rule", "tangent"] {
        assert!(!names.clone().any(|name| name == what), "{what}");
    }
}

fn moved(target: SupportTarget) -> [Step; 1] {
    let target = SupportTarget {
        name: "x0".to_owned(),
        ..target
    };
    [Step {
        supports: vec![target],
        ..Step::default()
    }]
}

fn turned(rotation: [f64; 3]) -> [Step; 1] {
    moved(SupportTarget {
        rotation: Some(rotation),
        ..SupportTarget::default()
    })
}

fn shifted(translation: [f64; 3]) -> [Step; 1] {
    moved(SupportTarget {
        translation: Some(translation),
        ..SupportTarget::default()
    })
}

#[test]
fn a_linear_body_takes_no_large_rotation_of_a_support() {
    let block = mesh(cube(2));
    match Plan::new(&cube_bend(0.5), &turned([0.0, 0.0, 7.0]), &block) {
        Err(SceneError::Unsupported(one)) => {
            assert_eq!(one.path, "step[0].support.x0.rotation");
            assert!(one.message.contains("not rubber"), "{one}");
        }
        other => panic!("{other:?}"),
    }
    assert!(Plan::new(&cube_bend(0.5), &turned([0.0; 3]), &block).is_ok());
}

#[test]
fn motions_of_supports_are_finite_and_held() {
    let mut scene = mooney_rivlin(0.4, 0.1);
    scene.supports[0].displacement[1] = None;
    scene.supports.push(support("y0", HELD));
    let block = mesh(cube(2));
    let refused = |scene: &Scene, step: &[Step], key: &str, word: &str| {
        let Err(SceneError::Invalid(all)) = Plan::new(scene, step, &block) else {
            panic!("{key} is faulty");
        };
        assert_eq!(all[0].path, format!("step[0].support.x0{key}"));
        assert!(all[0].message.contains(word), "{}", all[0]);
    };
    let nan = f64::NAN;
    refused(&scene, &turned([nan, 0.0, 0.0]), ".rotation", "finite");
    refused(&scene, &shifted([nan, 0.0, 0.0]), ".translation", "finite");
    refused(
        &scene,
        &shifted([0.0, 1.0, 0.0]),
        ".translation",
        "hold the y",
    );
    let about = moved(SupportTarget {
        about: Some([0.0, 0.0, nan]),
        ..SupportTarget::default()
    });
    refused(&scene, &about, ".about", "finite");
    let both = moved(SupportTarget {
        displacement: [Some(1.0), None, None],
        translation: Some([1.0, 0.0, 0.0]),
        ..SupportTarget::default()
    });
    refused(&scene, &both, "", "not both");
    scene.supports[0].profile = Profile::Parabolic;
    refused(&scene, &shifted([1.0, 0.0, 0.0]), "", "profile");
}

#[test]
fn motions_of_supports_stay_in_the_plane() {
    let mut scene = mooney_rivlin(0.4, 0.1);
    (scene.tractions, scene.probes) = (Vec::new(), Vec::new());
    scene.supports = vec![support("x0", [Some(0.0), Some(0.0), None])];
    let square = mesh(square(2));
    let paths = |scene: &Scene, step: &[Step]| match Plan::new(scene, step, &square) {
        Err(SceneError::Invalid(all)) => all.into_iter().map(|one| one.path).collect(),
        Err(SceneError::Unsupported(one)) => vec![one.path],
        Ok(_) => Vec::new(),
    };
    let rotation = "step[0].support.x0.rotation";
    assert_eq!(paths(&scene, &turned([1.0, 0.0, 0.0])), [rotation]);
    let found = paths(&scene, &shifted([0.0, 0.0, 1.0]));
    assert_eq!(found[0], "step[0].support.x0.translation");
    assert_eq!(paths(&scene, &turned([0.0, 0.0, 20.0])), [""; 0]);
    scene.kind = Some(SceneKind::Axisymmetric);
    assert_eq!(paths(&scene, &turned([0.0, 0.0, 1.0])), [rotation]);
}
