//! What a plan is solved with: immutable, shared by all sessions with the same
//! [`super::PreparedKey`].

use std::sync::Arc;

use super::Plan;
use super::comparison::ComparisonData;
use super::prepared::{PrepareError, Prepared as TaylorHoodData};
use crate::mesh::Mesh;
use crate::report::{CancelToken, Seconds};

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
        Ok(Self(match plan.enrichment() {
            None => {
                let data = TaylorHoodData::build(plan, mesh, cancel)?;
                PreparedBody::TaylorHood(Arc::new(data))
            }
            Some(enrichment) => {
                let data = ComparisonData::build(plan, enrichment, mesh, cancel)?;
                PreparedBody::Comparison(Arc::new(data))
            }
        }))
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
