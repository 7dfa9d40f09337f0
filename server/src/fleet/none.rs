//! A build that joins no fleet: nothing of these is ever made.

use std::sync::Arc;

use tokio::sync::mpsc;

use super::{Found, Wish, Wished};
use crate::config::Config;
use crate::fault::Fault;
use crate::journal::Journal;
use crate::watch::metrics::Metrics;

/// Other servers.
pub(crate) enum Fleet {}

/// What says that a session is this server's.
pub(crate) enum Lease {}

impl Fleet {
    /// # Errors
    /// What is wrong: any fleet.
    #[expect(clippy::unused_async, reason = "as that of a build which joins one")]
    pub(crate) async fn join(
        config: &Config,
        _url: &str,
        _journal: Option<&Arc<Journal>>,
        _metrics: &Arc<Metrics>,
    ) -> Result<Option<Arc<Self>>, String> {
        match config.fleet_nats.as_str() {
            "" => Ok(None),
            _ => Err("`fleet_nats` needs a build with the feature `fleet`".to_owned()),
        }
    }

    #[expect(clippy::unused_async, reason = "as that of a build which joins one")]
    pub(crate) async fn ask(&self, _name: &str, _wish: Wish) -> Result<Found, Fault> {
        match *self {}
    }

    #[expect(clippy::unused_async, reason = "as that of a build which joins one")]
    pub(crate) async fn wishes(&self) -> Option<mpsc::Receiver<Wished>> {
        match *self {}
    }

    pub(crate) fn lease(&self, _name: &str) -> Option<Arc<Lease>> {
        match *self {}
    }

    pub(crate) fn release(&self, _name: &str) {
        match *self {}
    }

    #[expect(clippy::unused_async, reason = "as that of a build which joins one")]
    pub(crate) async fn keep(&self, _lost: impl Fn(&str)) {
        match *self {}
    }
}

impl Lease {
    pub(crate) fn holds(&self) -> bool {
        match *self {}
    }
}
