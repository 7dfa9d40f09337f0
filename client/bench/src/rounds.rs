//! Measures the cases of a plan in rounds and keeps what each of them gave.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::error::BenchError;
use crate::measure::{Run, measure};
use crate::method::Method;
use crate::outcome::Outcome;
use crate::plan::{Case, Plan};
use crate::workshop::Workshop;

/// A case and its runs.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    pub(crate) case: Case,
    pub(crate) runs: Vec<Run>,
    /// Why it did not run; none when it did.
    pub(crate) left_out: Option<String>,
}

/// Measures cases until all have their repeats or the time is over.
#[derive(Debug)]
pub(crate) struct Rounds<'a> {
    workshop: &'a Workshop,
    program: PathBuf,
    plan: &'a Plan,
    started: Instant,
    measured: Vec<Measured>,
    /// Methods that the program refuses.
    refused: BTreeSet<Method>,
}

/// What a case's turn came to.
enum Turn {
    Ran(Box<Run>),
    LeftOut(&'static str),
    OutOfTime,
}

impl<'a> Rounds<'a> {
    /// `program` is run for each case.
    pub(crate) fn new(plan: &'a Plan, workshop: &'a Workshop, program: PathBuf) -> Self {
        let blank = |case: &Case| Measured {
            case: case.clone(),
            runs: Vec::new(),
            left_out: None,
        };
        Self {
            workshop,
            program,
            plan,
            started: Instant::now(),
            measured: plan.cases.iter().map(blank).collect(),
            refused: BTreeSet::new(),
        }
    }

    /// All rounds; `note` is told of each run. Dropping the future stops the run
    /// that is under way; what was measured stays.
    ///
    /// # Errors
    /// A scene or mesh file that is not there.
    pub(crate) async fn run(&mut self, note: impl Fn(&str)) -> Result<(), BenchError> {
        let rounds = self.plan.cases.iter().map(|case| case.repeats).max();
        for round in 1..=rounds.unwrap_or_default() {
            for index in 0..self.measured.len() {
                if self
                    .plan
                    .cases
                    .get(index)
                    .is_none_or(|case| case.repeats < round)
                {
                    continue;
                }
                if !self
                    .turn(index, &|line| note(&format!("round {round}: {line}\n")))
                    .await?
                {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// What was measured so far.
    pub(crate) fn into_measured(self) -> Vec<Measured> {
        let left = "not measured: the bench ended before";
        let mut measured = self.measured;
        for item in &mut measured {
            if item.runs.is_empty() && item.left_out.is_none() {
                item.left_out = Some(left.to_owned());
            }
        }
        measured
    }

    /// Gives one case its turn; false when the time is over.
    async fn turn(&mut self, index: usize, note: &impl Fn(&str)) -> Result<bool, BenchError> {
        let Some(item) = self.measured.get(index) else {
            return Ok(false);
        };
        let case = item.case.clone();
        match self.attempt(item, &case).await? {
            Turn::OutOfTime => Ok(false),
            Turn::LeftOut(reason) => {
                self.leave_out(index, reason);
                Ok(true)
            }
            Turn::Ran(run) => {
                let (name, word) = (case.name(), run.outcome.word());
                note(&format!("{name}: {word}, {:.3} s", run.numbers.seconds));
                self.keep(index, &case.method, *run);
                Ok(true)
            }
        }
    }

    async fn attempt(&self, item: &Measured, case: &Case) -> Result<Turn, BenchError> {
        if let Some(reason) = self.needless(item) {
            return Ok(Turn::LeftOut(reason));
        }
        let Some(left) = self.time_left() else {
            return Ok(Turn::OutOfTime);
        };
        let scene = self.workshop.scene(case.family)?;
        let mesh = self.workshop.mesh(case.family, case.level)?;
        let limit = case.run_limit.min(left);
        let run = measure(&self.program, case, (&scene, &mesh), limit).await;
        let cut_by_budget = run.outcome == Outcome::TimeLimit && limit < case.run_limit;
        Ok(if cut_by_budget {
            Turn::OutOfTime
        } else {
            Turn::Ran(Box::new(run))
        })
    }

    /// Why a case need not run (again).
    fn needless(&self, item: &Measured) -> Option<&'static str> {
        let failed = |run: &Run| run.outcome != Outcome::Converged;
        if item.runs.iter().any(failed) {
            return Some("failed before");
        }
        if self.refused.contains(&item.case.method) {
            return Some("the program refuses this method");
        }
        let smaller = self.measured.iter().filter(|other| {
            other.case.level < item.case.level && other.case.is_curve_of(&item.case)
        });
        let timed_out = |run: &Run| run.outcome == Outcome::TimeLimit;
        let mut runs = smaller.flat_map(|other| &other.runs);
        runs.any(timed_out)
            .then_some("a smaller mesh took too long")
    }

    fn time_left(&self) -> Option<Duration> {
        self.plan
            .budget
            .checked_sub(self.started.elapsed())
            .filter(|left| !left.is_zero())
    }

    fn leave_out(&mut self, index: usize, reason: &str) {
        if let Some(item) = self.measured.get_mut(index)
            && item.runs.is_empty()
        {
            item.left_out = Some(reason.to_owned());
        }
    }

    fn keep(&mut self, index: usize, method: &Method, run: Run) {
        if run.outcome.refuses_the_method() {
            self.refused.insert(method.clone());
        }
        if let Some(item) = self.measured.get_mut(index) {
            item.runs.push(run);
        }
    }
}
