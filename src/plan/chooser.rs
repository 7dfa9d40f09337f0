//! What a plan must know of the methods that the solver is compared with: whether they
//! are there, and how many unknowns their elements have.

use crate::compare;
use crate::mesh::Mesh;
use crate::scene::{
    Choice, ContactMethod, DisplacementMethod, ElementKind, Named, P1Solver, SaddleMethod,
    SceneError, SolverOptions, Violation,
};

/// Displacement and pressure unknowns of `element` on `mesh`; none for Taylor-Hood.
pub(crate) fn unknowns(element: ElementKind, mesh: &Mesh) -> Option<(usize, usize)> {
    compare::unknowns(element, mesh)
}

/// Refuses methods that this binary is built without.
///
/// # Errors
/// [`SceneError::Unsupported`] with the first of them.
pub(crate) fn check(solver: &SolverOptions) -> Result<(), SceneError> {
    match asked_to_compare(solver) {
        Some((key, name)) if !compare::IS_BUILT => Err(SceneError::Unsupported(Violation {
            path: format!("solver.{key}"),
            message: format!("`{name}`, a method to compare with, is not built into this binary"),
        })),
        Some(_) | None => Ok(()),
    }
}

/// Key and name of the first method that is not the solver's own.
fn asked_to_compare(solver: &SolverOptions) -> Option<(&'static str, &'static str)> {
    let displacement = solver.displacement_preconditioner;
    let contact = [ContactMethod::OneLevel, ContactMethod::Mprgp];
    let saddle = [SaddleMethod::Gcr, SaddleMethod::ConjugateGradients];
    let asked = [
        compared("element", solver.element, &[ElementKind::TaylorHood]),
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
