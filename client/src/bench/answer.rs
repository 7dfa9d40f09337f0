//! Answers to the questions of the studies, computed from their rows.
//!
//! Equal mesh: seconds and applications at the finest mesh where the default
//! converged. Equal error: seconds interpolated along each choice's curve, both
//! axes logarithmic, at the smallest error that two choices reach.

use super::figures::Results;
use super::row::Row;
use super::strand::{Strand, strands};
use super::study::{Measure, Scope, Study};

/// Choices within this share of the fastest are called as fast.
const AS_FAST: f64 = 1.1;
/// An error this close to the last one has arrived.
const ARRIVED: f64 = 0.02;

/// One sentence or more for each scope that has rows.
pub(crate) fn answers(results: &Results, study: &Study) -> Vec<String> {
    let scopes = study.scopes.iter();
    scopes
        .flat_map(|scope| {
            let strands = strands(results, study, scope);
            match study.measure {
                Measure::SameMesh | Measure::OneMesh | Measure::OtherProblem => {
                    same_mesh(scope, study.measure, &strands)
                }
                Measure::SameError => same_error(scope, &strands),
                Measure::Tolerance => tolerances(scope, &strands),
            }
        })
        .collect()
}

/// Seconds as sentences give them.
pub(crate) fn in_seconds(seconds: f64) -> String {
    let decimals = (2.0 - seconds.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{seconds:.decimals$} s")
}

/// A ratio as sentences give it.
pub(crate) fn times(ratio: f64) -> String {
    let decimals = usize::from(ratio < 9.95);
    format!("{ratio:.decimals$}\u{a0}×")
}

/// The default's row on the finest mesh that another choice was tried on too; on
/// its own finest mesh where nothing else is known.
fn common_row<'a>(strands: &[Strand<'a>]) -> Option<&'a Row> {
    let (ours, others) = strands.split_first()?;
    let tried = |row: &&Row| {
        let mut rows = others
            .iter()
            .filter(|strand| strand.is_known())
            .flat_map(|strand| &strand.rows);
        rows.any(|other| other.case.level == row.case.level)
    };
    let last = ours.converged().rfind(tried);
    last.or_else(|| ours.converged().next_back())
}

fn same_mesh(scope: &Scope, measure: Measure, strands: &[Strand<'_>]) -> Vec<String> {
    let Some(ours) = common_row(strands) else {
        return without_default(scope, strands);
    };
    let level = ours.case.level;
    let there = |strand: &Strand<'_>| -> Option<(&'static str, f64, i64)> {
        let row = strand.converged().find(|row| row.case.level == level)?;
        Some((strand.label, row.numbers.seconds, row.numbers.applications))
    };
    let mut here: Vec<_> = strands.iter().filter_map(there).collect();
    here.sort_by(|a, b| a.1.total_cmp(&b.1));
    let told: Vec<String> = here
        .iter()
        .map(|(label, seconds, applications)| {
            format!(
                "{label} {} ({applications} applications)",
                in_seconds(*seconds)
            )
        })
        .collect();
    let head = format!(
        "{} {level}, {:.0} unknowns: {}.",
        scope.family,
        ours.unknowns(),
        told.join(", ")
    );
    let rest = [
        match measure {
            Measure::OtherProblem => String::new(),
            Measure::SameMesh | Measure::SameError | Measure::OneMesh | Measure::Tolerance => {
                verdict(ours.numbers.seconds, &here)
            }
        },
        growth(strands),
        missing(strands, &here),
    ];
    vec![head + &rest.concat()]
}

