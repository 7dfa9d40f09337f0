//! Methods for contact that one level and proportioning are compared with.
//!
//! | file | method | products with the compliance | sets |
//! |---|---|---|---|
//! | [`active_set`] | primal-dual active set, each set solved to the end | none | bounds |
//! | [`nested`] | projected steps in a metric that learns | one a step | all |
//! | [`projected_gradient`] | conjugate projected gradient | one to two | bounds |
//! | [`arrow_hurwicz`] | fixed projected steps in the metric | one a step | all |
//! | [`threshold`] | one level, Coulomb friction by given thresholds | none | all |
//! | [`regularised`] | one level, Coulomb friction by springs on the slip | none | all |

mod active_set;
mod arrow_hurwicz;
mod clip;
mod nested;
mod projected_gradient;
mod regularised;
mod threshold;

use active_set::ActiveSet;
use arrow_hurwicz::ProjectedArrowHurwicz;
use nested::Nested;
use projected_gradient::ConjugateProjectedGradient;
use regularised::RegularisedFriction;
use signorini::inequality::{InequalitySolver, QpProblem};
use signorini::scene::ContactMethod;
use threshold::ThresholdIteration;

/// The solver of `problem` by a method for contact; none for the solver's own.
pub(crate) fn contact<'a>(
    method: ContactMethod,
    problem: QpProblem<'a>,
) -> Option<Box<dyn InequalitySolver + 'a>> {
    Some(match method {
        ContactMethod::OneLevel | ContactMethod::Mprgp => return None,
        ContactMethod::ActiveSet => Box::new(ActiveSet::new(problem)),
        ContactMethod::Nested => Box::new(Nested { problem }),
        ContactMethod::ConjugateProjectedGradient => {
            Box::new(ConjugateProjectedGradient { problem })
        }
        ContactMethod::ProjectedArrowHurwicz => Box::new(ProjectedArrowHurwicz { problem }),
        ContactMethod::ThresholdIteration => Box::new(ThresholdIteration { problem }),
        ContactMethod::RegularisedFriction => Box::new(RegularisedFriction { problem }),
    })
}
