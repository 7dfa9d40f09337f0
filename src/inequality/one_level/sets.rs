//! Active sets: the first one, the one that an iterate asks for next, and the
//! move from one to another.
//!
//! A choice costs one small dense problem, the first one of a body that nothing
//! touches an application of the displacement preconditioner besides.

use super::super::dense_qp;
use super::super::metric::nearest;
use super::super::qp::{QpIterate, QpOutcome};
use super::{OneLevel, SetRule};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, Workspace};

impl OneLevel<'_> {
    /// Moves to the set that the gaps ask for or, where they ask for none, that
    /// the load does: a body that only contact holds has no solution without.
    /// Returns whether the metric is positive definite.
    pub(super) fn choose_first_set(
        &self,
        iterate: &mut QpIterate,
        outcome: &mut QpOutcome,
        work: &mut Workspace,
    ) -> bool {
        let Some(first) = self.next_set(iterate) else {
            return false;
        };
        self.change_set(iterate, first, work);
        if iterate.gap.is_empty() || iterate.active.contains(&true) {
            return true;
        }
        outcome.predictions += 1;
        let mut move_by_load = work.zeros(iterate.force.len());
        let mut closing = work.zeros(iterate.gap.len());
        self.problem
            .displacement
            .apply(&iterate.force, &mut move_by_load, work);
        self.problem
            .coupling
            .apply(&move_by_load, &mut closing, work);
        let mut linear = iterate.gap.clone();
        add_scaled(&mut linear, -1.0, &closing);
        work.give(move_by_load);
        work.give(closing);
        let Ok(solution) = dense_qp::solve(self.problem.metric, &linear, &iterate.active) else {
            return false;
        };
        self.change_set(iterate, solution.free, work);
        true
    }

    /// The active set that the rule asks for at the current iterate.
    pub(super) fn next_set(&self, iterate: &QpIterate) -> Option<Vec<bool>> {
        if iterate.gap.is_empty() {
            return Some(Vec::new());
        }
        match self.rule {
            SetRule::DenseProblem => self.dense_set(iterate),
            SetRule::PrimalDual => Some(self.primal_dual_set(iterate)),
        }
    }

    fn primal_dual_set(&self, iterate: &QpIterate) -> Vec<bool> {
        let pairs = iterate.multiplier.iter().zip(&iterate.gap).enumerate();
        pairs
            .map(|(i, (l, gap))| self.problem.metric.at(i, i) * l > *gap)
            .collect()
    }

    /// The free set of the dense problem around the current iterate.
    fn dense_set(&self, iterate: &QpIterate) -> Option<Vec<bool>> {
        let solution = nearest(self.problem.metric, iterate).ok()?;
        Some(solution.free)
    }

    /// Moves to another set: multipliers that leave it become zero.
    pub(super) fn change_set(
        &self,
        iterate: &mut QpIterate,
        next: Vec<bool>,
        work: &mut Workspace,
    ) {
        let mut dropped = work.zeros(next.len());
        for (index, &stays) in next.iter().enumerate() {
            if !stays {
                dropped[index] = std::mem::take(&mut iterate.multiplier[index]);
            }
        }
        if dropped.iter().any(|&value| value != 0.0) {
            let mut force = work.scratch(iterate.force.len());
            self.problem
                .coupling
                .apply_transposed(&dropped, &mut force, work);
            add_scaled(&mut iterate.force, 1.0, &force);
            work.give(force);
        }
        work.give(dropped);
        iterate.active = next;
    }

    /// Whether what speaks against the current set is below the targets.
    pub(super) fn acceptable(&self, iterate: &QpIterate, bound: f64) -> bool {
        let mut square = 0.0;
        for (index, &active) in iterate.active.iter().enumerate() {
            let violation = match active {
                true => iterate.multiplier[index].min(0.0) * self.problem.metric.at(index, index),
                false => iterate.gap[index].min(0.0),
            };
            square += violation * violation;
        }
        square.sqrt() <= bound
    }
}
