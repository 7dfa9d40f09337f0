//! How a stream is opened: one that drives its session, or one that watches it.

use std::time::Duration;

use signorini_proto::v1;

/// How long a broken connection is tried again unless it is said otherwise.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// How to attach to a session.
#[derive(Clone, Debug)]
pub struct Attach {
    /// Results after this event that the server still keeps are sent again;
    /// `None`: none is.
    pub last_seen_event: Option<i64>,
    /// Fields wanted with each result; empty: those of the scene.
    pub fields: Vec<v1::FieldName>,
    /// At most one iteration event in this time; `None`: as fast as they are read.
    pub iteration_interval: Option<Duration>,
    /// What a broken connection means for the step that runs. With
    /// `CANCEL_STEP` a break cancels it, and updates after it are sent again.
    pub on_disconnect: v1::DisconnectPolicy,
    /// How long the server waits for another connection before a break cancels; zero: not at
    /// all.
    pub disconnect_grace: Duration,
    /// How long a broken connection is tried again, with pauses of 50 ms that
    /// double to 2 s; zero: never. Results of a break have the fields of the
    /// scene's output only.
    pub patience: Duration,
}

impl Default for Attach {
    /// No earlier results, the scene's fields, [`PATIENCE`].
    fn default() -> Self {
        Self {
            last_seen_event: None,
            fields: Vec::new(),
            iteration_interval: None,
            on_disconnect: v1::DisconnectPolicy::Unspecified,
            disconnect_grace: Duration::ZERO,
            patience: PATIENCE,
        }
    }
}

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
    /// As in [`Attach::patience`].
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
