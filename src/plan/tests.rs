//! Decisions and their keys, and the prepared preconditioners on real bodies.

use std::sync::Arc;

use super::Plan;
use crate::comparisons::Comparisons;
use crate::krylov::cg::Cg;
use crate::krylov::{Monitor, Outcome, Verdict};
use crate::linalg::vector::{dot, norm, reproducible_noise};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::mesh::{Mesh, samples};
use crate::prepare::TaylorHoodData as Prepared;
use crate::report::CancelToken;
use crate::scene::{
    Choice, DisplacementMethod, Formulation, Material, MaterialModel, Modulus, Obstacle, P1Solver,
    Profile, SaddleMethod, Scene, Shape, Support, Traction,
};

fn scene(poisson_ratio: f64) -> Scene {
    Scene {
        materials: vec![Material {
            group: "body".to_owned(),
            model: MaterialModel::LinearElastic {
                modulus: Modulus::Shear(2.0),
                poisson_ratio,
                formulation: Formulation::Auto,
            },
        }],
        supports: vec![Support {
            name: "wall".to_owned(),
            on: vec!["x0".to_owned()],
            normal: None,
            displacement: [Some(0.0), Some(0.0), None],
            profile: Profile::Constant,
            values: None,
            load: Default::default(),
        }],
        ..Scene::default()
    }
}

#[test]
fn the_axis_of_a_body_of_revolution_is_its_side_at_x_zero() {
    let mesh = samples::rectangle(2, 2);
    let space = crate::space::TaylorHood::new(&mesh);
    let nodes = crate::plan::held::nodes_on_axis(&mesh, &space);
    let on_axis = |vertex: &u32| mesh.coordinates()[*vertex as usize][0] <= 0.0;
    let (vertices, edges): (Vec<u32>, Vec<u32>) = nodes
        .iter()
        .partition(|&&node| (node as usize) < space.vertices);
    assert_eq!((vertices.len(), edges.len()), (3, 2));
    assert!(vertices.iter().all(on_axis));
    for node in edges {
        assert!(
            space.edges[node as usize - space.vertices]
                .iter()
                .all(on_axis)
        );
    }
}

/// [`scene`] with the third component held as well.
fn clamped(poisson_ratio: f64) -> Scene {
    let mut scene = scene(poisson_ratio);
    scene.supports[0].displacement = [Some(0.0); 3];
    scene
}

fn with_floor(mut scene: Scene) -> Scene {
    scene.obstacles = vec![Obstacle {
        name: "floor".to_owned(),
        on: vec!["z0".to_owned()],
        shape: Shape::HalfSpace {
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
        },
        surface: crate::scene::SurfaceGeometry::default(),
        friction: 0.0,
        tresca: None,
        initial_penetration: crate::scene::PenetrationPolicy::default(),
    }];
    scene
}

/// Methods of which a plan knows the names alone.
#[derive(Debug)]
struct Names;

impl Comparisons for Names {}

fn plan(scene: &Scene, mesh: &Mesh) -> Plan {
    let names = Some(Arc::new(Names) as Arc<dyn Comparisons>);
    Plan::with_comparisons(scene, &[], mesh, names).expect("a valid scene")
}

fn prepare(scene: &Scene, mesh: Mesh) -> Prepared {
    let plan = plan(scene, &mesh);
    Prepared::build(&plan, &Arc::new(mesh), &CancelToken::new()).expect("a solvable scene")
}

struct Reduced {
    bound: f64,
    iterations: usize,
}

