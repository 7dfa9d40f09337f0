//! From the methods that a plan names to the code that solves by them.

use crate::inequality::linear::ConjugateGradients;
use crate::inequality::mprgp::Mprgp;
use crate::inequality::{InequalitySolver, LinearSolver, OneLevel, QpProblem};
use crate::plan::Plan;
use crate::scene::{ContactMethod, SaddleMethod};

/// The method of programs without contact; none for those that serve contact too.
pub(crate) fn linear(plan: &Plan) -> Option<Box<dyn LinearSolver>> {
    match (plan.decisions.saddle.method, &plan.comparisons) {
        (SaddleMethod::ConjugateGradients, _) => Some(Box::new(ConjugateGradients)),
        (other, Some(comparisons)) => comparisons.linear(other),
        (_, None) => None,
    }
}

/// The solver of `problem` by the method for contact.
pub(crate) fn contact<'a>(plan: &Plan, problem: QpProblem<'a>) -> Box<dyn InequalitySolver + 'a> {
    match (plan.decisions.contact.method, &plan.comparisons) {
        (ContactMethod::Mprgp, _) => Box::new(Mprgp { problem }),
        (ContactMethod::OneLevel, _) | (_, None) => Box::new(OneLevel::new(problem)),
        (other, Some(comparisons)) => {
            let found = comparisons.contact(other, problem);
            found.unwrap_or_else(|| Box::new(OneLevel::new(problem)))
        }
    }
}
