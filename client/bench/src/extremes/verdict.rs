//! Whether a result is what is known of the body.

use super::catalogue::{Expected, Trial};
use super::run::Lines;
use crate::measure::Outcome;

/// What is to be said of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// As it is known to be.
    Right,
    /// Converged, and nothing is known to compare it with.
    Unjudged,
    /// A result that differs from what is known, or an end that should not be, or none
    /// that should.
    Wrong,
    /// No result where there is one.
    Failed,
}

impl Verdict {
    /// For readers.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Unjudged => "not judged",
            Self::Wrong => "WRONG",
            Self::Failed => "FAILED",
        }
    }

    fn if_so(so: bool) -> Self {
        if so { Self::Right } else { Self::Wrong }
    }
}

/// The verdict and the relative error; `known` is what another row or program gives.
pub(super) fn of(
    trial: &Trial,
    outcome: &Outcome,
    lines: &Lines,
    known: Option<f64>,
) -> (Verdict, Option<f64>) {
    let found = lines.last(&trial.value);
    let against = |expected: Option<f64>, scale: f64| {
        let pair = found.zip(expected).filter(|_| is_converged(outcome));
        let error = pair.map(|(found, expected)| (found - expected).abs() / scale);
        (compared(outcome, error, trial.within), error)
    };
    let to = |expected: Option<f64>| against(expected, expected.map_or(1.0, f64::abs));
    match trial.expected() {
        Expected::Convergence => (unjudged(outcome), None),
        Expected::Number(number, scale) => against(Some(number), scale),
        Expected::Step(step) => to(lines.of_step(step, &trial.value)),
        Expected::Row(..) | Expected::Peer => to(known),
        Expected::Cause(causes, at) => ended(outcome, &causes, lines.last("/load").zip(at), trial),
        Expected::Warning(kinds) => {
            let said = lines.warnings().iter().any(|kind| kinds.contains(kind));
            (Verdict::if_so(said), None)
        }
        Expected::Stability(verdict) => match is_converged(outcome) {
            true => (Verdict::if_so(lines.word("stability") == verdict), None),
            false => (Verdict::Failed, None),
        },
        Expected::Refusal => (Verdict::if_so(matches!(outcome, Outcome::Refused(_))), None),
    }
}

fn is_converged(outcome: &Outcome) -> bool {
    *outcome == Outcome::Converged
}

fn unjudged(outcome: &Outcome) -> Verdict {
    match is_converged(outcome) {
        true => Verdict::Unjudged,
        false => Verdict::Failed,
    }
}

/// Without an error there is nothing to compare with.
fn compared(outcome: &Outcome, error: Option<f64>, within: f64) -> Verdict {
    match error {
        _ if !is_converged(outcome) => Verdict::Failed,
        None => Verdict::Unjudged,
        Some(error) => Verdict::if_so(error <= within),
    }
}

/// A step that must end early, and where.
fn ended(
    outcome: &Outcome,
    causes: &[String],
    load: Option<(f64, f64)>,
    trial: &Trial,
) -> (Verdict, Option<f64>) {
    let cause = outcome.detail().rsplit(", ").next().unwrap_or_default();
    let is_known = causes.iter().any(|known| known == cause);
    let error = load.map(|(found, at)| (found - at).abs() / at);
    match outcome {
        Outcome::NotConverged(_) => {
            let is_there = error.is_none_or(|error| error <= trial.within);
            (Verdict::if_so(is_known && is_there), error)
        }
        Outcome::Converged => (Verdict::Wrong, None),
        _ => (Verdict::Failed, None),
    }
}
