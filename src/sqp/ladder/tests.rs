//! Every rung by itself, on bodies that the plan's own method solves too.

use std::sync::Arc;

use crate::linalg::vector::norm;
use crate::mesh::{Mesh, samples};
use crate::plan::Plan;
use crate::report::{CancelToken, Fallback, FieldName, Silent, StepReport, Termination};
use crate::scene::{
    Formulation, Material, MaterialModel, Modulus, Obstacle, ObstacleTarget, Profile, RubberModel,
    Scene, Shape, Step, Support,
};
use crate::session::{Reuse, Session};
use crate::{Prepared, scene::SolverOptions};

/// A block on its base under a ball.
fn block(model: MaterialModel) -> Scene {
    Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model,
        }],
        supports: vec![Support {
            name: "base".to_owned(),
            on: vec!["z0".to_owned()],
            normal: None,
            displacement: [Some(0.0); 3],
            profile: Profile::Constant,
            values: None,
        }],
        obstacles: vec![Obstacle {
            name: "ball".to_owned(),
            on: vec!["z1".to_owned()],
            shape: Shape::Sphere {
                centre: [0.45, 0.55, 2.0],
                radius: 1.0,
            },
            surface: crate::scene::SurfaceGeometry::default(),
            friction: 0.0,
            tresca: None,
            initial_penetration: crate::scene::PenetrationPolicy::default(),
        }],
        solver: SolverOptions {
            tolerance: 1e-10,
            ..SolverOptions::default()
        },
        ..Scene::default()
    }
}

fn elastic(poisson_ratio: f64) -> MaterialModel {
    MaterialModel::LinearElastic {
        modulus: Modulus::Shear(1.0),
        poisson_ratio,
        formulation: Formulation::Auto,
    }
}

fn press() -> Step {
    Step {
        obstacles: vec![ObstacleTarget {
            name: "ball".to_owned(),
            translation: Some([0.0, 0.0, -0.05]),
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    }
}

/// Displacement and report of the pressed block by that plan.
fn solved(plan: Plan, mesh: &Arc<Mesh>) -> (Vec<f64>, StepReport) {
    let plan = Arc::new(plan);
    let prepared = Prepared::build(&plan, mesh, &CancelToken::new()).expect("a solvable scene");
    let mut session = Session::new(plan, mesh.clone(), Arc::new(prepared), Reuse::Built);
    let mut run = session.begin_step(&press()).expect("a valid step");
    let report = session.advance(&mut run, &mut Silent, &CancelToken::new());
    let field = session.field(FieldName::Displacement).expect("a field");
    (field.values, report.expect("an increment"))
}

/// Fails unless the block is where the plan's own method brings it, on that rung.
fn assert_alike(model: MaterialModel, rung: Fallback) {
    let mesh = Arc::new(samples::cube(3));
    let plan = Plan::new(&block(model), &[], &mesh).expect("a valid scene");
    let (exact, own) = solved(plan.clone(), &mesh);
    let (found, report) = solved(plan.on_rung(rung), &mesh);
    assert_eq!(own.termination, Termination::Converged);
    assert_eq!(report.termination, Termination::Converged, "{rung:?}");
    assert_eq!(report.active_vertices, own.active_vertices);
    let difference: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| a - b).collect();
    assert!(norm(&difference) < 1e-7 * norm(&exact), "{rung:?}");
}

#[test]
fn every_rung_brings_a_linear_block_where_the_plan_does() {
    for rung in Fallback::ALL {
        for poisson_ratio in [0.3, 0.49, 0.5] {
            assert_alike(elastic(poisson_ratio), rung);
        }
    }
}

#[test]
fn the_factor_brings_rubber_where_the_plan_does() {
    for bulk_modulus in [None, Some(50.0)] {
        let rubber = MaterialModel::Rubber {
            model: RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 },
            bulk_modulus,
            formulation: Formulation::Auto,
        };
        assert_alike(rubber, Fallback::Direct);
    }
}

#[test]
fn rubber_and_bodies_without_contact_have_the_factor_alone() {
    let mesh = samples::cube(3);
    let rubber = MaterialModel::Rubber {
        model: RubberModel::MooneyRivlin { c10: 0.4, c01: 0.1 },
        bulk_modulus: None,
        formulation: Formulation::Auto,
    };
    let free = Scene {
        obstacles: Vec::new(),
        ..block(elastic(0.5))
    };
    for scene in [block(rubber), free] {
        let plan = Plan::new(&scene, &[], &mesh).expect("a valid scene");
        assert_eq!(plan.rungs(), [Fallback::Direct]);
    }
    let plan = Plan::new(&block(elastic(0.5)), &[], &mesh).expect("a valid scene");
    assert_eq!(plan.rungs(), Fallback::ALL);
}
