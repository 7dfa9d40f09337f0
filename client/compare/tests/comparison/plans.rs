//! Plans of scenes that name methods to compare with.

use crate::common::meshes::{cube, mesh};
use crate::common::scenes::cube_bend;
use crate::harness::{plan, prepared};
use signorini::scene::{Choice, DisplacementMethod, P1Solver};
use signorini::{Plan, SceneError};

#[test]
fn predicted_bytes_bound_the_prepared_data() {
    let mut scene = cube_bend(0.5);
    scene.solver.displacement_preconditioner = Choice::Named(DisplacementMethod::HierarchicalSsor);
    scene.solver.p1_solver = Choice::Named(P1Solver::IcCg);
    let mesh = mesh(cube(8));
    let plan = plan(&scene, &mesh).expect("a valid scene");
    let predicted = plan.report().predicted_bytes;
    let held = prepared(&plan, &mesh).bytes();
    assert!(
        held < predicted && predicted < 20 * held,
        "{held} {predicted}"
    );
}

#[test]
fn names_are_refused_where_no_methods_are_brought_along() {
    for (key, name) in [
        ("displacement_preconditioner", "hierarchical-ssor"),
        ("p1_solver", "ic-cg"),
        ("saddle", "minres"),
        ("contact", "nested"),
    ] {
        let mut scene = cube_bend(0.5);
        let solver = &mut scene.solver;
        match key {
            "p1_solver" => solver.p1_solver = name.parse().expect("a solver"),
            "saddle" => solver.saddle = name.parse().expect("a method"),
            "contact" => solver.contact = name.parse().expect("a method"),
            _ => solver.displacement_preconditioner = name.parse().expect("a method"),
        }
        let mesh = mesh(cube(2));
        assert!(plan(&scene, &mesh).is_ok(), "{name}");
        match Plan::new(&scene, &[], &mesh) {
            Err(SceneError::Unsupported(refused)) => {
                assert_eq!(refused.path, format!("solver.{key}"));
                assert!(refused.message.contains(name), "{refused}");
                assert!(refused.message.contains("`compare`"), "{refused}");
            }
            other => panic!("{other:?}"),
        }
    }
}
