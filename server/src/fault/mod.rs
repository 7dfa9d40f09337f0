//! Everything that can be wrong with a request, as one closed set.
//!
//! | file | what it does |
//! |---|---|
//! | `status` | code, reason and details of each fault: the only place that makes a gRPC status |
//! | `retry` | when a refused client should come back |

pub(crate) mod retry;
pub(crate) mod status;

use signorini::scene::{SceneError, Violation};

/// A refused request.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Fault {
    #[error("{}", summary(.0))]
    SceneInvalid(Vec<Violation>),
    #[error("not supported yet: {0}")]
    Unsupported(Violation),
    /// A faulty field of a request that is not part of the scene.
    #[error("{0}")]
    RequestInvalid(Violation),
    #[error("{0}")]
    MeshInvalid(String),
    #[error("the arrays have the digest {computed}, the header says {declared}")]
    DigestMismatch { declared: String, computed: String },
    #[error("no mesh `{0}`; upload it first")]
    MeshNotFound(String),
    #[error("`{name}` is used by {sessions} sessions")]
    MeshInUse { name: String, sessions: usize },
    /// The steps do not converge on the mesh of the scene, or it cannot be refined.
    #[error("{0}")]
    RefinementFailed(String),
    #[error("surface: {0}")]
    SurfaceInvalid(String),
    #[error("no surface `{0}`; upload it first")]
    SurfaceNotFound(String),
    #[error("`{0}` is used by sessions")]
    SurfaceInUse(String),
    #[error("no session `{0}`")]
    SessionNotFound(String),
    /// Another server of the fleet has it, if that is known.
    #[error("`{name}` is at {}", holder(.owner))]
    SessionElsewhere { name: String, owner: String },
    #[error("`{0}` expired")]
    SessionExpired(String),
    #[error("`{0}` exists already")]
    SessionExists(String),
    /// Since Unix seconds.
    #[error("another stream writes to `{name}`")]
    SessionBusy { name: String, held_since: u64 },
    #[error("`{0}` was deleted")]
    SessionDeleted(String),
    #[error("`{name}` has failed: {why}")]
    SessionFailed {
        name: String,
        why: String,
        cause: FailureCause,
    },
    #[error("`{name}` has no result of sequence {sequence}")]
    StepNotFound { name: String, sequence: i64 },
    #[error("`{name}` has {newest} results; the client says that it has seen {seen}")]
    EventNotFound {
        name: String,
        seen: i64,
        newest: i64,
    },
    #[error("sequence {received} where {expected} is next")]
    SequenceGap { received: i64, expected: i64 },
    #[error("results of sequence {sequence} are dropped; {first} is the first kept")]
    SequenceNotRetained { sequence: i64, first: i64 },
    #[error("needs {predicted} bytes beside {held} in use, of a budget of {budget}")]
    MemoryBudget {
        predicted: u64,
        held: u64,
        budget: u64,
    },
    #[error("{limit} updates wait already")]
    QueueFull { limit: usize },
    #[error("{limit} sessions exist already; delete one")]
    SessionLimit { limit: usize },
    #[error("one client may make {limit} calls a second")]
    CallRate { limit: u32 },
    #[error("{what}: at most {limit} are allowed")]
    MessageLimit { what: String, limit: u64 },
    #[error("the deadline of the stream has passed")]
    StreamDeadline,
    #[error("the client has taken no message of the stream for {seconds} seconds")]
    StreamUnread { seconds: u64 },
    #[error("the server is shutting down")]
    ShuttingDown,
    /// The session is in the data folder and goes on with the next call.
    #[error("the server is shutting down; the session goes on when it is back")]
    Interrupted,
    /// The data folder takes nothing now; what was acknowledged is there.
    #[error("{0}")]
    Unwritable(String),
    #[error(
        "`{name}` cannot be read from the data folder: {why}; delete it and send its steps to a new \
         session, or restore a backup"
    )]
    SessionDamaged { name: String, why: String },
    /// What the data folder has of an upload is not what was written.
    #[error(
        "`{name}` in the data folder is not as it was written: {why}; send it again, or restore a \
         backup"
    )]
    UploadDamaged {
        kind: UploadKind,
        name: String,
        why: String,
    },
    #[error("no state `{0}` is kept here")]
    StateNotFound(String),
    /// Bytes that no session goes on from.
    #[error("{0}")]
    StateInvalid(String),
    /// One text for all of it: whoever guesses learns nothing.
    #[error(
        "this server asks for a token that it knows: `--token-file FILE` or SIGNORINI_TOKEN for \
         clients, `signorini token add` on the server"
    )]
    Unauthenticated,
    #[error("this needs the role {needed}; the token has {role}")]
    PermissionDenied {
        role: &'static str,
        needed: &'static str,
    },
    #[error("a defect of the server; its log says more")]
    Internal,
}

/// What clients upload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UploadKind {
    Mesh,
    Surface,
    State,
}

impl UploadKind {
    /// The word of metrics.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Surface => "surface",
            Self::State => "state",
        }
    }
}

/// What a session has failed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FailureCause {
    /// The system had no memory for it: another time it may.
    Memory,
    Other,
}

/// How a message names the holder of a session.
fn holder(owner: &str) -> &str {
    match owner {
        "" => "another server, or at none for a while",
        owner => owner,
    }
}

fn summary(all: &[Violation]) -> String {
    let first = all.first().map_or_else(String::new, ToString::to_string);
    match all.len() {
        0 | 1 => first,
        count => format!("{first} (and {} more)", count - 1),
    }
}

impl Fault {
    /// A faulty field of a request.
    pub(crate) fn request(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self::RequestInvalid(violation(path, message))
    }

    /// A capability that is not there yet.
    pub(crate) fn unsupported(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Unsupported(violation(path, message))
    }
}

impl From<SceneError> for Fault {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Invalid(violations) => Self::SceneInvalid(violations),
            SceneError::Unsupported(violation) => Self::Unsupported(violation),
        }
    }
}

pub(crate) fn violation(path: impl Into<String>, message: impl Into<String>) -> Violation {
    Violation {
        path: path.into(),
        message: message.into(),
    }
}
