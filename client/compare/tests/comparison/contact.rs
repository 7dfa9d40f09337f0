//! Comparison methods for contact: each reaches the reference forces, with the
//! counts that it is known for; metrics change counts, never results.

use std::sync::Arc;

use crate::common::meshes::{cube, file, irregular, mesh};
use crate::common::scenes::{elastic, hertz_plane, hertz_sphere, obstacle, support};
use crate::common::{assert_converged, close, difference, values};
use crate::harness::{plan, run, run_one};
use serde_json::Value;
use signorini::scene::{Choice, ContactMethod, ContactSpace, ObstacleTarget, Shape};
use signorini::{Cause, FieldName, Mesh, Scene, SceneError, Step, StepReport, Termination};

const TOLERANCE: f64 = 1e-6;

/// Methods with their metric and the products and applications of A^ that they
/// may take on `indent_l1` and `hemi_l1`.
struct Expected {
    contact: &'static str,
    metric: &'static str,
    products: [u32; 2],
    applications: [u32; 2],
}

const fn expected(
    contact: &'static str,
    metric: &'static str,
    products: [u32; 2],
    applications: [u32; 2],
) -> Expected {
    Expected {
        contact,
        metric,
        products,
        applications,
    }
}

const METHODS: [Expected; 15] = [
    expected("one-level", "compliance", [0, 0], [14, 22]),
    expected("one-level", "fractional", [0, 0], [20, 42]),
    expected("one-level", "mass", [0, 0], [50, 130]),
    expected("active-set", "compliance", [0, 0], [20, 80]),
    expected("active-set", "fractional", [0, 0], [30, 100]),
    expected("active-set", "mass", [0, 0], [80, 450]),
    expected("nested", "compliance", [4, 12], [50, 130]),
    expected("nested", "fractional", [4, 12], [50, 130]),
    expected("nested", "mass", [8, 24], [100, 320]),
    expected("mprgp", "compliance", [10, 24], [100, 360]),
    expected("mprgp", "fractional", [9, 24], [90, 360]),
    expected("mprgp", "mass", [14, 34], [160, 520]),
    expected("conjugate-projected-gradient", "mass", [10, 26], [140, 400]),
    expected(
        "projected-arrow-hurwicz",
        "compliance",
        [60, 240],
        [700, 3000],
    ),
    expected(
        "projected-arrow-hurwicz",
        "fractional",
        [12, 60],
        [150, 700],
    ),
];

fn references() -> Value {
    serde_json::from_str(include_str!("../../../../tests/reference/references.json"))
        .expect("valid JSON")
}

/// The published force on the part that is modelled.
fn reference_force(case: &str, mesh: &str) -> f64 {
    let case = &references()[case];
    let whole = case["meshes"][mesh]["steps"][0]["force"].as_f64();
    whole.expect("a force") / case["whole_body_factor"].as_f64().expect("a factor")
}

fn with_method(scene: &Scene, contact: &str, metric: &str) -> Scene {
    let mut scene = scene.clone();
    scene.solver.contact = contact.parse().expect("a method");
    scene.solver.contact_metric = metric.parse().expect("a metric");
    // That of the references and of the counts.
    scene.solver.contact_space = Choice::Named(ContactSpace::Linear);
    scene
}

fn force(report: &StepReport) -> f64 {
    let mut obstacles = report.obstacles.values();
    obstacles.next().expect("one obstacle").force[2].abs()
}

fn check_forces(case: &str, name: &str, (mut scene, step): (Scene, Step)) {
    scene.solver.tolerance = TOLERANCE;
    let (mesh, exact) = (file(name), reference_force(case, name));
    for method in &METHODS {
        let (contact, metric) = (method.contact, method.metric);
        let scene = with_method(&scene, contact, metric);
        let report = run(&scene, std::slice::from_ref(&step), &mesh).1.remove(0);
        let label = format!("{name} {contact} {metric}");
        assert_eq!(report.termination, Termination::Converged, "{label}");
        assert!(
            close(force(&report), exact, 1e-5),
            "{label}: {}",
            force(&report)
        );
        for (what, count, [least, most]) in [
            ("products", report.contact_products, method.products),
            (
                "applications",
                report.preconditioner_applications,
                method.applications,
            ),
        ] {
            assert!(
                (least..=most).contains(&count),
                "{label}: {count} {what} outside {least} to {most}"
            );
        }
    }
}