impl Monitor for Reduced {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        if norm(residual) <= self.bound {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}

/// Free entries of a fixed random vector.
fn noise(prepared: &Prepared) -> Vec<f64> {
    let mut x = reproducible_noise(prepared.stiffness.rows());
    prepared
        .held
        .entries
        .iter()
        .for_each(|&index| x[index as usize] = 0.0);
    x
}

/// Solved by a method that asks for a symmetric preconditioner.
fn symmetric(mut scene: Scene) -> Scene {
    scene.solver.saddle = Choice::Named(SaddleMethod::Minres);
    scene
}

#[test]
fn the_displacement_preconditioner_is_symmetric_and_positive() {
    for (scene, mesh) in [
        (symmetric(clamped(0.5)), samples::cube(3)),
        (scene(0.3), samples::rectangle(5, 5)),
    ] {
        let prepared = prepare(&scene, mesh);
        let x = noise(&prepared);
        let mut y: Vec<f64> = x.iter().rev().copied().collect();
        prepared
            .held
            .entries
            .iter()
            .for_each(|&index| y[index as usize] = 0.0);
        let apply = |r: &[f64]| {
            let mut z = vec![f64::NAN; r.len()];
            prepared
                .at_rest
                .displacement
                .apply(r, &mut z, &mut Workspace::new());
            z
        };
        let (ax, ay) = (apply(&x), apply(&y));
        let (left, right) = (dot(&ax, &y), dot(&ay, &x));
        // To the rounding of a factor in single precision.
        assert!((left - right).abs() < 1e-4 * dot(&ax, &x), "{left} {right}");
        assert!(dot(&ax, &x) > 0.0 && dot(&ay, &y) > 0.0);
    }
}

#[test]
fn methods_and_penalty_have_keys_of_their_own() {
    let mesh = samples::cube(2);
    let base = plan(&clamped(0.5), &mesh).key();
    let changed = |change: fn(&mut Scene)| {
        let mut scene = clamped(0.5);
        change(&mut scene);
        plan(&scene, &mesh).key()
    };
    let others = [
        changed(|scene| {
            scene.solver.displacement_preconditioner =
                Choice::Named(DisplacementMethod::HierarchicalSsor);
        }),
        changed(|scene| scene.solver.p1_solver = Choice::Named(P1Solver::IcCg)),
        changed(|scene| scene.solver.penalty = Some(1.0)),
    ];
    assert!(others.iter().all(|key| *key != base));
    // Methods that do not solve augmented share the inverse of A itself.
    let by = |method| {
        let mut scene = clamped(0.5);
        scene.solver.saddle = Choice::Named(method);
        plan(&scene, &mesh).key()
    };
    let of_minres = by(SaddleMethod::Minres);
    assert!(of_minres != base && of_minres == by(SaddleMethod::UzawaCg));
}

/// Conjugate gradients on the displacement block to a reduction of 1e-8.
fn count(prepared: &Prepared) -> usize {
    let mut r = noise(prepared);
    let mut x = vec![0.0; r.len()];
    let mut monitor = Reduced {
        bound: 1e-8 * norm(&r),
        iterations: 0,
    };
    let method = Cg {
        operator: &prepared.stiffness,
        preconditioner: &*prepared.at_rest.displacement,
        iterations: 50,
    };
    let outcome = method.solve((&mut x, &mut r), &mut monitor, &mut Workspace::new());
    assert_eq!(outcome, Outcome::Stopped);
    monitor.iterations
}

#[test]
fn conjugate_gradients_on_the_displacement_block_take_at_most_14() {
    for size in [3, 6, 8] {
        let iterations = count(&prepare(&symmetric(clamped(0.5)), samples::cube(size)));
        assert!(iterations <= 14, "{size}: {iterations}");
    }
}

/// [`clamped`] above a floor, with the named P1 solver.
fn solved_by(p1_solver: &str, poisson_ratio: f64) -> Scene {
    let mut scene = with_floor(clamped(poisson_ratio));
    scene.solver.p1_solver = p1_solver.parse().expect("a P1 solver");
    scene
}

#[test]
fn multigrid_takes_as_many_iterations_as_the_factor() {
    for poisson_ratio in [0.3, 0.5] {
        let prepared = |name| prepare(&solved_by(name, poisson_ratio), samples::cube(8));
        let (direct, multigrid) = (prepared("cholesky"), prepared("amg"));
        assert!(multigrid.parts().contains(&"p1_multigrid".to_owned()));
        let counts = (count(&direct), count(&multigrid));
        assert!(counts.1 <= counts.0 + 2, "{counts:?}");
        let (exact, found) = (&direct.at_rest.compliance, &multigrid.at_rest.compliance);
        assert_eq!(exact.rows(), found.rows());
        let diagonal = (0..exact.rows()).map(|i| exact.at(i, i));
        let largest = diagonal.fold(0.0, f64::max);
        for j in 0..exact.columns() {
            for i in 0..exact.rows() {
                let error = (found.at(i, j) - exact.at(i, j)).abs();
                assert!(error < 0.2 * largest, "{i} {j}: {error}");
            }
        }
    }
}

#[test]
fn the_plan_names_the_p1_solver_and_its_reason() {
    let mesh = samples::cube(3);
    let chosen = |name| {
        let report = plan(&solved_by(name, 0.5), &mesh).report();
        let mut decisions = report.decisions.into_iter();
        decisions
            .find(|entry| entry.what == "p1_solver")
            .expect("a decision")
    };
    assert!(chosen("amg").choice.contains("multigrid"));
    assert_eq!(chosen("amg").reason, "asked for");
    assert!(chosen("auto").choice.contains("Cholesky"));
    assert!(chosen("auto").reason.contains("Gflop"));
    let key = |name| plan(&solved_by(name, 0.5), &mesh).key();
    assert!(key("amg") != key("cholesky") && key("auto") == key("cholesky"));
}

#[test]
fn the_pressure_metric_inverts_the_weighted_mass() {
    let prepared = prepare(&clamped(0.5), samples::cube(3));
    let metric = &prepared
        .pressure
        .as_ref()
        .expect("an incompressible body")
        .metric;
    let exact = reproducible_noise(prepared.space.vertices);
    let (mut r, mut z) = (vec![0.0; exact.len()], vec![0.0; exact.len()]);
    let work = &mut Workspace::new();
    metric.mass().apply(&exact, &mut r, work);
    metric.apply(&r, &mut z, work);
    let error: Vec<f64> = z.iter().zip(&exact).map(|(a, b)| a - b).collect();
    assert!(
        norm(&error) < 0.02 * norm(&exact),
        "{}",
        norm(&error) / norm(&exact)
    );
    // 1 / (step mu) with mu non-dimensional: the mass of the body over 2 and half of gamma.
    metric.mass().apply(&vec![1.0; exact.len()], &mut r, work);
    assert!((r.iter().sum::<f64>() - 1.0 / 2.25).abs() < 1e-13);
}

#[test]
fn loads_obstacle_shapes_and_units_share_prepared_data() {
    let mesh = samples::cube(2);
    let base = plan(&with_floor(clamped(0.5)), &mesh).key();
    let mut scene = with_floor(clamped(0.5));
    scene.tractions = vec![Traction {
        on: vec!["x1".to_owned()],
        value: [0.0, 1.0, 0.0],
        ..Traction::default()
    }];
    scene.body_force = [0.1, 0.2, 0.3];
    scene.supports[0].displacement = [Some(0.1), Some(0.0), Some(-0.2)];
    scene.obstacles[0].shape = Shape::Sphere {
        centre: [0.0; 3],
        radius: 0.1,
    };
    scene.mesh_scale = Some(3.0);
    scene.solver.tolerance = 1e-4;
    scene.materials[0].model = MaterialModel::LinearElastic {
        modulus: Modulus::Shear(8.0),
        poisson_ratio: 0.5,
        formulation: Formulation::Auto,
    };
    assert_eq!(plan(&scene, &mesh).key(), base);
}

#[test]
fn what_the_factor_depends_on_has_a_key_of_its_own() {
    let mesh = samples::cube(2);
    let base = plan(&clamped(0.5), &mesh).key();
    let mut held = clamped(0.5);
    held.supports[0].on.push("y0".to_owned());
    let others = [
        plan(&clamped(0.499), &mesh).key(),
        plan(&clamped(0.3), &mesh).key(),
        plan(&held, &mesh).key(),
        plan(&with_floor(clamped(0.5)), &mesh).key(),
        plan(&clamped(0.5), &samples::cube(3)).key(),
    ];
    assert!(others.iter().all(|key| *key != base));
}

#[test]
fn a_plan_leaves_out_what_the_scene_does_not_need() {
    let mesh = samples::cube(2);
    let report = plan(&clamped(0.3), &mesh).report();
    assert_eq!(report.formulation, "displacement");
    assert_eq!((report.unknowns.pressure, report.unknowns.contact), (0, 0));
    let absent: Vec<&str> = report
        .left_out
        .iter()
        .map(|entry| entry.what.as_str())
        .collect();
    assert!(
        absent.iter().any(|what| what.contains("pressure unknowns")),
        "{absent:?}"
    );
    assert!(
        absent
            .iter()
            .any(|what| what.contains("contact multipliers")),
        "{absent:?}"
    );
    let report = plan(&with_floor(clamped(0.5)), &mesh).report();
    assert_eq!(report.formulation, "mixed");
    assert_eq!(
        (report.unknowns.pressure, report.unknowns.contact),
        (27, 20)
    );
    assert!(
        report
            .left_out
            .iter()
            .all(|entry| !entry.what.contains("contact"))
    );
    assert!(report.decisions.iter().any(|entry| entry.what == "contact"));
    let prepared = prepare(&clamped(0.3), samples::cube(2));
    assert!(prepared.pressure.is_none() && prepared.at_rest.compliance.rows() == 0);
}

fn assert_predicted(scene: &Scene) {
    let mesh = samples::cube(8);
    let predicted = plan(scene, &mesh).report().predicted_bytes;
    let held = prepare(scene, mesh).bytes();
    assert!(
        held < predicted && predicted < 20 * held,
        "{held} {predicted}"
    );
}

#[test]
fn predicted_bytes_bound_the_prepared_data() {
    assert_predicted(&clamped(0.5));
    assert_predicted(&with_floor(clamped(0.5)));
}
