//! What a plan is solved with: immutable, shared by all sessions with the same
//! [`crate::plan::PreparedKey`].

mod about;
mod approximate_inverse;
pub(crate) mod bodies;
mod chooser;
mod coarse_pressures;
mod deformed;
pub(crate) mod displacement;
mod element_chooser;
mod error;
pub(crate) mod moduli;
mod of_sessions;
pub(crate) mod p1;
mod pressure;
mod rings;
mod taylor_hood;
pub(crate) mod traces;

use std::sync::Arc;

use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::report::{CancelToken, Seconds};

pub(crate) use approximate_inverse::ApproximateInverse;
pub(crate) use deformed::Deformed;
use element_chooser::ComparisonData;
pub use error::PrepareError;
pub(crate) use taylor_hood::TaylorHoodData;

/// Prepared data.
#[derive(Debug)]
pub struct Prepared(PreparedBody);

/// By element.
#[derive(Clone, Debug)]
pub(crate) enum PreparedBody {
    /// The solver's own.
    TaylorHood(Arc<TaylorHoodData>),
    /// One that it is compared with.
    Comparison(Arc<ComparisonData>),
}

impl Prepared {
    /// Builds the data of `plan`.
    ///
    /// # Errors
    /// [`PrepareError`]; the token is polled between phases.
    pub fn build(
        plan: &Plan,
        mesh: &Arc<Mesh>,
        cancel: &CancelToken,
    ) -> Result<Self, PrepareError> {
        element_chooser::body(plan, mesh, cancel).map(Self)
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        match &self.0 {
            PreparedBody::TaylorHood(data) => data.bytes(),
            PreparedBody::Comparison(data) => data.bytes(),
        }
    }

    /// Wall seconds that building took; `prepare` is what is not named apart.
    pub fn seconds(&self) -> Seconds {
        match &self.0 {
            PreparedBody::TaylorHood(data) => data.seconds(),
            PreparedBody::Comparison(data) => data.seconds(),
        }
    }

    pub(crate) fn body(&self) -> PreparedBody {
        self.0.clone()
    }
}
