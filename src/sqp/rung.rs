//! A rung of the ladder and what is made for it: another plan for the same prepared data.

use crate::model::Model;
use crate::model::interfaces::Interfaces;
use crate::plan::Plan;
use crate::report::Fallback;

/// A rung, with what is made for it.
#[derive(Debug)]
pub(crate) struct Rung {
    /// Its name.
    pub(super) fallback: Fallback,
    /// The plan but for one decision.
    pub(super) plan: Plan,
    /// The surfaces with what that decision takes from them.
    pub(super) interfaces: Interfaces,
}

impl Rung {
    /// Makes a rung for the body of `model`. Cost: a pass over the contact faces, and the
    /// metric of the rung.
    pub(super) fn new(model: &Model<'_>, fallback: Fallback) -> Self {
        let plan = model.plan.on_rung(fallback);
        Self {
            fallback,
            interfaces: Interfaces::new(&plan, model.mesh, &model.prepared.space),
            plan,
        }
    }

    /// Bytes held beside the plan's own.
    pub(crate) fn bytes(&self) -> u64 {
        self.interfaces.metric.matrix.bytes()
    }
}
