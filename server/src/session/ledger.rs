//! What a replay would have to do again, in counts that are the same in every run: where a
//! checkpoint is due follows from it.

use signorini::report::{StepReport, Termination};

/// What a replay may cost: about three quarters of a second on one core of 2020.
const MOST_COST: f64 = 1.5e7;
/// What a quadratic program costs beside its Krylov iterations, in applications of
/// the preconditioner.
const PROGRAM_COST: f64 = 20.0;
/// Results after a checkpoint, at most: those that a replay needs are kept.
pub(super) const MOST_RESULTS: usize = 1024;

/// What doing an increment again would take: unknowns times passes over them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost(f64);

impl Cost {
    /// By counts alone, so that it is the same in every run.
    pub(super) fn of(report: &StepReport) -> Self {
        let applications = f64::from(report.preconditioner_applications);
        let programs = f64::from(report.sqp_iterations);
        let unknowns = report.unknowns.displacement as f64;
        Self(unknowns * (applications + PROGRAM_COST * programs))
    }
}

/// What a replay would have to do again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ledger {
    cost: f64,
    results: usize,
    most_results: usize,
}

impl Ledger {
    /// Nothing yet, for a session that keeps so many results.
    pub(super) fn new(retained_results: usize) -> Self {
        Self {
            cost: 0.0,
            results: 0,
            most_results: retained_results.min(MOST_RESULTS),
        }
    }

    /// Whether a checkpoint is due after an increment.
    pub(super) fn is_due(&self, next: &Cost, termination: Termination) -> bool {
        match termination {
            // How far it came before its time was up, no replay finds again.
            Termination::DeadlineExceeded => true,
            // No replay repeats it.
            Termination::Cancelled | Termination::InternalError => false,
            Termination::Converged | Termination::NotConverged => {
                self.cost + next.0 > MOST_COST || self.results + 1 >= self.most_results
            }
        }
    }

    /// Whether it has grown beyond what any session leaves: the bytes are not a server's own.
    pub(super) fn is_endless(&self) -> bool {
        self.cost > 2.0 * MOST_COST
    }

    /// Counts a result, with a checkpoint after it or not; one that was stopped takes
    /// nothing.
    pub(super) fn count(&mut self, cost: Cost, is_checkpoint: bool) {
        if is_checkpoint {
            *self = Self::new(self.most_results)
        } else {
            self.cost += cost.0;
            self.results += 1;
        }
    }
}
