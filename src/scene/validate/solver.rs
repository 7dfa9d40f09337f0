//! Numerical settings: ranges and names of methods.

use super::{Faults, names};
use crate::element::quadrature::MAXIMUM_DEGREE;
use crate::inequality::{ContactMethod, MetricKind};
use crate::scene::{MaterialModel, Scene, ToleranceRule};

const PRECONDITIONERS: &[&str] = &[
    "p-multigrid",
    "hierarchical-ssor",
    "hierarchical-multiplicative",
    "hierarchical-additive",
];
const P1_SOLVERS: &[&str] = &["cholesky", "amg", "ic-cg"];
const SADDLES: &[&str] = &[
    "gcr",
    "cg",
    "stationary",
    "arrow-hurwicz",
    "uzawa-cg",
    "minres",
];
/// Larger weights make the displacement block as stiff in volume as the
/// constraint itself.
const LARGEST_PENALTY: f64 = 100.0;

/// What the choice of methods depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formulated {
    /// Whether the scene carries a pressure unknown.
    pub(crate) mixed: bool,
    /// Whether no material changes its volume.
    pub(crate) incompressible: bool,
}

/// Checks `[solver]`.
pub(crate) fn check(scene: &Scene, formulated: Formulated, faults: &mut Faults) {
    ranges(scene, faults);
    let solver = &scene.solver;
    let contact_methods = ContactMethod::ALL.map(ContactMethod::name);
    let contact_metrics = MetricKind::ALL.map(MetricKind::name);
    let methods = [
        (
            "element",
            &solver.element,
            &["taylor-hood", "mini", "bernardi-raugel"][..],
        ),
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
            PRECONDITIONERS,
        ),
        ("p1_solver", &solver.p1_solver, P1_SOLVERS),
        ("saddle", &solver.saddle, SADDLES),
        ("contact", &solver.contact, &contact_methods),
        ("contact_metric", &solver.contact_metric, &contact_metrics),
        ("error_estimate", &solver.error_estimate, &["off"]),
    ];
    for (key, asked, available) in methods {
        let path = format!("solver.{key}");
        match asked.as_str() {
            "auto" => (),
            name if available.contains(&name) => (),
            name => {
                let hint = names::hint(name, available.iter().copied().chain(["auto"]));
                faults.add(path, format!("unknown method `{name}`{hint}"));
            }
        }
    }
    combinations(scene, formulated, faults);
    penalty(scene, formulated, faults);
}

fn ranges(scene: &Scene, faults: &mut Faults) {
    let solver = &scene.solver;
    if !(solver.tolerance >= 1e-14 && solver.tolerance <= 0.1) {
        let message = format!("must lie between 1e-14 and 0.1, not {}", solver.tolerance);
        faults.add("solver.tolerance", message);
    }
    if solver.tolerance_rule == ToleranceRule::Discretisation && solver.error_estimate == "off" {
        let message = "must not be `off` where `solver.tolerance` is `discretisation`";
        faults.add("solver.error_estimate", message);
    }
    if let Some(degree) = solver.quadrature_degree
        && !(1..=MAXIMUM_DEGREE).contains(&degree)
    {
        let message = format!("must lie between 1 and {MAXIMUM_DEGREE}, not {degree}");
        faults.add("solver.quadrature_degree", message);
    }
    if let Some(seconds) = solver.max_wall_time
        && !(seconds > 0.0 && seconds.is_finite())
    {
        let message = format!("must be above zero and finite, not {seconds}");
        faults.add("solver.max_wall_time", message);
    }
}

/// Methods that exist but make no sense together.
fn combinations(scene: &Scene, formulated: Formulated, faults: &mut Faults) {
    let solver = &scene.solver;
    let has_contact = !scene.obstacles.is_empty();
    let mut refuse = |key: &str, name: &str, reason: &str| {
        faults.add(format!("solver.{key}"), format!("`{name}` {reason}"));
    };
    let saddle = solver.saddle.as_str();
    if let Some(reason) = misplaced(saddle, formulated.mixed, has_contact) {
        refuse("saddle", saddle, reason);
    }
    let is_fixed_method = matches!(saddle, "cg" | "minres" | "uzawa-cg");
    let preconditioner = solver.displacement_preconditioner.as_str();
    if is_fixed_method && preconditioner == "hierarchical-multiplicative" {
        let reason = format!("is not symmetric, which `{saddle}` needs; `gcr` does without");
        refuse("displacement_preconditioner", preconditioner, &reason);
    }
    if is_fixed_method && solver.p1_solver == "ic-cg" {
        let reason = format!("changes from call to call, which `{saddle}` cannot bear; `gcr` can");
        refuse("p1_solver", "ic-cg", &reason);
    }
    if has_contact && solver.p1_solver == "ic-cg" {
        let reason = "gives no compliance of the contact surface; `cholesky` and `amg` do";
        refuse("p1_solver", "ic-cg", reason);
    }
}

