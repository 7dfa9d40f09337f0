//! Methods to compare with reach the displacement of the automatic choice, and
//! take the applications of the displacement preconditioner that are known of them.

use std::sync::Arc;

use crate::common::meshes::{cube, file, mesh, square};
use crate::common::scenes::{HELD, cube_bend, elastic, hertz_plane, support, traction};
use crate::common::values;
use crate::harness::{plan, run_one};
use signorini::report::ManufacturedErrors;
use signorini::scene::{Choice, ContactSpace, Named};
use signorini::{FieldName, Mesh, Scene, Step, StepReport};

/// `[solver]` keys of a method.
#[derive(Clone, Copy, Debug, Default)]
struct Method {
    displacement: Option<&'static str>,
    p1: Option<&'static str>,
    saddle: Option<&'static str>,
}

impl Method {
    fn asked_of(self, mut scene: Scene) -> Scene {
        let solver = &mut scene.solver;
        solver.displacement_preconditioner = choice(self.displacement);
        solver.p1_solver = choice(self.p1);
        solver.saddle = choice(self.saddle);
        scene
    }
}

fn choice<T: Named>(name: Option<&str>) -> Choice<T> {
    name.map_or(Choice::Auto, |name| name.parse().expect("a method"))
}

fn solved(scene: &Scene, step: &Step, mesh: &Arc<Mesh>) -> (Vec<f64>, StepReport) {
    let (session, report) = run_one(scene, step, mesh);
    (values(&session, FieldName::Displacement), report)
}

fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let norm = |sum: f64| sum.sqrt();
    let difference = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    norm(difference) / norm(b.iter().map(|b| b * b).sum())
}

/// Iterations and applications of `method`, which must reach what the automatic
/// choice reaches.
fn counts(method: Method, scene: &Scene, mesh: &Arc<Mesh>) -> (u32, u32) {
    let (expected, _) = solved(scene, &Step::default(), mesh);
    let asked = method.asked_of(scene.clone());
    let (found, report) = solved(&asked, &Step::default(), mesh);
    let difference = relative_difference(&found, &expected);
    assert!(difference < 1e-6, "{method:?}: {difference:e}");
    (report.krylov_iterations, report.preconditioner_applications)
}

fn displacement(name: &'static str, saddle: &'static str) -> Method {
    Method {
        displacement: Some(name),
        saddle: Some(saddle),
        ..Method::default()
    }
}

#[test]
fn hierarchical_preconditioners_take_their_known_counts_on_every_mesh() {
    for count in [4, 6, 8] {
        let (scene, mesh) = (cube_bend(0.3), mesh(cube(count)));
        for (name, saddle, band) in [
            ("p-multigrid", "cg", 12..=16),
            ("p-multigrid", "gcr", 12..=16),
            ("hierarchical-ssor", "cg", 23..=32),
            ("hierarchical-ssor", "gcr", 23..=32),
            ("hierarchical-multiplicative", "gcr", 26..=36),
            ("hierarchical-additive", "cg", 45..=60),
        ] {
            let (iterations, applications) = counts(displacement(name, saddle), &scene, &mesh);
            assert!(band.contains(&iterations), "{count} {name}: {iterations}");
            assert_eq!(applications, iterations, "{count} {name} {saddle}");
        }
    }
}

#[test]
fn a_preconditioner_on_its_own_takes_several_times_its_conjugate_gradients() {
    let (scene, mesh) = (cube_bend(0.3), mesh(cube(6)));
    for (name, band) in [
        ("p-multigrid", 25..=45),
        ("hierarchical-ssor", 120..=190),
        ("hierarchical-multiplicative", 120..=190),
    ] {
        let (iterations, applications) = counts(displacement(name, "stationary"), &scene, &mesh);
        assert!(band.contains(&iterations), "{name}: {iterations}");
        assert_eq!(applications, iterations);
    }
}

#[test]
fn conjugate_gradients_on_p1_to_a_tolerance_cost_no_outer_iteration() {
    for (poisson_ratio, count) in [(0.3, 4), (0.3, 8), (0.5, 4), (0.5, 8)] {
        let (scene, mesh) = (cube_bend(poisson_ratio), mesh(cube(count)));
        let by = |p1| {
            let method = Method {
                p1: Some(p1),
                saddle: Some("gcr"),
                ..Method::default()
            };
            counts(method, &scene, &mesh).0
        };
        let (exact, iterated) = (by("cholesky"), by("ic-cg"));
        assert!(iterated <= exact + 1, "{count}: {iterated} {exact}");
    }
}

