//! Numerical settings: ranges and names of methods.

use super::{Faults, names};
use crate::element::quadrature::MAXIMUM_DEGREE;
use crate::scene::{Scene, ToleranceRule};

/// Names that later capabilities bring.
const LATER: [&str; 14] = [
    "ic-cg",
    "hierarchical-ssor",
    "hierarchical-additive",
    "hierarchical-multiplicative",
    "arrow-hurwicz",
    "uzawa-cg",
    "minres",
    "mprgp",
    "conjugate-projected-gradient",
    "projected-arrow-hurwicz",
    "active-set",
    "nested",
    "mass",
    "fractional",
];

/// Checks `[solver]`.
pub(crate) fn check(scene: &Scene, mixed: bool, faults: &mut Faults) {
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
    let saddle = if mixed { "gcr" } else { "cg" };
    let methods = [
        (
            "element",
            &solver.element,
            &["taylor-hood", "mini", "bernardi-raugel"][..],
        ),
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
            &["p-multigrid"][..],
        ),
        ("p1_solver", &solver.p1_solver, &["cholesky", "amg"]),
        ("saddle", &solver.saddle, &[saddle]),
        ("contact", &solver.contact, &["one-level"]),
        ("contact_metric", &solver.contact_metric, &["compliance"]),
        ("error_estimate", &solver.error_estimate, &["off"]),
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
    let methods = [
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
        ),
        ("saddle", &solver.saddle),
    ];
    for (key, _) in methods.iter().filter(|(_, method)| *method != "auto") {
        refuse(
            format!("solver.{key}"),
            "brings its own: leave it at `auto`",
        );
    }
}
