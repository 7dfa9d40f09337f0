//! Who sees an increment while it runs, and what stops it.

use super::counters::Counters;
use super::evaluate::ratio;
use crate::inequality::{QpNorms, QpScales};
use crate::report::{CancelToken, IterationRecord, Observer, Residuals, Termination};

/// Who watches, and what stops an increment.
pub(crate) struct Watch<'a> {
    pub(crate) observer: &'a mut dyn Observer,
    pub(crate) cancel: &'a CancelToken,
    pub(crate) max_wall_time: Option<f64>,
    pub(crate) record: IterationRecord,
}

impl Watch<'_> {
    pub(super) fn report(
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
    pub(super) fn stopped(&self, counters: &Counters) -> Option<Termination> {
        let seconds = counters.start.elapsed().as_secs_f64();
        if self.max_wall_time.is_some_and(|most| seconds > most) {
            self.cancel.expire();
        }
        self.cancel.stopped()
    }
}
