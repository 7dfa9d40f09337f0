//! Findings as a table, a figure and a sentence.

use super::catalogue::{Expected, Trial};
use super::peer;
use super::run::Finding;
use super::verdict::Verdict;
use crate::chart::{Dot, Lane, Lanes, Mark};
use crate::outcome::Outcome;
use crate::picture::Figure;
use crate::table::{Column, Table};
use crate::text::{NOTHING, in_seconds, told};

const COLUMNS: [Column; 10] = [
    Column::Group("family"),
    Column::Long("case"),
    Column::Long("known without this solver"),
    Column::Text("verdict"),
    Column::Long("end"),
    Column::Number("error"),
    Column::Number("applications"),
    Column::Number("seconds"),
    Column::Long("verdict on stability; falls; warnings"),
    Column::Long("other solvers"),
];

/// One line a finding.
pub(crate) fn table(findings: &[Finding]) -> Table {
    Table::new(COLUMNS).with(findings.iter().map(line))
}

fn line(found: &Finding) -> [String; 10] {
    let Trial {
        family,
        case,
        known,
        ..
    } = &found.trial;
    let applications = Some(found.applications).filter(|count| *count > 0);
    [
        family.clone(),
        case.clone(),
        known.clone(),
        found.verdict.word().to_owned(),
        end(&found.outcome),
        told(found.error, |error| format!("{error:.1e}")),
        told(applications, |count| count.to_string()),
        in_seconds(found.seconds),
        said(found),
        others(found),
    ]
}

/// How it ended, the cause without what goes without saying.
fn end(outcome: &Outcome) -> String {
    if let Outcome::NotConverged(detail) = outcome {
        return detail.rsplit(", ").next().unwrap_or(detail).to_owned();
    }
    outcome.to_string()
}

/// What the results say about themselves.
fn said(found: &Finding) -> String {
    let verdict = Some(found.stability.clone()).filter(|verdict| !verdict.is_empty());
    let mut parts: Vec<String> = verdict.into_iter().collect();
    parts.extend(match found.falls {
        0 => None,
        1 => Some("1 fall".to_owned()),
        falls => Some(format!("{falls} falls")),
    });
    let warnings = found.warnings.join(", ");
    parts.extend(Some(format!("warns: {warnings}")).filter(|_| !warnings.is_empty()));
    if parts.is_empty() {
        NOTHING.to_owned()
    } else {
        parts.join("; ").replace('_', " ")
    }
}

/// Runs of other programs on the same scene and mesh.
fn others(found: &Finding) -> String {
    let peers = peer::peers().unwrap_or_default();
    let of_row = peers.iter().filter(|peer| peer.row == found.trial.id);
    let told: Vec<String> = of_row.map(|peer| one(found, peer)).collect();
    if told.is_empty() {
        "not run".to_owned()
    } else {
        told.join("; ")
    }
}

fn one(found: &Finding, peer: &peer::Peer) -> String {
    let seconds = in_seconds(peer.seconds);
    let steps = peer.iterations.map(|count| format!(", {count} iterations"));
    let is_known = found.trial.expected() == Expected::Peer && peer.iterations.is_none();
    let error = match found.known {
        _ if is_known => "compared with".to_owned(),
        Some(known) => format!("error {:.1e}", known.error(peer.value)),
        None => format!("value {:.6e}", peer.value),
    };
    format!(
        "{}: {error}, {seconds}{}",
        peer.solver,
        steps.unwrap_or_default()
    )
}

/// How many rows came to what.
pub(crate) fn remark(findings: &[Finding]) -> String {
    let count = |verdict: Verdict| {
        let found = findings.iter().filter(|found| found.verdict == verdict);
        found.count()
    };
    format!(
        "{} rows: {} right, {} converged with nothing to judge them by, {} wrong, {} failed.",
        findings.len(),
        count(Verdict::Right),
        count(Verdict::Unjudged),
        count(Verdict::Wrong),
        count(Verdict::Failed)
    )
}

const ABOUT_FIGURE: &str = "One dot a row. Left: rows that are judged by a statement (a cause, a warning, a verdict on stability), or not judged. Crosses at the right end of the errors have no result.";

