//! The stream that follows a session without driving it.

use std::time::Duration;

use signorini_proto::v1;
use tokio::sync::mpsc;

use super::source::Kind;
use super::{Events, PATIENCE};
use crate::connect::Client;
use crate::error::ClientError;

/// How to watch a session.
#[derive(Clone, Debug)]
pub struct WatchOptions {
    /// Results after this event that the server still keeps come first; `None`:
    /// none does.
    pub last_seen_event: Option<i64>,
    /// Fields wanted with each result; empty: those of the scene.
    pub fields: Vec<v1::FieldName>,
    /// At most one iteration event in this time; `None`: as fast as they are read.
    pub iteration_interval: Option<Duration>,
    /// When the stream ends well.
    pub until: v1::WatchEnd,
    /// As in [`super::Attach::patience`].
    pub patience: Duration,
}

impl Default for WatchOptions {
    /// From the first kept result to the end of the session, with [`PATIENCE`].
    fn default() -> Self {
        Self {
            last_seen_event: Some(0),
            fields: Vec::new(),
            iteration_interval: None,
            until: v1::WatchEnd::Session,
            patience: PATIENCE,
        }
    }
}

/// An open stream.
#[derive(Debug)]
pub struct Watch {
    /// What the server said when the stream was opened.
    pub opened: v1::Opened,
    /// Receives results, statistics and heartbeats; goes on over broken
    /// connections as that of [`super::Solve`] does. Dropping it stops watching,
    /// never a step.
    pub events: Events,
}

impl Client {
    /// Follows a session, by its identifier or name, without writing to it.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND` and others;
    /// [`ClientError::Silent`].
    pub async fn watch(&self, session: &str, options: WatchOptions) -> Result<Watch, ClientError> {
        // Nobody has orders.
        let (_, orders) = mpsc::channel(1);
        let kind = Kind::Watch(options);
        let (opened, events) = self.follow(session, kind, orders).await?;
        Ok(Watch { opened, events })
    }
}