#[test]
fn every_method_finds_the_force_of_the_sphere_within_its_counts() {
    check_forces("hertz-sphere", "indent_l1", hertz_sphere(0.5));
}

#[test]
fn every_method_finds_the_force_of_the_plane_within_its_counts() {
    check_forces("hertz-plane", "hemi_l1", hertz_plane(0.5));
}

#[test]
fn the_seeds_method_takes_more_products_on_finer_meshes_and_secants_do_not() {
    let products = |name: &str, contact: &str| {
        let (mut scene, step) = hertz_plane(0.5);
        scene.solver.tolerance = TOLERANCE;
        let scene = with_method(&scene, contact, "auto");
        run_one(&scene, &step, &file(name)).1.contact_products
    };
    let growth = |contact: &str| {
        let (coarse, fine) = (products("hemi_l1", contact), products("hemi_l2", contact));
        f64::from(fine) / f64::from(coarse)
    };
    let (seed, nested) = (growth("conjugate-projected-gradient"), growth("nested"));
    assert!(seed > 1.2 && nested < 1.5, "{seed} {nested}");
}

#[test]
fn fixed_steps_in_the_mass_end_with_a_typed_outcome_at_the_last_good_state() {
    let (mut scene, step) = hertz_plane(0.5);
    scene.solver.tolerance = 1e-10;
    let scene = with_method(&scene, "projected-arrow-hurwicz", "mass");
    let steps = std::slice::from_ref(&step);
    let report = run(&scene, steps, &file("hemi_l1")).1.remove(0);
    assert_eq!(
        (report.termination, report.cause),
        (Termination::NotConverged, Some(Cause::IterationLimit))
    );
    assert_eq!((report.contact_products, report.cut_backs), (400, 0));
    // An iterate that did not converge is kept no more.
    assert!(force(&report).abs() < 1e-12, "{}", force(&report));
}

/// A block squeezed between a moved top and a floor.
fn patch(poisson_ratio: f64) -> (Scene, Arc<Mesh>) {
    let mut scene = elastic(poisson_ratio);
    scene.solver.tolerance = 1e-10;
    scene.supports = vec![
        support("x0", [Some(0.0), None, None]),
        support("y0", [None, Some(0.0), None]),
        support("z1", [None, None, Some(-0.1)]),
    ];
    let floor = Shape::HalfSpace {
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    };
    scene.obstacles = vec![obstacle("floor", "z0", floor)];
    (scene, mesh(irregular(cube(3), 3)))
}

#[test]
fn every_method_passes_the_patch_test() {
    for poisson_ratio in [0.5, 0.3] {
        let (scene, mesh) = patch(poisson_ratio);
        for method in &METHODS {
            let scene = with_method(&scene, method.contact, method.metric);
            let (session, reports) = run(&scene, &[Step::default()], &mesh);
            let report = &reports[0];
            let pressure = 0.2 * (1.0 + poisson_ratio);
            let label = format!("{} {} {poisson_ratio}", method.contact, method.metric);
            assert_eq!(report.termination, Termination::Converged, "{label}");
            assert!((force(report) - pressure).abs() < 1e-7, "{label}");
            assert_eq!(u64::from(report.active_vertices), report.unknowns.contact);
            let field = values(&session, FieldName::ContactPressure);
            let touching = |v: &&f64| **v != 0.0;
            let found: Vec<f64> = field.iter().filter(touching).copied().collect();
            let error = difference(&found, &vec![pressure; found.len()]);
            assert!(error < 1e-6, "{label} {error:e}");
        }
    }
}

