//! Methods for the saddle point that GCR with the upper block triangle is compared
//! with: another block step, another preconditioner, nested iterations.

mod arrow_hurwicz;
mod block_diagonal;
mod uzawa;

pub(crate) use block_diagonal::BlockDiagonal;
pub(crate) use uzawa::Uzawa;

use crate::linalg::{Preconditioner, Workspace};
use crate::saddle::{BlockStep, EqualityBlock};
use crate::scene::SaddleMethod;
use arrow_hurwicz::Symmetric;

/// The step of GCR about the internal pressure, from the first residuals (force,
/// constraint); none for the solver's own.
pub(crate) fn block_step(
    method: SaddleMethod,
    displacement: &dyn Preconditioner,
    pressure: &EqualityBlock<'_>,
    first: (&[f64], &[f64]),
    work: &mut Workspace,
) -> Option<Box<dyn BlockStep>> {
    match method {
        SaddleMethod::ArrowHurwicz => Some(Box::new(Symmetric::new(
            displacement,
            pressure,
            first,
            work,
        ))),
        SaddleMethod::ConjugateGradients
        | SaddleMethod::Stationary
        | SaddleMethod::Gcr
        | SaddleMethod::UzawaCg
        | SaddleMethod::Minres => None,
    }
}
