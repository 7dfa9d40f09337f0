//! Counts and seconds of one increment.
//!
//! Counts are of the whole increment: parts that were given up, programs that led nowhere
//! and the certificate of stability included, so that seconds and counts belong together.

use std::time::Instant;

use crate::report::{Attempt, Seconds};

/// Counts and seconds of one increment; they are added up over its parts and its failed
/// attempts.
#[derive(Clone, Debug)]
pub(crate) struct Counters {
    /// Quadratic programs solved.
    pub(crate) sqp_iterations: u32,
    /// Krylov iterations.
    pub(crate) krylov_iterations: u32,
    /// Applications of the displacement preconditioner.
    pub(crate) applications: u32,
    /// Of those, apart: of the search for the softest motion.
    pub(crate) eigenvalue_applications: u32,
    /// Approximate inverses made anew at a deformed state.
    pub(crate) factorisations: u32,
    /// Products with the exact compliance, one inner solve each.
    pub(crate) contact_products: u32,
    /// Revisions of the active set.
    pub(crate) set_changes: u32,
    /// Steps of Newton's method for friction in dense problems.
    pub(crate) newton_steps: u32,
    /// Passes of the iteration on the threshold of friction.
    pub(crate) threshold_passes: u32,
    /// Solutions between which fluids have advanced.
    pub(crate) fluid_rounds: u32,
    /// Parts of the increment that were given up for smaller ones.
    pub(crate) cut_backs: u32,
    /// What failed, and what followed.
    pub(crate) attempts: Vec<Attempt>,
    /// Length of the last accepted step, in (0, 1].
    pub(crate) step_length: f64,
    /// Wall seconds by phase.
    pub(crate) seconds: Seconds,
    /// When the increment began, for the total and for the wall limit.
    pub(crate) start: Instant,
}

impl Counters {
    /// Counters at zero, their clock started.
    pub(crate) fn new() -> Self {
        Self {
            sqp_iterations: 0,
            krylov_iterations: 0,
            applications: 0,
            eigenvalue_applications: 0,
            factorisations: 0,
            contact_products: 0,
            set_changes: 0,
            newton_steps: 0,
            threshold_passes: 0,
            fluid_rounds: 0,
            cut_backs: 0,
            attempts: Vec::new(),
            step_length: 1.0,
            seconds: Seconds::default(),
            start: Instant::now(),
        }
    }
}

/// Runs `task` and adds its wall seconds to `slot`.
pub(crate) fn timed<T>(slot: &mut f64, task: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = task();
    *slot += start.elapsed().as_secs_f64();
    result
}
