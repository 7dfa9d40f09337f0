//! What a plan is solved with: immutable, shared by all sessions with the same
//! [`crate::plan::PreparedKey`].

mod about;
mod approximate_inverse;
pub(crate) mod bodies;
mod coarse_pressures;
mod deformed;
pub(crate) mod displacement;
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
pub use error::PrepareError;
pub(crate) use taylor_hood::TaylorHoodData;

/// Prepared data.
#[derive(Debug)]
pub struct Prepared(Arc<TaylorHoodData>);

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
        let mesh = plan.body_mesh(mesh);
        let data = TaylorHoodData::build(plan, &mesh, cancel)?;
        Ok(Self(Arc::new(data)))
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.0.bytes()
    }

    /// Wall seconds that building took; `prepare` is what is not named apart.
    pub fn seconds(&self) -> Seconds {
        self.0.seconds()
    }

    /// The data themselves.
    pub(crate) fn data(&self) -> Arc<TaylorHoodData> {
        self.0.clone()
    }
}
