//! What a session has learnt about its body on the way: makes the next increment
//! cheaper, is never part of a result, and may be dropped at any time between two
//! increments. The bits of what follows depend on whether it was.

use std::sync::Arc;

use super::condensation::kept::Known;
use super::factored_body::FactoredBody;
use super::known_duals::KnownDuals;
use super::lowest_mode::LowestMode;
use super::preconditioner_refresh::PreconditionerRefresh;
use super::push_stiffness::PushStiffness;
use super::saddle_layout::SaddleLayout;
use super::trend::Trend;
use crate::assembly::strain::Linearised;
use crate::krylov::gcr::Directions;
use crate::model::Model;
use crate::plan::Plan;

/// What the solver has learnt.
#[derive(Debug)]
pub(crate) struct Learned {
    /// Krylov directions of earlier programs; their products are without contact.
    pub(crate) directions: Directions,
    /// The approximate inverse in use, and what it costs.
    pub(crate) refresh: PreconditionerRefresh,
    /// The factor of the body that the last program made, with which later ones begin; none
    /// while iterations are cheaper.
    pub(crate) factored: Option<Arc<FactoredBody>>,
    /// Whether the factor of the body, once ordered, takes more than it may: the price of the plan
    /// is an estimate.
    pub(crate) factor_is_too_large: bool,
    /// The softest motion of the last equilibrium; none for linear bodies.
    pub(crate) lowest_mode: Option<LowestMode>,
    /// How the last parts moved the state; none for linear bodies.
    pub(crate) trend: Option<Trend>,
    /// What the last tangent was taken about, to be overwritten in place by the next;
    /// empty for linear bodies.
    pub(crate) linearised: Arc<Linearised>,
    /// What the saddle point is assembled and ordered by, once it was; it depends on the
    /// mesh only.
    layout: Option<Arc<SaddleLayout>>,
    /// How stiff the body is under the obstacles that are pushed; none before the first push.
    pub(crate) under_pushes: Option<PushStiffness>,
    /// What increments cost that converged.
    pub(crate) converged: Cost,
    /// How the body of a linear scene responds at its contact surface.
    pub(crate) response: Known,
    /// Dual solutions of the last increments.
    pub(crate) duals: KnownDuals,
}

/// Applications of some increments.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cost {
    /// Their sum.
    applications: u32,
    /// Number of increments.
    increments: u32,
}

impl Cost {
    /// One increment more.
    pub(crate) fn add(&mut self, applications: u32) {
        self.applications = self.applications.saturating_add(applications);
        self.increments = self.increments.saturating_add(1);
    }

    /// Applications an increment; none before the first one.
    pub(crate) fn mean(&self) -> Option<u32> {
        self.applications.checked_div(self.increments)
    }
}

impl Learned {
    /// Nothing yet.
    pub(crate) fn nothing(plan: &Plan) -> Self {
        Self {
            directions: plan.directions(),
            refresh: PreconditionerRefresh::default(),
            factored: None,
            factor_is_too_large: false,
            lowest_mode: None,
            trend: None,
            linearised: Arc::default(),
            layout: None,
            under_pushes: None,
            converged: Cost::default(),
            response: Known::Nothing,
            duals: KnownDuals::default(),
        }
    }

    /// Forgets what later bits depend on; what is a function of the body alone stays.
    pub(crate) fn forget(&mut self, plan: &Plan) {
        let (layout, response) = (self.layout.take(), std::mem::take(&mut self.response));
        *self = Self {
            layout,
            response,
            ..Self::nothing(plan)
        };
    }

    /// A copy of what later bits depend on.
    pub(crate) fn copy(&self) -> Self {
        Self {
            directions: self.directions.clone(),
            refresh: self.refresh.clone(),
            factored: self.factored.clone(),
            factor_is_too_large: self.factor_is_too_large,
            lowest_mode: self.lowest_mode.clone(),
            trend: self.trend.clone(),
            linearised: self.linearised.clone(),
            layout: None,
            under_pushes: self.under_pushes.clone(),
            converged: self.converged,
            response: Known::Nothing,
            duals: self.duals.clone(),
        }
    }

    /// Knows what a copy does, and what is a function of the body alone as before.
    pub(crate) fn take_up(&mut self, copy: &Self) {
        let (layout, response) = (self.layout.take(), std::mem::take(&mut self.response));
        *self = Self {
            layout,
            response,
            ..copy.copy()
        };
    }

    /// What the saddle point is assembled and ordered by, made when first asked for.
    pub(crate) fn layout(&mut self, model: &Model<'_>) -> Arc<SaddleLayout> {
        let new = || SaddleLayout::new(model).into();
        self.layout.get_or_insert_with(new).clone()
    }

    /// Whether the response of the body was made, or does not fit.
    pub(crate) fn has_tried_response(&self) -> bool {
        !matches!(self.response, Known::Nothing)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        self.directions.bytes()
            + self.refresh.bytes()
            + self.lowest_mode.as_ref().map_or(0, LowestMode::bytes)
            + self.trend.as_ref().map_or(0, Trend::bytes)
            + self.linearised.bytes()
            + self.layout.as_ref().map_or(0, |layout| layout.bytes())
            + self.factored.as_ref().map_or(0, |body| body.bytes())
            + self.response.bytes()
            + self.duals.bytes()
    }
}
