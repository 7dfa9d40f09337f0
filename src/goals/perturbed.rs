//! The body with one parameter changed and the state held fast: what residuals and goals are
//! differentiated with.
//!
//! Units stay those of the plan, so that the numbers of the state mean the same. What a parameter
//! does not touch is borrowed. Cost: of a material the operators without their inverses, of a shape
//! the surfaces, of others nothing.

use crate::model::Model;
use crate::model::interfaces::Interfaces;
use crate::model::loads::reference_load;
use crate::model::state::State;
use crate::plan::Plan;
use crate::prepare::TaylorHoodData;

/// A body with a changed parameter.
pub(super) struct Perturbed<'a> {
    pub(super) base: &'a Model<'a>,
    plan: Option<Plan>,
    prepared: Option<TaylorHoodData>,
    pub(super) interfaces: Option<Interfaces>,
    load: Option<Vec<f64>>,
    pub(super) state: State,
}

impl<'a> Perturbed<'a> {
    /// The body as it is.
    pub(super) fn new(base: &'a Model<'a>, state: State) -> Self {
        Self {
            base,
            plan: None,
            prepared: None,
            interfaces: None,
            load: None,
            state,
        }
    }

    /// The changed body.
    pub(super) fn model(&self) -> Model<'_> {
        Model {
            plan: self.plan(),
            mesh: self.base.mesh,
            prepared: self.prepared.as_ref().unwrap_or(self.base.prepared),
            interfaces: self.interfaces.as_ref().unwrap_or(self.base.interfaces),
            load: self.load.as_deref().unwrap_or(self.base.load),
            conditions: self.base.conditions.clone(),
        }
    }

    fn plan(&self) -> &Plan {
        self.plan.as_ref().unwrap_or(self.base.plan)
    }

    /// A plan of its own.
    pub(super) fn plan_mut(&mut self) -> &mut Plan {
        let base = self.base.plan;
        self.plan.get_or_insert_with(|| base.clone())
    }

    /// The operators of the laws that its plan has.
    pub(super) fn prepare_laws(&mut self) {
        let prepared = self.base.prepared.with_laws(self.plan(), self.base.mesh);
        self.prepared = Some(prepared);
    }

    /// The loads that its plan has.
    pub(super) fn prepare_load(&mut self) {
        let load = reference_load(self.plan(), self.base.mesh, self.base.prepared);
        self.load = Some(load);
    }
}
