//! Numerical settings: ranges and names of methods.

use super::{Faults, names};
use crate::element::quadrature::MAXIMUM_DEGREE;
use crate::inequality::{ContactMethod, MetricKind};
use crate::scene::Scene;

/// Names that later capabilities bring.
const LATER: [&str; 7] = [
    "ic-cg",
    "hierarchical-ssor",
    "hierarchical-additive",
    "hierarchical-multiplicative",
    "arrow-hurwicz",
    "uzawa-cg",
    "minres",
];

/// Checks `[solver]`.
pub(crate) fn check(scene: &Scene, mixed: bool, faults: &mut Faults) {
    let solver = &scene.solver;
    if !(solver.tolerance >= 1e-14 && solver.tolerance <= 0.1) {
        let message = format!("must lie between 1e-14 and 0.1, not {}", solver.tolerance);
        faults.add("solver.tolerance", message);
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
    let saddle = if mixed { "gcr" } else { "cg" };
    let contact_methods = ContactMethod::ALL.map(ContactMethod::name);
    let contact_metrics = MetricKind::ALL.map(MetricKind::name);
    let methods = [
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
            &["p-multigrid"][..],
        ),
        ("p1_solver", &solver.p1_solver, &["cholesky", "amg"]),
        ("saddle", &solver.saddle, &[saddle]),
        ("contact", &solver.contact, &contact_methods),
        ("contact_metric", &solver.contact_metric, &contact_metrics),
    ];
    for (key, asked, available) in methods {
        let path = format!("solver.{key}");
        match asked.as_str() {
            "auto" => (),
            name if available.contains(&name) => (),
            name if LATER.contains(&name) || name == "cg" || name == "gcr" => {
                faults.unsupported(
                    path,
                    format!("`{name}` here; `{}` is there", available.join("`, `")),
                );
            }
            name => {
                let hint = names::hint(name, available.iter().copied().chain(["auto"]));
                faults.add(path, format!("unknown method `{name}`{hint}"));
            }
        }
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