/// All findings as dots, family by family; nothing without any.
pub(crate) fn figure(findings: &[Finding], mut footer: Vec<String>) -> Option<Figure> {
    footer.insert(0, ABOUT_FIGURE.to_owned());
    let right = findings.iter().filter(|one| one.verdict == Verdict::Right);
    let judged = findings
        .iter()
        .filter(|one| one.verdict != Verdict::Unjudged);
    let picture = Lanes {
        title: format!(
            "Stiff and extreme cases: {} of {} as they must be",
            right.count(),
            judged.count()
        ),
        labels: ["a statement", "relative error", "seconds"].map(str::to_owned),
        marks: [
            "as it must be",
            "converged, nothing to judge it by",
            "wrong or failed",
        ]
        .map(str::to_owned),
        lanes: lanes(findings),
        footer,
    };
    (!findings.is_empty()).then(|| Figure {
        name: "study-extremes".to_owned(),
        svg: picture.svg(),
    })
}

/// One a family.
fn lanes(findings: &[Finding]) -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    for found in findings {
        let family = &found.trial.family;
        if lanes.last().is_none_or(|lane| lane.name != *family) {
            lanes.push(Lane {
                name: family.clone(),
                dots: Vec::new(),
            });
        }
        if let Some(lane) = lanes.last_mut() {
            lane.dots.push(dot(found));
        }
    }
    lanes
}

fn dot(found: &Finding) -> Dot {
    Dot {
        first: found.error,
        second: found.seconds.max(1e-3),
        mark: match found.verdict {
            Verdict::Right => Mark::Good,
            Verdict::Unjudged => Mark::Open,
            Verdict::Wrong | Verdict::Failed => Mark::Bad,
        },
        name: format!("{}: {}", found.trial.case, end(&found.outcome)),
    }
}

/// Titles of [`record`].
const TITLES: [&str; 14] = [
    "id",
    "family",
    "case",
    "known",
    "verdict",
    "outcome",
    "detail",
    "value",
    "error",
    "within",
    "applications",
    "seconds",
    "stability",
    "warnings",
];

/// The findings as a table for programs.
///
/// # Errors
/// A message; writing into memory does not fail.
pub(crate) fn csv(findings: &[Finding]) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let fault = |error: csv::Error| error.to_string();
    writer.write_record(TITLES).map_err(fault)?;
    for found in findings {
        writer.write_record(record(found)).map_err(fault)?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

fn record(found: &Finding) -> [String; 14] {
    let trial = &found.trial;
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    [
        trial.id.clone(),
        trial.family.clone(),
        trial.case.clone(),
        trial.known.clone(),
        found.verdict.word().to_lowercase(),
        found.outcome.word().to_owned(),
        found.outcome.detail().to_owned(),
        number(found.value),
        number(found.error),
        trial.within.to_string(),
        found.applications.to_string(),
        found.seconds.to_string(),
        found.stability.clone(),
        found.warnings.join(" "),
    ]
}

/// What the numbers of other programs say about themselves.
pub(crate) fn peers_about() -> Vec<String> {
    peer::about()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extremes::catalogue::trial;

    fn finding(verdict: Verdict, outcome: Outcome) -> Finding {
        Finding {
            trial: trial("2"),
            outcome,
            verdict,
            known: None,
            value: Some(2.0),
            error: Some(1e-9),
            applications: 12,
            seconds: 0.5,
            warnings: vec!["lost_digits".into()],
            stability: "minimum".into(),
            falls: 2,
            instruction_set: String::new(),
        }
    }

    #[test]
    fn every_row_says_how_it_ended_and_what_its_results_say() {
        let stopped = Outcome::NotConverged("not_converged, stagnation".into());
        let found = [
            finding(Verdict::Right, Outcome::Converged),
            finding(Verdict::Failed, stopped),
        ];
        let table = table(&found);
        let [good, bad] = [0, 1].map(|row| &table.rows()[row]);
        assert_eq!(
            (&*good[3], &*good[4], &*good[5]),
            ("right", "converged", "1.0e-9")
        );
        assert_eq!((&*bad[3], &*bad[4]), ("FAILED", "stagnation"));
        assert_eq!(good[8], "minimum; 2 falls; warns: lost digits");
        assert_eq!(good[9], "not run");
        let remark = remark(&found);
        assert!(remark.starts_with("2 rows: 1 right"), "{remark}");
        let text = String::from_utf8(csv(&found).unwrap()).unwrap();
        assert_eq!(text.lines().count(), 3);
    }

    #[test]
    fn the_figure_counts_what_is_judged() {
        let found = [
            finding(Verdict::Right, Outcome::Converged),
            finding(Verdict::Unjudged, Outcome::Converged),
            finding(Verdict::Wrong, Outcome::Converged),
        ];
        let figure = figure(&found, Vec::new()).unwrap();
        assert!(figure.svg.contains("1 of 2 as they must be"));
        assert!(super::figure(&[], Vec::new()).is_none());
    }
}
