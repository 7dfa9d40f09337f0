//! What is known of a case when it is done.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use signorini_client::{ClientError, Refusal};
use signorini_proto::{v1, words};

/// A case that the solver, or a reader before it, does not take.
pub(crate) const REFUSED: &str = "refused";
/// A case that was given up: what solved it went away as often as it may.
pub(crate) const FAILED: &str = "failed";
/// The cause of a case whose server goes away without a reason.
const LOST: &str = "server_lost";
/// A case that gave its values.
pub(crate) const CONVERGED: &str = "converged";

/// The result of one case.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Row {
    pub(crate) case: u64,
    pub(crate) id: String,
    /// A word of results, [`REFUSED`] or [`FAILED`].
    pub(crate) termination: String,
    /// A word of results, or the reason of a refusal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) cause: Option<String>,
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) message: Option<String>,
    /// Times that it was begun.
    pub(crate) attempts: u32,
    pub(crate) increments: u32,
    /// Of the solver.
    pub(crate) seconds: f64,
    /// One for each that is wanted; none unless it converged.
    pub(crate) results: Vec<Value>,
}

impl Row {
    /// Of a case that gave no values.
    pub(crate) fn without(case: u64, id: &str, termination: &str) -> Self {
        Self {
            case,
            id: id.to_owned(),
            termination: termination.to_owned(),
            cause: None,
            message: None,
            attempts: 1,
            increments: 0,
            seconds: 0.0,
            results: Vec::new(),
        }
    }

    /// The same, saying why.
    #[must_use]
    pub(crate) fn because(mut self, cause: &str, message: impl Into<String>) -> Self {
        self.cause = Some(cause.to_owned());
        self.message = Some(message.into());
        self
    }

    /// The same after so many attempts.
    #[must_use]
    pub(crate) fn after(mut self, attempts: u32) -> Self {
        self.attempts = attempts;
        self
    }

    /// Adds the result of an increment.
    pub(crate) fn see(&mut self, report: &v1::StepReport) {
        self.increments += 1;
        self.seconds += report.seconds.unwrap_or_default().total;
        self.termination = words::termination(report.termination());
        self.cause = words::cause(report.cause());
    }

    /// Whether it has values.
    pub(crate) fn is_converged(&self) -> bool {
        self.termination == CONVERGED
    }
}

/// The reason and the text of what a server, or the way to it, said.
pub(crate) fn told(error: &ClientError) -> (String, String) {
    let reason = error.refusal().map(|refusal| refusal.reason.clone());
    let reason = reason.filter(|reason| !reason.is_empty());
    let text = error
        .refusal()
        .map_or_else(|| error.to_string(), violations);
    (reason.unwrap_or_else(|| LOST.to_owned()), text)
}

fn violations(refusal: &Refusal) -> String {
    if refusal.violations.is_empty() {
        return refusal.message.clone();
    }
    let all = refusal.violations.iter().map(ToString::to_string);
    all.collect::<Vec<_>>().join("; ")
}
