//! One line for each call that changes something: who, what, how it ended.

use tonic::codegen::http::HeaderMap;
use tonic::{Code, Status};

use super::Caller;
use crate::client_key::ClientKey;
use crate::request_id::RequestId;

/// The line of a call, written when its outcome is known, or when it is dropped without one.
pub(super) struct Line {
    id: RequestId,
    client: ClientKey,
    caller: Option<Caller>,
    /// `SessionService/Solve`.
    what: String,
    is_written: bool,
}

impl Line {
    /// Of a call to `path`; no caller: one that was not let in.
    pub(super) fn new(
        id: RequestId,
        client: ClientKey,
        caller: Option<&Caller>,
        path: &str,
    ) -> Self {
        let what = path.rsplit_once('.').map_or(path, |(_, what)| what);
        Self {
            id,
            client,
            caller: caller.cloned(),
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
        if std::mem::replace(&mut self.is_written, true) {
            return;
        }
        // Without the span of the call, which is there at some levels of the log only.
        tracing::info!(
            target: "audit",
            parent: None,
            request = self.id.as_str(),
            who = %self.client,
            what = self.what,
            about = self.caller.as_ref().map_or("", Caller::about),
            outcome,
            "call"
        );
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.write("Left");
    }
}