#[test]
fn ic_cg_alone_chooses_a_flexible_method() {
    let method = Method {
        p1: Some("ic-cg"),
        ..Method::default()
    };
    let (iterations, _) = counts(method, &cube_bend(0.3), &mesh(cube(4)));
    assert!((12..=17).contains(&iterations), "{iterations}");
}

#[test]
fn arrow_hurwicz_takes_as_many_iterations_as_the_triangle_at_twice_the_applications() {
    for count in [4, 6, 8] {
        let (scene, mesh) = (cube_bend(0.5), mesh(cube(count)));
        for (name, band) in [("p-multigrid", 20..=28), ("hierarchical-ssor", 25..=31)] {
            let method = displacement(name, "arrow-hurwicz");
            let (iterations, applications) = counts(method, &scene, &mesh);
            assert!(band.contains(&iterations), "{count} {name}: {iterations}");
            // Two more find the ratio.
            assert_eq!(applications, 2 * iterations + 2);
        }
    }
}

#[test]
fn minres_takes_three_times_the_iterations_of_gcr() {
    for count in [4, 6, 8] {
        let (scene, mesh) = (cube_bend(0.5), mesh(cube(count)));
        for (name, band) in [("p-multigrid", 60..=80), ("hierarchical-ssor", 120..=150)] {
            let (iterations, applications) = counts(displacement(name, "minres"), &scene, &mesh);
            assert!(band.contains(&iterations), "{count} {name}: {iterations}");
            assert_eq!(applications, iterations + 1);
        }
    }
}

#[test]
fn nested_uzawa_takes_few_outer_iterations_and_many_applications() {
    for count in [4, 6, 8] {
        let (scene, mesh) = (cube_bend(0.5), mesh(cube(count)));
        let (outer, applications) = counts(displacement("p-multigrid", "uzawa-cg"), &scene, &mesh);
        assert!((17..=25).contains(&outer), "{count}: {outer}");
        assert!(
            (140..=240).contains(&applications),
            "{count}: {applications}"
        );
    }
}

#[test]
fn compressible_mixed_bodies_are_served_by_every_method() {
    let (scene, mesh) = (cube_bend(0.47), mesh(cube(4)));
    for saddle in ["gcr", "arrow-hurwicz", "uzawa-cg", "minres"] {
        let (iterations, _) = counts(displacement("p-multigrid", saddle), &scene, &mesh);
        assert!(iterations <= 75, "{saddle}: {iterations}");
    }
}

#[test]
fn an_enclosed_body_is_served_by_every_method() {
    let mut scene = elastic(0.5);
    let (sides, held) = (["x0", "x1", "y0", "y1"], [Some(0.0), Some(0.0), None]);
    scene.supports = sides.map(|side| support(side, held)).to_vec();
    scene.manufactured = Some("vortex".to_owned());
    let mesh = mesh(square(12));
    for saddle in ["gcr", "arrow-hurwicz", "uzawa-cg", "minres"] {
        let (iterations, _) = counts(displacement("p-multigrid", saddle), &scene, &mesh);
        assert!(iterations <= 75, "{saddle}: {iterations}");
    }
}

#[test]
fn plane_strain_is_served_by_every_preconditioner() {
    let (mut scene, mesh) = (elastic(0.5), mesh(square(12)));
    let held = [Some(0.0), Some(0.0), None];
    scene.supports = vec![support("x0", held)];
    scene.tractions = vec![traction("x1", [0.0, -1.0, 0.0])];
    for (name, most) in [
        ("hierarchical-ssor", 40),
        ("hierarchical-multiplicative", 45),
        ("hierarchical-additive", 60),
    ] {
        let method = Method {
            p1: Some("ic-cg"),
            ..displacement(name, "arrow-hurwicz")
        };
        let (iterations, _) = counts(method, &scene, &mesh);
        assert!(iterations <= most, "{name}: {iterations}");
    }
}