/// Why a method of the linear systems does not fit the unknowns.
fn misplaced(saddle: &str, mixed: bool, has_contact: bool) -> Option<&'static str> {
    match (saddle, mixed, has_contact) {
        ("cg" | "stationary", true, _) => {
            Some("needs a positive definite system; a pressure unknown makes it a saddle point")
        }
        ("cg" | "stationary", false, true) => {
            Some("needs a positive definite system; contact pressure makes it a saddle point")
        }
        ("arrow-hurwicz" | "uzawa-cg" | "minres", false, _) => {
            Some("needs a pressure unknown; every Poisson ratio is below 0.45")
        }
        ("uzawa-cg" | "minres", true, true) => {
            Some("does not serve contact; `gcr` and `arrow-hurwicz` do")
        }
        _ => None,
    }
}

/// Rubber takes its penalty on the volume change that its pressure does not account
/// for.
fn has_rubber(scene: &Scene) -> bool {
    let mut models = scene.materials.iter().map(|material| &material.model);
    models.any(|model| matches!(model, MaterialModel::Rubber { .. }))
}

fn penalty(scene: &Scene, formulated: Formulated, faults: &mut Faults) {
    let path = "solver.penalty";
    let Some(weight) = scene.solver.penalty else {
        return;
    };
    if !(0.0..=LARGEST_PENALTY).contains(&weight) {
        let message = format!("must lie between 0 and {LARGEST_PENALTY}, not {weight}");
        faults.add(path, message);
    } else if weight > 0.0 && !formulated.mixed {
        faults.add(path, "needs a pressure unknown; this scene has none");
    } else if weight > 0.0 && !formulated.incompressible && !has_rubber(scene) {
        let message =
            "acts on the volume of incompressible materials; a Poisson ratio is below 0.5";
        faults.add(path, message);
    }
}

/// Elements that Taylor-Hood is compared with.
const COMPARISON: [&str; 2] = ["mini", "bernardi-raugel"];

/// Refuses what comparison elements do not serve.
pub(crate) fn check_element(scene: &Scene, mixed: bool, faults: &mut Faults) {
    let solver = &scene.solver;
    let element = solver.element.as_str();
    if !COMPARISON.contains(&element) {
        return;
    }
    let mut refuse = |path: String, why: &str| {
        faults.unsupported(path, format!("`{element}` {why}"));
    };
    if !mixed {
        let path = "solver.element".to_owned();
        refuse(
            path,
            "serves mixed scenes: a Poisson ratio of at least 0.45",
        );
    }
    if let Some(obstacle) = scene.obstacles.first()
        && element != "mini"
    {
        let path = format!("obstacle.{}", obstacle.name);
        refuse(path, "serves scenes without contact; `mini` serves both");
    }
    if solver.verify {
        let path = "solver.verify".to_owned();
        refuse(path, "has no second path that recomputes its residuals");
    }
    if solver.tolerance_rule == ToleranceRule::Discretisation {
        let path = "solver.tolerance".to_owned();
        refuse(path, "has no estimate of its discretisation error");
    }
    if solver.penalty.is_some_and(|weight| weight > 0.0) {
        let path = "solver.penalty".to_owned();
        refuse(path, "has no grad-div term");
    }
    let methods = [
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
        ),
        ("saddle", &solver.saddle),
        ("contact", &solver.contact),
        ("contact_metric", &solver.contact_metric),
    ];
    for (key, _) in methods.iter().filter(|(_, method)| *method != "auto") {
        refuse(
            format!("solver.{key}"),
            "brings its own: leave it at `auto`",
        );
    }
}

/// Checks that the method for contact takes its metric and the supports.
pub(crate) fn check_contact(scene: &Scene, free_modes: &[String], faults: &mut Faults) {
    let Some(method) = ContactMethod::from_name(&scene.solver.contact) else {
        return;
    };
    let name = method.name();
    if let Some(metric) = MetricKind::from_name(&scene.solver.contact_metric)
        && !method.takes(metric)
    {
        let message = format!(
            "`{name}` scales by the `{}`, not by `{}`",
            method.natural_metric().name(),
            metric.name()
        );
        faults.add("solver.contact_metric", message);
    }
    if method.solves_without_contact() && !free_modes.is_empty() {
        let message = format!(
            "`{name}` solves for a given contact pressure, but supports leave {}; `one-level` is there",
            free_modes.join(", ")
        );
        faults.unsupported("solver.contact", message);
    }
}