#[test]
fn a_second_step_starts_warm_in_every_nested_method() {
    let (mut scene, step) = hertz_plane(0.5);
    scene.solver.tolerance = TOLERANCE;
    let mesh = file("hemi_l1");
    let mut deeper = step.clone();
    deeper.obstacles[0].translation = Some([0.0, 0.0, 0.0505]);
    for contact in ["nested", "mprgp", "conjugate-projected-gradient"] {
        let scene = with_method(&scene, contact, "auto");
        let (_, reports) = run(&scene, &[step.clone(), deeper.clone()], &mesh);
        assert_eq!(reports[1].termination, Termination::Converged);
        let counts = [0, 1].map(|k: usize| reports[k].preconditioner_applications);
        assert!(counts[1] < counts[0], "{contact} {counts:?}");
    }
}

fn refusal(scene: &Scene, mesh: &Arc<Mesh>) -> (String, String) {
    match plan(scene, mesh).expect_err("a refusal") {
        SceneError::Invalid(faults) => (faults[0].path.clone(), faults[0].message.clone()),
        SceneError::Unsupported(fault) => (fault.path, fault.message),
    }
}

#[test]
fn combinations_that_make_no_sense_are_refused_with_path_and_reason() {
    let (scene, mesh) = patch(0.5);
    let seed = with_method(&scene, "conjugate-projected-gradient", "compliance");
    let (path, message) = refusal(&seed, &mesh);
    assert_eq!(path, "solver.contact_metric");
    assert!(message.contains("`mass`"), "{message}");
    let misspelt = "nestd".parse::<Choice<ContactMethod>>();
    let message = misspelt.expect_err("no such method").to_string();
    assert!(message.contains("did you mean `nested`"), "{message}");
    let mut floating = with_method(&scene, "nested", "auto");
    floating.supports.truncate(2);
    floating.tractions = vec![crate::common::scenes::traction("z1", [0.0, 0.0, -0.1])];
    let (path, message) = refusal(&floating, &mesh);
    assert_eq!(path, "solver.contact");
    assert!(message.contains("one-level"), "{message}");
    floating.solver.contact = Choice::Named(ContactMethod::OneLevel);
    plan(&floating, &mesh).expect("one level holds it by contact");
}

#[test]
fn the_plan_names_method_and_metric_and_leaves_an_unused_compliance_out() {
    let (scene, mesh) = patch(0.5);
    let report = |contact: &str, metric: &str| {
        let scene = with_method(&scene, contact, metric);
        plan(&scene, &mesh).expect("a plan").report()
    };
    let decision = |contact: &str, metric: &str| {
        let mut decisions = report(contact, metric).decisions.into_iter();
        let entry = decisions.find(|entry| entry.what == "contact");
        let entry = entry.expect("a decision");
        (entry.choice, entry.reason)
    };
    let (choice, reason) = decision("auto", "auto");
    assert_eq!(choice, "one level, dense compliance metric");
    assert!(reason.contains("in one iteration"), "{reason}");
    let (choice, reason) = decision("mprgp", "mass");
    assert!(choice.contains("proportioning") && choice.contains("lumped mass"));
    assert_eq!(reason, "asked for");
    let left_out = |contact: &str, metric: &str| {
        let entries = report(contact, metric).left_out.into_iter();
        entries.map(|entry| entry.what).collect::<Vec<_>>()
    };
    let compliance = "contact compliance".to_owned();
    assert!(left_out("mprgp", "mass").contains(&compliance));
    assert!(!left_out("auto", "auto").contains(&compliance));
}

/// Where a method has no metric the stiffness under the tool is learnt.
#[test]
fn a_method_without_a_metric_meets_a_push_too() {
    let (mut scene, _) = hertz_sphere(0.5);
    scene.solver.tolerance = 1e-8;
    let scene = with_method(&scene, "conjugate-projected-gradient", "auto");
    let down = Step {
        obstacles: vec![ObstacleTarget {
            name: scene.obstacles[0].name.clone(),
            force: [None, None, Some(-0.0125)],
            ..ObstacleTarget::default()
        }],
        ..Step::default()
    };
    let (_, reports) = run(&scene, &[down], &file("indent_l1"));
    reports.iter().for_each(assert_converged);
    let last = reports.last().expect("an increment");
    let pressed = last.obstacles[&scene.obstacles[0].name].force[2];
    assert!(close(pressed, -0.0125, 1e-6), "{pressed}");
}
