//! What is bounded before it exists: messages that are received and decoded, plans,
//! uploads. Each gate has room for all clients together and less for one.

pub(crate) mod body;
mod cost;
mod decode;
mod layer;
mod plans;
mod uploads;

use std::sync::Arc;

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
    pub(crate) fn new(budget: u64, metrics: &Arc<Metrics>) -> Result<Self, prost::DecodeError> {
        Ok(Self {
            decode: Decode::new(budget, metrics)?,
            plans: Plans::new(),
            uploads: Uploads::new(budget, metrics),
        })
    }
}
