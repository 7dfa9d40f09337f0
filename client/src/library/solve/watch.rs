//! The stream that follows a session without driving it.

use signorini_proto::v1;
use tokio::sync::mpsc;

use super::Events;
use super::options::WatchOptions;
use super::source::Kind;
use crate::library::connect::Client;
use crate::library::error::ClientError;

/// An open stream.
#[derive(Debug)]
pub struct Watch {
    /// What the server said when the stream was opened.
    pub opened: v1::StreamOpened,
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
