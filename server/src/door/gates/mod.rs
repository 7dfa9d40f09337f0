//! What is bounded before it exists: messages that are received and decoded, plans,
//! uploads. Each gate has room for all clients together and less for one.

pub(crate) mod body;
mod cost;
mod decode;
mod layer;
mod plans;
mod uploads;

use std::sync::Arc;
use std::time::Duration;

pub(crate) use decode::{Decode, WINDOW_BYTES};
pub(crate) use layer::GateMessages;
pub(crate) use plans::Plans;
pub(crate) use uploads::{UploadShare, Uploads};

use crate::watch::metrics::Metrics;

/// The gates of a server.
pub(crate) struct Gates {
    pub(crate) decode: Arc<Decode>,
    pub(crate) plans: Plans,
    pub(crate) uploads: Arc<Uploads>,
}

impl Gates {
    /// Gates of a byte budget; requests have to be there in `time`.
    pub(crate) fn new(
        budget: u64,
        time: Duration,
        metrics: &Arc<Metrics>,
    ) -> Result<Self, prost::DecodeError> {
        Ok(Self {
            decode: Decode::new(budget, time, metrics)?,
            plans: Plans::new(),
            uploads: Uploads::new(budget, metrics),
        })
    }
}
