//! When a factor of the body costs no more than iterations.

use super::{Plan, estimate};
use crate::scene::ContactMethod;

impl Plan {
    /// Krylov iterations that cost as much as a factor of the body with the compliance of its
    /// contact; none where the scene names a method or the factor is large.
    pub(crate) fn factor_cost(&self) -> Option<u32> {
        let takes_one =
            self.names_no_method() && self.decisions.contact.method == ContactMethod::OneLevel;
        let price = estimate::factor_cost(self.problem.units.dimension, self.problem.unknowns);
        price.filter(|_| takes_one)
    }

    /// Whether the scene names no method of linear systems or contact.
    pub(super) fn names_no_method(&self) -> bool {
        let options = &self.problem.scene.solver;
        options.contact.named().is_none()
            && options.contact_metric.named().is_none()
            && options.saddle.named().is_none()
            && options.p1_solver.named().is_none()
            && options.displacement_preconditioner.named().is_none()
    }
}
