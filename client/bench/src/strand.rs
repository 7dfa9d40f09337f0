//! Rows of a study, choice by choice.

use crate::family::Family;
use crate::results::Results;
use crate::row::Row;
use crate::study::{Origin, REFINED, STUDIES, Scope, Study};

/// The rows of one choice on one family, coarsest mesh first and loosest tolerance
/// first; those of refused and failed runs among them.
#[derive(Clone, Debug)]
pub(crate) struct Strand<'a> {
    pub(crate) label: &'static str,
    pub(crate) rows: Vec<&'a Row>,
    is_refused: bool,
}

impl<'a> Strand<'a> {
    /// Those that met their tolerance.
    pub(crate) fn converged(&self) -> impl DoubleEndedIterator<Item = &'a Row> {
        self.rows.iter().copied().filter(|row| row.converged())
    }

    /// Whether the program has this choice.
    pub(crate) fn is_known(&self) -> bool {
        !self.is_refused
    }

    /// What came of it where nothing converged.
    pub(crate) fn fate(&self) -> String {
        match self.rows.last() {
            _ if self.is_refused => "refused".to_owned(),
            None => "not measured".to_owned(),
            Some(row) => row.outcome.spoken(),
        }
    }
}

/// The strands of a scope, one a choice.
pub(crate) fn strands<'a>(results: &'a Results, study: &Study, scope: &Scope) -> Vec<Strand<'a>> {
    let choices = study.choices.iter();
    let each = choices.filter_map(|choice| {
        let method = choice.method()?;
        let source = match choice.origin {
            Origin::Run | Origin::Refined => &results.rows,
            Origin::Recorded => &results.recorded,
        };
        let fits = |row: &&Row| {
            let case = &row.case;
            let tolerance = |t: &f64| t.total_cmp(&case.tolerance).is_eq();
            case.family.name == scope.family
                && case.method == method
                && scope.full.contains(&case.level.number)
                && study.tolerances.iter().any(tolerance)
        };
        let mut rows: Vec<&Row> = source.iter().filter(fits).collect();
        rows.sort_by(|a, b| {
            let levels = a.case.level.cmp(&b.case.level);
            levels.then(b.case.tolerance.total_cmp(&a.case.tolerance))
        });
        // Once refused, a method is not tried again on other families.
        let refused = |row: &Row| row.case.method == method && row.outcome.refuses_the_method();
        Some(Strand {
            label: choice.label,
            rows,
            is_refused: source.iter().any(refused),
        })
    });
    joined(each)
}

impl Results {
    /// Runs of a family on meshes that the program refined itself; none where there were none.
    pub(crate) fn refined_of(&self, family: &Family) -> Option<Strand<'_>> {
        let scopes = STUDIES
            .iter()
            .flat_map(|study| study.scopes.iter().map(move |scope| (study, scope)));
        let own = scopes.filter(|(_, scope)| scope.family == family.name);
        let mut all = own.flat_map(|(study, scope)| strands(self, study, scope));
        all.find(|strand| strand.label == REFINED && !strand.rows.is_empty())
    }
}

/// Strands of the same label as one, by unknowns: several accuracies are one curve.
fn joined<'a>(each: impl Iterator<Item = Strand<'a>>) -> Vec<Strand<'a>> {
    let mut all: Vec<Strand<'a>> = Vec::new();
    for mut strand in each {
        match all.last_mut().filter(|last| last.label == strand.label) {
            Some(last) => {
                last.rows.append(&mut strand.rows);
                last.rows
                    .sort_by_key(|row| row.numbers.unknowns.iter().sum::<i64>());
            }
            None => all.push(strand),
        }
    }
    all
}
