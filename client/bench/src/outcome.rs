//! How a run ended, from its exit code and its lines.

use std::process::Output;

use serde_json::Value;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// With a result that meets its tolerance.
    Converged,
    /// With a result that does not; the termination, and the cause if there is one.
    NotConverged(String),
    /// Stopped by the limit of a run.
    TimeLimit,
    /// The scene is not accepted: a method that this build does not have, or too
    /// little memory. The message.
    Refused(String),
    /// Without a result. The message.
    Crashed(String),
}

impl Outcome {
    /// One word for the table.
    pub(crate) fn word(&self) -> &str {
        match self {
            Self::Converged => "converged",
            Self::NotConverged(_) => "not_converged",
            Self::TimeLimit => "time_limit",
            Self::Refused(_) => "refused",
            Self::Crashed(_) => "crashed",
        }
    }

    /// The word for readers.
    pub(crate) fn spoken(&self) -> String {
        self.word().replace('_', " ")
    }

    /// Whether the key of a method is what the scene is refused for.
    pub(crate) fn refuses_the_method(&self) -> bool {
        let key = self.detail().strip_prefix("solver.");
        let key = key.filter(|_| matches!(self, Self::Refused(_)));
        key.is_some_and(|key| !key.starts_with("tolerance"))
    }

    /// What there is to say beyond the word.
    pub(crate) fn detail(&self) -> &str {
        match self {
            Self::Converged | Self::TimeLimit => "",
            Self::NotConverged(detail) | Self::Refused(detail) | Self::Crashed(detail) => detail,
        }
    }
}

/// Exit code of scenes that are not accepted, and of quotas.
const REFUSALS: [i32; 2] = [4, 6];

/// What became of a process that printed no result.
pub(crate) fn without_result(output: &Output) -> Outcome {
    let stderr = String::from_utf8_lossy(&output.stderr);
    let message = stderr.lines().next().unwrap_or_default();
    let message = message.trim_start_matches("error: ").to_owned();
    match output.status.code() {
        Some(code) if REFUSALS.contains(&code) => Outcome::Refused(message),
        Some(code) => Outcome::Crashed(format!("exit code {code}: {message}")),
        None => Outcome::Crashed(format!("{}: {message}", output.status)),
    }
}

/// How an increment ended, by its line.
pub(crate) fn outcome(step: &Value) -> Outcome {
    match (word(step, "termination"), word(step, "cause")) {
        ("converged", _) => Outcome::Converged,
        (termination, "") => Outcome::NotConverged(termination.to_owned()),
        (termination, cause) => Outcome::NotConverged(format!("{termination}, {cause}")),
    }
}

/// A text of a line; empty where there is none.
pub(crate) fn word<'a>(line: &'a Value, key: &str) -> &'a str {
    line.get(key).and_then(Value::as_str).unwrap_or_default()
}
