//! Numerical settings: ranges, and methods that make no sense together.

use super::Faults;
use crate::element::quadrature::MAXIMUM_DEGREE;
use crate::scene::{
    Choice, DisplacementMethod, ErrorEstimate, MaterialModel, Named, P1Solver, SaddleMethod, Scene,
    ToleranceRule,
};

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
    combinations(scene, formulated, faults);
    penalty(scene, formulated, faults);
}

fn ranges(scene: &Scene, faults: &mut Faults) {
    let solver = &scene.solver;
    if !(solver.tolerance >= 1e-14 && solver.tolerance <= 0.1) {
        let message = format!("must lie between 1e-14 and 0.1, not {}", solver.tolerance);
        faults.add("solver.tolerance", message);
    }
    let is_estimated = solver.error_estimate != Choice::Named(ErrorEstimate::Off);
    if solver.tolerance_rule == ToleranceRule::Discretisation && !is_estimated {
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
    let has_contact = !scene.obstacles.is_empty() || !scene.contacts.is_empty();
    let mut refuse = |key: &str, name: &str, reason: &str| {
        faults.add(format!("solver.{key}"), format!("`{name}` {reason}"));
    };
    let (saddle, p1_solver) = (solver.saddle.named(), solver.p1_solver.named());
    if let Some(saddle) = saddle
        && let Some(reason) = misplaced(saddle, formulated.mixed, has_contact)
    {
        refuse("saddle", saddle.name(), reason);
    }
    let changing = DisplacementMethod::HierarchicalMultiplicative;
    let is_symmetric = solver.displacement_preconditioner != Choice::Named(changing);
    let fixed = saddle.filter(|&method| needs_a_fixed_preconditioner(method));
    if let Some(method) = fixed.filter(|_| !is_symmetric) {
        let name = method.name();
        let reason = format!("is not symmetric, which `{name}` needs; `gcr` does without");
        refuse("displacement_preconditioner", changing.name(), &reason);
    }
    if p1_solver != Some(P1Solver::IcCg) {
        return;
    }
    if let Some(method) = fixed {
        let name = method.name();
        let reason = format!("is not constant, which `{name}` needs; use `gcr`");
        refuse("p1_solver", P1Solver::IcCg.name(), &reason);
    }
    if has_contact {
        let reason = "gives no compliance of the contact surface; `cholesky` and `amg` do";
        refuse("p1_solver", P1Solver::IcCg.name(), reason);
    }
}

/// Whether a method of the linear systems bears only a preconditioner that is
/// symmetric and the same at every call.
fn needs_a_fixed_preconditioner(saddle: SaddleMethod) -> bool {
    match saddle {
        SaddleMethod::ConjugateGradients | SaddleMethod::Minres | SaddleMethod::UzawaCg => true,
        SaddleMethod::Gcr | SaddleMethod::Stationary | SaddleMethod::ArrowHurwicz => false,
    }
}

/// Why a method of the linear systems does not fit the unknowns.
fn misplaced(saddle: SaddleMethod, mixed: bool, has_contact: bool) -> Option<&'static str> {
    use SaddleMethod::{ArrowHurwicz, ConjugateGradients, Gcr, Minres, Stationary, UzawaCg};
    match (saddle, mixed, has_contact) {
        (ConjugateGradients | Stationary, true, _) => {
            Some("needs a positive definite system; a pressure unknown makes it a saddle point")
        }
        (ConjugateGradients | Stationary, false, true) => {
            Some("needs a positive definite system; contact pressure makes it a saddle point")
        }
        (ArrowHurwicz | UzawaCg | Minres, false, _) => {
            Some("needs a pressure unknown; every Poisson ratio is below 0.45")
        }
        (UzawaCg | Minres, true, true) => {
            Some("does not serve contact; `gcr` and `arrow-hurwicz` do")
        }
        (Gcr, _, _)
        | (ConjugateGradients | Stationary, false, false)
        | (ArrowHurwicz, true, _)
        | (UzawaCg | Minres, true, false) => None,
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

/// Checks that the method for contact takes its metric and the supports.
pub(crate) fn check_contact(scene: &Scene, free_modes: &[String], faults: &mut Faults) {
    let Some(method) = scene.solver.contact.named() else {
        return;
    };
    let name = method.name();
    if let Some(metric) = scene.solver.contact_metric.named()
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
