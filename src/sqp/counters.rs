//! Counts and seconds of one increment.

use std::time::Instant;

use crate::report::Seconds;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Counters {
    pub(crate) sqp_iterations: u32,
    pub(crate) krylov_iterations: u32,
    /// Applications of the displacement preconditioner.
    pub(crate) applications: u32,
    /// Of those, apart: of the search for the softest motion.
    pub(crate) eigenvalue_applications: u32,
    /// Approximate inverses made anew.
    pub(crate) factorisations: u32,
    /// Products with the exact compliance, one inner solve each.
    pub(crate) contact_products: u32,
    pub(crate) set_changes: u32,
    pub(crate) cut_backs: u32,
    pub(crate) step_length: f64,
    pub(crate) seconds: Seconds,
    pub(crate) start: Instant,
}

impl Counters {
    pub(crate) fn new() -> Self {
        Self {
            sqp_iterations: 0,
            krylov_iterations: 0,
            applications: 0,
            eigenvalue_applications: 0,
            factorisations: 0,
            contact_products: 0,
            set_changes: 0,
            cut_backs: 0,
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
