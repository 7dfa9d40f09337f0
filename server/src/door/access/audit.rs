//! One line for each call that changes something: who, what, how it ended.

use tonic::codegen::http::{Extensions, HeaderMap};
use tonic::{Code, Status};

use super::Caller;
use crate::door::client_key::ClientKey;
use crate::door::request_id::RequestId;

/// Who does something, in which call.
#[derive(Clone)]
pub(crate) struct Who {
    pub(super) id: RequestId,
    pub(super) client: ClientKey,
    /// Nobody: one that was not let in.
    pub(super) caller: Caller,
}

impl Who {
    /// That of a call which has passed the layer.
    pub(crate) fn of(extensions: &Extensions) -> Self {
        let found = extensions.get::<Self>().cloned();
        found.unwrap_or_else(|| Self {
            id: RequestId::of(extensions),
            client: ClientKey::UNKNOWN,
            caller: Caller::nobody(),
        })
    }

    /// Writes a line.
    pub(crate) fn did(&self, what: &str, outcome: &str) {
        // Without the span of the call, which is there at some levels of the log only.
        tracing::info!(
            target: "audit",
            parent: None,
            request = self.id.as_str(),
            who = %self.client,
            what,
            about = self.caller.about(),
            outcome,
            "call"
        );
    }
}

/// The line of a call, written when its outcome is known, or when it is dropped without one.
pub(super) struct Line {
    who: Who,
    /// `SessionService/Solve`.
    what: String,
    is_written: bool,
}

impl Line {
    /// Of a call to `path`.
    pub(super) fn new(who: Who, path: &str) -> Self {
        let what = path.rsplit_once('.').map_or(path, |(_, what)| what);
        Self {
            who,
            what: what.to_owned(),
            is_written: false,
        }
    }

    /// Writes the line if `headers` have the outcome.
    pub(super) fn see(&mut self, headers: &HeaderMap) {
        if let Some(code) = headers.get(Status::GRPC_STATUS) {
            let code = Code::from_bytes(code.as_bytes());
            self.write(&format!("{code:?}"));
        }
    }

    /// Writes the line once.
    pub(super) fn write(&mut self, outcome: &str) {
        if !std::mem::replace(&mut self.is_written, true) {
            self.who.did(&self.what, outcome);
        }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.write("Left");
    }
}
