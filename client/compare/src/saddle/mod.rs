//! Methods for the saddle point that GCR with the upper block triangle is compared
//! with: another block step, another preconditioner, nested iterations.

mod arrow_hurwicz;
mod block_diagonal;
mod uzawa;

pub(crate) use block_diagonal::BlockDiagonal;
pub(crate) use uzawa::Uzawa;

use arrow_hurwicz::Symmetric;
use signorini::comparisons::StepAbout;
use signorini::linalg::Workspace;
use signorini::saddle::BlockStep;
use signorini::scene::SaddleMethod;

/// The step of GCR about the internal pressure, from the first residuals; none for the
/// solver's own.
pub(crate) fn block_step(
    method: SaddleMethod,
    about: &StepAbout<'_>,
    work: &mut Workspace,
) -> Option<Box<dyn BlockStep>> {
    match method {
        SaddleMethod::ArrowHurwicz => Some(Box::new(Symmetric::new(
            about.displacement,
            about.pressure,
            (about.force, about.constraint),
            work,
        ))),
        SaddleMethod::ConjugateGradients
        | SaddleMethod::Stationary
        | SaddleMethod::Gcr
        | SaddleMethod::UzawaCg
        | SaddleMethod::Minres => None,
    }
}