/// Where the default has no result: what happened to each choice.
fn without_default(scope: &Scope, strands: &[Strand<'_>]) -> Vec<String> {
    let measured = strands.iter().filter(|strand| !strand.rows.is_empty());
    let told: Vec<String> = measured
        .map(|strand| match strand.converged().next_back() {
            Some(row) => format!("{} {}", strand.label, in_seconds(row.numbers.seconds)),
            None => format!("{}: {}", strand.label, strand.fate()),
        })
        .collect();
    match told.is_empty() {
        true => Vec::new(),
        false => vec![format!("{}: {}.", scope.family, told.join(", "))],
    }
}

/// Whether the default is the fastest.
fn verdict(ours: f64, here: &[(&'static str, f64, i64)]) -> String {
    match here {
        [] | [_] => String::new(),
        [(label, best, _), ..] if ours > AS_FAST * best => {
            format!(
                " {label} is faster than the default, {}.",
                times(ours / best)
            )
        }
        [.., (label, worst, _)] => {
            let ratio = times(worst / ours);
            format!(
                " No choice is faster than the default by a tenth; {label} takes {ratio} its time."
            )
        }
    }
}

/// How applications grow from the coarsest to the finest mesh.
fn growth(strands: &[Strand<'_>]) -> String {
    let ends = |strand: &Strand<'_>| -> Option<String> {
        let (first, last) = (strand.converged().next()?, strand.converged().next_back()?);
        let (from, to) = (first.case.level, last.case.level);
        let (low, high) = (first.numbers.applications, last.numbers.applications);
        (from != to).then(|| format!("{} {low} to {high} ({from} to {to})", strand.label))
    };
    let told: Vec<String> = strands.iter().filter_map(ends).collect();
    match told.is_empty() {
        true => String::new(),
        false => format!(" Applications under refinement: {}.", told.join(", ")),
    }
}

/// Choices that did not come to the common mesh, and why.
fn missing(strands: &[Strand<'_>], here: &[(&'static str, f64, i64)]) -> String {
    let absent = || {
        let strands = strands.iter();
        strands.filter(|strand| !here.iter().any(|known| known.0 == strand.label))
    };
    let refused: Vec<&str> = absent()
        .filter(|strand| !strand.is_known())
        .map(|strand| strand.label)
        .collect();
    let failed: Vec<String> = absent()
        .filter(|strand| strand.is_known() && !strand.rows.is_empty())
        .map(|strand| match strand.converged().next_back() {
            Some(row) => format!("{} (up to {})", strand.label, row.case.level),
            None => format!("{} ({})", strand.label, strand.fate()),
        })
        .collect();
    let mut text = String::new();
    if !failed.is_empty() {
        text.push_str(&format!(" Without a result there: {}.", failed.join(", ")));
    }
    if !refused.is_empty() {
        text.push_str(&format!(
            " Refused by this program: {}.",
            refused.join(", ")
        ));
    }
    text
}

fn same_error(scope: &Scope, strands: &[Strand<'_>]) -> Vec<String> {
    let Some(family) = scope.family() else {
        return Vec::new();
    };
    let quantities = family.quantities.iter();
    quantities
        .filter_map(|&quantity| {
            let curves: Vec<(&'static str, Vec<(f64, f64)>)> = strands
                .iter()
                .map(|strand| {
                    let point = |row: &Row| Some((row.error(quantity)?, row.numbers.seconds));
                    (strand.label, strand.converged().filter_map(point).collect())
                })
                .collect();
            let goal = shared_error(&curves)?;
            let told: Vec<String> = curves
                .iter()
                .zip(strands)
                .map(|((label, curve), strand)| match curve.is_empty() {
                    true => format!("{label} – ({})", strand.fate()),
                    false => format!("{label} {}", told_seconds(curve, goal)),
                })
                .collect();
            Some(format!(
                "{}, relative error {goal:.1e} of the {}: {}.",
                scope.family,
                quantity.label(),
                told.join(", ")
            ))
        })
        .collect()
}

/// The seconds that a curve takes to an error, in words.
fn told_seconds(curve: &[(f64, f64)], goal: f64) -> String {
    match (seconds_at(curve, goal), curve.first()) {
        (Some(seconds), _) => in_seconds(seconds),
        (None, Some(&(error, seconds))) if error < goal => format!(
            "at most {} (its coarsest mesh has {error:.1e})",
            in_seconds(seconds)
        ),
        (None, _) => "does not reach it".to_owned(),
    }
}

/// The smallest error that two curves reach.
fn shared_error(curves: &[(&'static str, Vec<(f64, f64)>)]) -> Option<f64> {
    let least = |curve: &Vec<(f64, f64)>| curve.iter().map(|point| point.0).reduce(f64::min);
    let mut best: Vec<f64> = curves
        .iter()
        .filter_map(|(_, curve)| least(curve))
        .collect();
    best.sort_by(f64::total_cmp);
    best.get(1).copied()
}

/// Seconds at an error, between two neighbouring points of a curve.
pub(crate) fn seconds_at(curve: &[(f64, f64)], goal: f64) -> Option<f64> {
    if let Some(exact) = curve.iter().find(|point| point.0.total_cmp(&goal).is_eq()) {
        return Some(exact.1);
    }
    let pairs = curve.iter().zip(curve.iter().skip(1));
    let mut around = pairs.filter(|(a, b)| a.0 > goal && b.0 <= goal);
    let (a, b) = around.next()?;
    let part = (a.0 / goal).ln() / (a.0 / b.0).ln();
    Some((a.1.ln() + part * (b.1 / a.1).ln()).exp())
}

fn tolerances(scope: &Scope, strands: &[Strand<'_>]) -> Vec<String> {
    let (Some(family), [plain, ..]) = (scope.family(), strands) else {
        return Vec::new();
    };
    let Some(&quantity) = family.quantities.first() else {
        return Vec::new();
    };
    let mut levels: Vec<_> = plain.rows.iter().map(|row| row.case.level).collect();
    levels.dedup();
    levels
        .into_iter()
        .filter_map(|level| {
            let rows: Vec<&Row> = plain
                .converged()
                .filter(|row| row.case.level == level)
                .collect();
            let last = rows.last().filter(|_| rows.len() > 2)?;
            let final_error = last.error(quantity)?;
            let arrived = |row: &&&Row| {
                let error = row.error(quantity).unwrap_or(f64::INFINITY);
                (error / final_error - 1.0).abs() <= ARRIVED
            };
            let first = rows.iter().find(arrived)?;
            let mut text = format!(
                "{} {level}: from tolerance {:e} on, the error of the {} is within {:.0} % of its last value; that takes {} where {:e} takes {}.",
                scope.family,
                first.case.tolerance,
                quantity.label(),
                100.0 * ARRIVED,
                in_seconds(first.numbers.seconds),
                last.case.tolerance,
                in_seconds(last.numbers.seconds),
            );
            for strand in strands.iter().skip(1) {
                let mut rows = strand.converged();
                let Some(row) = rows.find(|row| row.case.level == level) else {
                    continue;
                };
                let error = row.error(quantity)? / final_error;
                text.push_str(&format!(
                    " With {} it takes {} and ends at {error:.2} times that value.",
                    strand.label,
                    in_seconds(row.numbers.seconds)
                ));
            }
            Some(text)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_interpolated_along_a_power() {
        // Error 1/t: exact on logarithmic axes.
        let curve = [(1.0, 1.0), (0.1, 10.0), (0.01, 100.0)];
        assert!((seconds_at(&curve, 0.05).unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(seconds_at(&curve, 0.001), None);
        assert_eq!(seconds_at(&curve, 1.0), Some(1.0));
    }

    #[test]
    fn a_curve_below_the_error_is_told_by_its_coarsest_mesh() {
        let curve = [(1e-3, 2.0), (1e-4, 9.0)];
        assert_eq!(told_seconds(&curve, 5e-5), "does not reach it");
        let below = told_seconds(&curve, 1e-2);
        assert!(below.starts_with("at most 2.00 s"), "{below}");
    }

    #[test]
    fn the_shared_error_is_one_that_two_curves_reach() {
        let fine = ("fine", vec![(1e-2, 1.0), (1e-4, 9.0)]);
        let coarse = ("coarse", vec![(1e-1, 1.0), (1e-3, 9.0)]);
        let absent = ("absent", Vec::new());
        let curves = [fine, coarse, absent];
        assert_eq!(shared_error(&curves), Some(1e-3));
        assert_eq!(shared_error(&curves[..1]), None);
    }

    #[test]
    fn sentences_round_their_numbers() {
        assert_eq!(
            [in_seconds(0.0123), in_seconds(1.234), in_seconds(120.4)],
            ["0.012 s", "1.23 s", "120 s"]
        );
        assert_eq!([times(1.94), times(31.2)], ["1.9\u{a0}×", "31\u{a0}×"]);
    }
}
