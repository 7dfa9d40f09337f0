//! The words of enum values: how scene files, result lines and tables spell what
//! travels as a number. A word is the value's name in the `.proto` file without
//! the prefix of its enum, in lower case.

use crate::v1;

fn word(name: &str, prefix: &str) -> String {
    name.strip_prefix(prefix)
        .unwrap_or(name)
        .to_ascii_lowercase()
}

/// The word of a termination, such as `not_converged`.
pub fn termination(termination: v1::Termination) -> String {
    word(termination.as_str_name(), "TERMINATION_")
}

/// The word of a cause, such as `line_search`; none when the step converged.
pub fn cause(cause: v1::Cause) -> Option<String> {
    let known = cause != v1::Cause::Unspecified;
    known.then(|| word(cause.as_str_name(), "CAUSE_"))
}

/// The word of a strategy, such as `snap_through`; none where the increment ended.
pub fn strategy(strategy: v1::Strategy) -> Option<String> {
    let known = strategy != v1::Strategy::Unspecified;
    known.then(|| word(strategy.as_str_name(), "STRATEGY_"))
}

/// The word of a kind of equilibrium; none where it was not found out.
pub fn stability(stability: v1::Stability) -> Option<String> {
    let known = stability != v1::Stability::Unspecified;
    known.then(|| word(stability.as_str_name(), "STABILITY_"))
}

/// The word of a tightness, such as `leaks`.
pub fn tightness(tightness: v1::Tightness) -> String {
    word(tightness.as_str_name(), "TIGHTNESS_")
}

/// The word of a field, such as `contact_pressure`.
pub fn field(field: v1::FieldName) -> String {
    word(field.as_str_name(), "FIELD_NAME_")
}

/// The word of a kind of scene as scene files spell it, such as `plane-strain`.
pub fn scene_kind(kind: v1::SceneKind) -> String {
    word(kind.as_str_name(), "SCENE_KIND_").replace('_', "-")
}

/// The word of a formulation.
pub fn formulation(formulation: v1::Formulation) -> String {
    word(formulation.as_str_name(), "FORMULATION_")
}