#[test]
fn contact_is_the_same_by_either_step_and_preconditioner() {
    let (mut scene, step) = hertz_plane(0.5);
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    let mesh = file("hemi_l1");
    let (expected, default) = solved(&scene, &step, &mesh);
    for (name, saddle, per_iteration, most) in [
        ("p-multigrid", "arrow-hurwicz", 2, 36),
        ("hierarchical-ssor", "gcr", 1, 65),
        ("hierarchical-ssor", "arrow-hurwicz", 2, 50),
        ("hierarchical-multiplicative", "gcr", 1, 65),
    ] {
        let asked = displacement(name, saddle).asked_of(scene.clone());
        let (found, report) = solved(&asked, &step, &mesh);
        assert!(
            relative_difference(&found, &expected) < 1e-6,
            "{name} {saddle}"
        );
        let (iterations, taken) = (report.krylov_iterations, report.preconditioner_applications);
        assert!(iterations <= most, "{name} {saddle}: {iterations}");
        assert_eq!(taken, per_iteration * iterations, "{name} {saddle}");
        assert_eq!(report.active_vertices, default.active_vertices);
    }
}

/// Applications and displacement with a grad-div term.
fn penalised(weight: f64, saddle: &'static str, mesh: &Arc<Mesh>) -> (u32, Vec<f64>) {
    let mut scene = displacement("p-multigrid", saddle).asked_of(cube_bend(0.5));
    scene.solver.penalty = Some(weight);
    let (found, report) = solved(&scene, &Step::default(), mesh);
    (report.preconditioner_applications, found)
}

#[test]
fn a_small_penalty_saves_iterations_and_changes_what_the_mesh_leaves_open() {
    for saddle in ["gcr", "arrow-hurwicz", "uzawa-cg", "minres"] {
        let mesh = mesh(cube(6));
        let (without, _) = penalised(0.0, saddle, &mesh);
        // GCR solves augmented without it, which gains as much.
        let (saved, lost) = if saddle == "gcr" { (0, 2) } else { (1, 0) };
        for weight in [0.5, 1.0] {
            let (taken, _) = penalised(weight, saddle, &mesh);
            assert!(
                taken + saved <= without,
                "{saddle} {weight}: {taken} {without}"
            );
        }
        let (taken, _) = penalised(5.0, saddle, &mesh);
        assert!(taken <= without + lost, "{saddle}: {taken} {without}");
    }
    let change = |count| {
        let mesh = mesh(cube(count));
        let (plain, term) = (penalised(0.0, "gcr", &mesh), penalised(1.0, "gcr", &mesh));
        relative_difference(&term.1, &plain.1)
    };
    let (coarse, fine) = (change(4), change(8));
    assert!(coarse < 1e-2 && fine < 0.6 * coarse, "{coarse} {fine}");
}

#[test]
fn a_penalty_keeps_the_error_of_the_discretisation() {
    let error = |penalty| {
        let mut scene = elastic(0.5);
        scene.supports = vec![support("x0", HELD)];
        scene.manufactured = Some("A1m".to_owned());
        scene.solver.penalty = penalty;
        let (_, report) = solved(&scene, &Step::default(), &mesh(cube(6)));
        report.errors.expect("a manufactured scene has errors")
    };
    let (plain, term) = (error(None), error(Some(1.0)));
    assert!(term.displacement_l2 < 1.2 * plain.displacement_l2);
    assert!(term.displacement_h1 < 1.05 * plain.displacement_h1);
    let pressure = |errors: &ManufacturedErrors| errors.pressure_l2.expect("a pressure");
    assert!(pressure(&term) < 2.0 * pressure(&plain));
}

#[test]
fn a_plan_names_the_methods_that_were_asked_for() {
    let scene = Method {
        displacement: Some("hierarchical-multiplicative"),
        p1: Some("ic-cg"),
        saddle: Some("arrow-hurwicz"),
    }
    .asked_of(cube_bend(0.5));
    let mesh = mesh(cube(2));
    let asked = plan(&scene, &mesh).expect("a valid scene");
    let report = asked.report();
    for (what, word) in [
        ("displacement_preconditioner", "Gauss-Seidel"),
        ("p1_solver", "incomplete Cholesky"),
        ("saddle", "Arrow-Hurwicz"),
    ] {
        let found = report.decisions.iter().find(|entry| entry.what == what);
        let entry = found.expect("a decision");
        assert!(entry.choice.contains(word), "{}", entry.choice);
        assert!(entry.reason.starts_with("asked for"), "{}", entry.reason);
    }
    let default = plan(&cube_bend(0.5), &mesh).expect("a valid scene");
    assert!(default.key() != asked.key());
    assert!(report.predicted_applications > default.report().predicted_applications);
}
