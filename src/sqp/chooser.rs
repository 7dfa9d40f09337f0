//! From the methods that a plan names to the code that solves by them.

use crate::compare;
use crate::inequality::mprgp::Mprgp;
use crate::inequality::{InequalitySolver, OneLevel, QpProblem};
use crate::linalg::{Preconditioner, Workspace};
use crate::saddle::{BlockStep, EqualityBlock};
use crate::scene::{ContactMethod, SaddleMethod};
use crate::sqp::linear::{ConjugateGradients, LinearSolver};

/// The method of programs without contact; none for those that serve contact too.
pub(crate) fn linear(method: SaddleMethod) -> Option<Box<dyn LinearSolver>> {
    match method {
        SaddleMethod::ConjugateGradients => Some(Box::new(ConjugateGradients)),
        SaddleMethod::Gcr
        | SaddleMethod::ArrowHurwicz
        | SaddleMethod::Stationary
        | SaddleMethod::UzawaCg
        | SaddleMethod::Minres => compare::linear(method),
    }
}

/// The step of GCR about the internal pressure, from the present residuals (force,
/// constraint); none for the upper block triangle.
pub(crate) fn block_step(
    method: SaddleMethod,
    displacement: &dyn Preconditioner,
    pressure: &EqualityBlock<'_>,
    now: (&[f64], &[f64]),
    work: &mut Workspace,
) -> Option<Box<dyn BlockStep>> {
    compare::block_step(method, displacement, pressure, now, work)
}

/// The solver of `problem` by a method for contact.
pub(crate) fn contact<'a>(
    method: ContactMethod,
    problem: QpProblem<'a>,
) -> Box<dyn InequalitySolver + 'a> {
    match method {
        ContactMethod::OneLevel => Box::new(OneLevel::new(problem)),
        ContactMethod::Mprgp => Box::new(Mprgp { problem }),
        ContactMethod::ActiveSet
        | ContactMethod::Nested
        | ContactMethod::ConjugateProjectedGradient
        | ContactMethod::ProjectedArrowHurwicz
        | ContactMethod::ThresholdIteration
        | ContactMethod::RegularisedFriction => {
            compare::contact(method, problem).unwrap_or_else(|| Box::new(OneLevel::new(problem)))
        }
    }
}
