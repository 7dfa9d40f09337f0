//! Who sees an increment while it runs, and what stops it.
//!
//! Polled once a Krylov iteration: a cancel, a deadline or the wall limit of the step ends
//! the increment at its last good state. The clock is read for limits and reports only, so
//! that no number of a result depends on it.

use crate::inequality::{QpNorms, QpScales};
use crate::linalg::vector::ratio;
use crate::model::counters::Counters;
use crate::report::{CancelToken, IterationRecord, Observer, Residuals, Termination};

/// Who watches, and what stops an increment.
pub(crate) struct Watch<'a> {
    /// Told of every Krylov iteration; must be quick.
    pub(crate) observer: &'a mut dyn Observer,
    /// Polled after every Krylov iteration; says whether to stop.
    pub(crate) cancel: &'a CancelToken,
    /// Wall seconds that the increment may take; what is left of the step's.
    pub(crate) seconds_left: Option<f64>,
    /// The record of the last iteration, filled anew for each.
    pub(crate) record: IterationRecord,
}

impl Watch<'_> {
    /// The same watch, lent.
    pub(crate) fn shared(&mut self) -> Watch<'_> {
        Watch {
            observer: self.observer,
            cancel: self.cancel,
            seconds_left: self.seconds_left,
            record: self.record.clone(),
        }
    }

    /// Tells the observer of one Krylov iteration.
    pub(crate) fn report(
        &mut self,
        norms: &QpNorms,
        scales: &QpScales,
        force_scale: f64,
        active: usize,
        counters: &Counters,
    ) {
        self.record.sqp_iteration = counters.sqp_iterations;
        self.record.krylov_iterations = counters.krylov_iterations;
        self.record.preconditioner_applications = counters.applications;
        self.record.attempt = counters.cut_backs;
        self.record.active_set_changes = counters.set_changes;
        self.record.active_vertices = active as u32;
        self.record.step_length = counters.step_length;
        self.record.seconds = counters.start.elapsed().as_secs_f64();
        self.record.residuals = Residuals {
            equilibrium: ratio(norms.force, force_scale),
            incompressibility: ratio(norms.constraint, scales.constraint),
            complementarity: 0.0,
            gap: ratio(norms.gap, scales.gap),
        };
        self.observer.iteration(&self.record);
    }

    /// Polls the token and the wall time.
    pub(crate) fn stopped(&self, counters: &Counters) -> Option<Termination> {
        let seconds = counters.start.elapsed().as_secs_f64();
        if self.seconds_left.is_some_and(|most| seconds > most) {
            self.cancel.expire();
        }
        self.cancel.stopped()
    }
}
