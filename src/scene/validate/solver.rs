//! Numerical settings: ranges and names of methods.

use super::{Faults, names};
use crate::element::quadrature::MAXIMUM_DEGREE;
use crate::scene::Scene;

/// Names that later capabilities bring.
const LATER: [&str; 7] = [
    "mprgp",
    "conjugate-projected-gradient",
    "projected-arrow-hurwicz",
    "active-set",
    "nested",
    "mass",
    "fractional",
];
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
    let methods = [
        (
            "displacement_preconditioner",
            &solver.displacement_preconditioner,
            PRECONDITIONERS,
        ),
        ("p1_solver", &solver.p1_solver, P1_SOLVERS),
        ("saddle", &solver.saddle, SADDLES),
        ("contact", &solver.contact, &["one-level"][..]),
        ("contact_metric", &solver.contact_metric, &["compliance"]),
    ];
    for (key, asked, available) in methods {
        let path = format!("solver.{key}");
        match asked.as_str() {
            "auto" => (),
            name if available.contains(&name) => (),
            name if LATER.contains(&name) => {
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
    combinations(scene, formulated, faults);
    penalty(scene, formulated, faults);
}

fn ranges(scene: &Scene, faults: &mut Faults) {
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
    } else if weight > 0.0 && !formulated.incompressible {
        let message =
            "acts on the volume of incompressible materials; a Poisson ratio is below 0.5";
        faults.add(path, message);
    }
}
