//! Whether a result is what is known of the body.

use super::catalogue::{Expected, Trial};
use super::lines::{Known, Lines};
use crate::outcome::Outcome;

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

/// The verdict and the relative error.
pub(super) fn of(
    trial: &Trial,
    outcome: &Outcome,
    lines: &Lines,
    known: Option<Known>,
) -> (Verdict, Option<f64>) {
    match trial.expected() {
        Expected::Convergence => (unjudged(outcome), None),
        Expected::Number(..) | Expected::Step(_) | Expected::Row(..) | Expected::Peer => {
            let found = lines.last(&trial.value).filter(|_| is_converged(outcome));
            let error = found.zip(known).map(|(found, known)| known.error(found));
            (compared(outcome, error, trial.within), error)
        }
        Expected::Cause(causes, at) => ended(outcome, &causes, lines.last("/load").zip(at), trial),
        Expected::Warning(_) if !is_converged(outcome) => (Verdict::Failed, None),
        Expected::Warning(kinds) | Expected::Said(kinds) => {
            let said = lines.warnings().iter().any(|kind| kinds.contains(kind));
            let unsaid = if is_converged(outcome) {
                Verdict::Wrong
            } else {
                Verdict::Failed
            };
            (if said { Verdict::Right } else { unsaid }, None)
        }
        Expected::Stability(verdict) => {
            if is_converged(outcome) {
                (Verdict::if_so(lines.word("stability") == verdict), None)
            } else {
                (Verdict::Failed, None)
            }
        }
        Expected::Refusal => (Verdict::if_so(matches!(outcome, Outcome::Refused(_))), None),
    }
}

fn is_converged(outcome: &Outcome) -> bool {
    *outcome == Outcome::Converged
}

fn unjudged(outcome: &Outcome) -> Verdict {
    if is_converged(outcome) {
        Verdict::Unjudged
    } else {
        Verdict::Failed
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
        Outcome::TimeLimit | Outcome::Refused(_) | Outcome::Crashed(_) => (Verdict::Failed, None),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::extremes::catalogue::trial;

    const CONVERGED: Outcome = Outcome::Converged;

    /// The verdict on a last result whose energy is 2 and that warns of a fall.
    fn on(expected: &str, outcome: &Outcome, known: Option<f64>) -> (Verdict, Option<f64>) {
        let line = json!({
            "strain_energy": 2.0,
            "load": 0.8,
            "stability": "minimum",
            "warnings": [{"kind": "snapped"}],
        });
        let known = known.map(Known::of);
        of(&trial(expected), outcome, &Lines::of(vec![line]), known)
    }

    #[test]
    fn a_number_is_right_within_its_bound() {
        assert_eq!(on("2", &CONVERGED, Some(2.0)), (Verdict::Right, Some(0.0)));
        assert_eq!(on("4", &CONVERGED, Some(4.0)), (Verdict::Wrong, Some(0.5)));
        assert_eq!(on("row a", &CONVERGED, None), (Verdict::Unjudged, None));
        let stopped = Outcome::NotConverged("not_converged, stagnation".into());
        assert_eq!(on("2", &stopped, Some(2.0)), (Verdict::Failed, None));
        assert_eq!(on("", &Outcome::TimeLimit, None), (Verdict::Failed, None));
        assert_eq!(on("", &CONVERGED, None), (Verdict::Unjudged, None));
    }

    #[test]
    fn an_end_that_must_be_is_right_and_another_one_is_not() {
        let ended = |cause: &str| Outcome::NotConverged(format!("not_converged, {cause}"));
        let full = ended("enclosed_volume");
        let verdict = |expected, outcome: &Outcome| on(expected, outcome, None).0;
        let expected = "cause enclosed_volume|no_equilibrium";
        assert_eq!(verdict(expected, &full), Verdict::Right);
        assert_eq!(verdict(expected, &ended("stagnation")), Verdict::Wrong);
        assert_eq!(verdict(expected, &CONVERGED), Verdict::Wrong);
        assert_eq!(verdict(expected, &Outcome::TimeLimit), Verdict::Failed);
        assert_eq!(
            verdict("cause enclosed_volume at 0.8", &full),
            Verdict::Right
        );
        assert_eq!(
            verdict("cause enclosed_volume at 0.4", &full),
            Verdict::Wrong
        );
        assert_eq!(verdict("refused", &CONVERGED), Verdict::Wrong);
        assert_eq!(
            verdict("refused", &Outcome::Refused(String::new())),
            Verdict::Right
        );
    }

    #[test]
    fn statements_are_looked_for_in_the_results() {
        let verdict = |expected| on(expected, &CONVERGED, None).0;
        assert_eq!(verdict("warning passed_through|snapped"), Verdict::Right);
        assert_eq!(verdict("warning lost_digits"), Verdict::Wrong);
        let stopped = Outcome::NotConverged("not_converged, stagnation".into());
        let stopped = |expected| on(expected, &stopped, None).0;
        assert_eq!(stopped("warning snapped"), Verdict::Failed);
        assert_eq!(stopped("said snapped"), Verdict::Right);
        assert_eq!(verdict("stability minimum"), Verdict::Right);
        assert_eq!(verdict("stability saddle"), Verdict::Wrong);
    }
}
