//! Methods that the solver is compared with: whether a plan has what its scene names.

use crate::comparisons::Comparisons;
use crate::scene::{
    Choice, ContactMethod, DisplacementMethod, Named, P1Solver, SaddleMethod, SceneError,
    SolverOptions, Violation,
};

/// Refuses methods to compare with where there are none.
///
/// # Errors
/// [`SceneError::Unsupported`] with the first of them.
pub(super) fn check(
    solver: &SolverOptions,
    comparisons: Option<&dyn Comparisons>,
) -> Result<(), SceneError> {
    match (asked_to_compare(solver), comparisons) {
        (Some((key, name)), None) => Err(SceneError::Unsupported(Violation {
            path: format!("solver.{key}"),
            message: format!(
                "`{name}` is there to compare with, and only in a `signorini` built with the \
                 feature `compare`"
            ),
        })),
        (None, _) | (_, Some(_)) => Ok(()),
    }
}

/// Key and name of the first method that is not the solver's own.
fn asked_to_compare(solver: &SolverOptions) -> Option<(&'static str, &'static str)> {
    let displacement = solver.displacement_preconditioner;
    let contact = [ContactMethod::OneLevel, ContactMethod::Mprgp];
    let saddle = [SaddleMethod::Gcr, SaddleMethod::ConjugateGradients];
    let asked = [
        compared(
            "displacement_preconditioner",
            displacement,
            &[DisplacementMethod::PMultigrid],
        ),
        compared(
            "p1_solver",
            solver.p1_solver,
            &[P1Solver::Direct, P1Solver::Amg],
        ),
        compared("saddle", solver.saddle, &saddle),
        compared("contact", solver.contact, &contact),
    ];
    asked.into_iter().flatten().next()
}

/// `key` and name of what is `asked` there and not in the solver's `own` list.
fn compared<T: Named>(
    key: &'static str,
    asked: Choice<T>,
    own: &[T],
) -> Option<(&'static str, &'static str)> {
    let other = asked.named().filter(|method| !own.contains(method));
    other.map(|method| (key, method.name()))
}
