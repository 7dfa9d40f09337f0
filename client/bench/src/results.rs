//! What the report is made of, and its runs curve by curve.

use std::collections::BTreeSet;

use crate::extremes::Finding;
use crate::family::Family;
use crate::machine::Machine;
use crate::peers::{Peer, Peers};
use crate::plan::Place;
use crate::reference::References;
use crate::row::Row;

/// What figures are drawn from.
#[derive(Debug)]
pub(crate) struct Results {
    /// One a run of this program.
    pub(crate) rows: Vec<Row>,
    /// Runs of methods that are gone.
    pub(crate) recorded: Vec<Row>,
    /// One a row of the study of extreme cases.
    pub(crate) findings: Vec<Finding>,
    /// Runs of other programs.
    pub(crate) peers: Peers,
    /// Values and limits that errors are measured against.
    pub(crate) references: References,
    /// Where the rows come from.
    pub(crate) machine: Machine,
}

impl Results {
    /// Instruction sets that the rows name.
    pub(crate) fn instruction_sets(&self) -> String {
        let sets = self
            .rows
            .iter()
            .map(|row| row.numbers.instruction_set.as_str());
        let of_findings = self
            .findings
            .iter()
            .map(|found| found.instruction_set.as_str());
        let sets = sets.chain(of_findings);
        let sets: BTreeSet<&str> = sets.filter(|set| !set.is_empty()).collect();
        sets.into_iter().collect::<Vec<_>>().join(" and ")
    }

    /// Rows of a family, curve by curve, without methods that are not there.
    pub(crate) fn curves_of(&self, family: &Family) -> Vec<Vec<&Row>> {
        let mut curves: Vec<Vec<&Row>> = Vec::new();
        let rows = self.rows.iter();
        let rows = rows
            .filter(|row| row.case.place == Place::Chapter && !row.outcome.refuses_the_method());
        for row in rows.filter(|row| row.case.family.name == family.name) {
            let of_row = |curve: &&mut Vec<&Row>| {
                curve
                    .first()
                    .is_some_and(|first| first.case.is_curve_of(&row.case))
            };
            match curves.iter_mut().find(of_row) {
                Some(curve) => curve.push(row),
                None => curves.push(vec![row]),
            }
        }
        curves
    }

    /// Peers of a family, solver by solver.
    pub(crate) fn peers_of(&self, family: &Family) -> Vec<Vec<&Peer>> {
        let mut curves: Vec<Vec<&Peer>> = Vec::new();
        for peer in self
            .peers
            .rows
            .iter()
            .filter(|peer| peer.scene == family.name)
        {
            let same = |curve: &&mut Vec<&Peer>| {
                curve
                    .first()
                    .is_some_and(|first| first.solver == peer.solver)
            };
            match curves.iter_mut().find(same) {
                Some(curve) => curve.push(peer),
                None => curves.push(vec![peer]),
            }
        }
        curves
    }

    /// Small print: where the numbers come from; `peers` are those that are drawn.
    pub(crate) fn footer(&self, first: Option<String>, peers: &[Vec<&Peer>]) -> Vec<String> {
        let mut lines: Vec<String> = first.into_iter().collect();
        let repeats = self.rows.iter().map(|row| row.repeats).max().unwrap_or(1);
        let machine = self.machine.line(&self.instruction_sets());
        let runs = match repeats {
            1 => "one run each".to_owned(),
            repeats => format!("median of up to {repeats} runs"),
        };
        lines.push(format!("{machine}; {runs}."));
        if !peers.is_empty() {
            lines.push("Dashed: other solvers, measured elsewhere and before.".to_owned());
        }
        lines
    }
}
