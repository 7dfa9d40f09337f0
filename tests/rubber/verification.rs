//! Rubber under the eyes of the independent path: plain formulas from F and J on
//! Lagrange nodes find the equilibrium and the volume that the solver reports.

use std::sync::Arc;

use crate::common::{meshes, scenes};
use signorini::scene::{Formulation, Material, MaterialModel, RubberModel, Shape};
use signorini::{Mesh, Scene, StepReport};

fn rubber(model: RubberModel, bulk_modulus: Option<f64>) -> Scene {
    let mut scene = scenes::elastic(0.5);
    scene.materials = vec![Material {
        group: "body".to_owned(),
        model: MaterialModel::Rubber {
            model,
            bulk_modulus,
            formulation: Formulation::Auto,
        },
    }];
    scene
}

fn laws() -> [RubberModel; 8] {
    [
        RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 },
        RubberModel::NeoHookean { shear_modulus: 1.0 },
        RubberModel::Yeoh {
            c10: 0.5,
            c20: 0.1,
            c30: 0.05,
        },
        RubberModel::Ogden {
            mu: vec![0.63, 0.0012, -0.01],
            alpha: vec![1.3, 5.0, -2.0],
        },
        RubberModel::Polynomial {
            coefficients: [0.4, 0.1, 0.03, 0.02, 0.01, 0.004, 0.003, 0.002, 0.001],
        },
        RubberModel::Gent {
            shear_modulus: 1.1,
            limit: 3.0,
        },
        RubberModel::ArrudaBoyce {
            mu: 0.9,
            locking_stretch: 1.5,
        },
        RubberModel::VanDerWaals {
            shear_modulus: 0.9,
            locking_stretch: 2.2,
            a: 0.2,
            beta: 0.3,
        },
    ]
}

fn foams() -> [RubberModel; 3] {
    let foam = |nu: f64| RubberModel::Hyperfoam {
        mu: vec![0.6, 0.3],
        alpha: vec![8.0, -2.0],
        nu: vec![nu],
    };
    let blatz_ko = RubberModel::BlatzKo { shear_modulus: 0.9 };
    [foam(0.0), foam(0.4), blatz_ko]
}

/// Converged and verified: [`crate::common::solve`] fails where the paths disagree.
fn converged(scene: &Scene, mesh: &Arc<Mesh>) -> StepReport {
    let report = crate::common::solve(scene, &[], mesh).remove(0);
    crate::common::assert_converged(&report);
    assert!(report.verification.is_some());
    report
}

#[test]
fn solids_and_plane_bodies_of_every_law_agree_with_the_textbook_under_load() {
    let rubbers = laws().into_iter().flat_map(|model| {
        let own = [None, Some(20.0)];
        own.map(|bulk_modulus| (model.clone(), bulk_modulus))
    });
    let foams = foams().map(|model| (model, None));
    for (model, bulk_modulus) in rubbers.chain(foams) {
        for (mesh, value) in [
            (meshes::cube(2), [0.1, 0.05, 0.2]),
            (meshes::square(3), [0.1, 0.2, 0.0]),
        ] {
            let mesh = meshes::mesh(mesh);
            let mut scene = rubber(model.clone(), bulk_modulus);
            scene.supports = vec![scenes::support("x0", scenes::HELD)];
            scene.tractions = vec![scenes::traction("x1", value.map(|t| 0.5 * t))];
            scene.body_force = [0.0, -0.05, 0.0];
            converged(&scene, &mesh);
        }
    }
}

#[test]
fn the_rule_that_a_scene_asks_for_is_the_rule_of_both_paths() {
    for degree in [2, 5, 8] {
        let mesh = meshes::mesh(meshes::cube(2));
        let mut scene = rubber(laws()[0].clone(), None);
        scene.supports = vec![scenes::support("x0", scenes::HELD)];
        scene.tractions = vec![scenes::traction("x1", [0.0, 0.1, 0.2])];
        scene.solver.quadrature_degree = Some(degree);
        converged(&scene, &mesh);
    }
}

#[test]
fn contact_of_rubber_agrees_too() {
    let mesh = meshes::mesh(meshes::cube(3));
    let mut scene = rubber(laws()[0].clone(), None);
    scene.supports = vec![scenes::support("z0", scenes::HELD)];
    let press = Shape::HalfSpace {
        point: [0.0, 0.0, 1.0],
        normal: [0.0, 0.0, -1.0],
    };
    scene.obstacles = vec![scenes::obstacle("press", "z1", press)];
    let step = scenes::push("press", [0.0, 0.0, -0.1]);
    let (_, report) = crate::common::run_one(&scene, &step, &mesh);
    assert!(report.verification.is_some());
    // All nodes of the top.
    assert!(report.active_vertices == 49);
}
