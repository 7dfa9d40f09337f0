//! Counts the applications of a preconditioner, for methods that apply it more
//! than once per iteration or inside a nested one.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::linalg::{Preconditioner, Workspace};

/// A preconditioner with a counter.
pub struct Counted<'a> {
    /// The preconditioner whose applications are counted.
    inner: &'a dyn Preconditioner,
    /// Applications so far.
    applications: AtomicU32,
}

impl<'a> Counted<'a> {
    /// Counts from zero.
    pub fn new(inner: &'a dyn Preconditioner) -> Self {
        Self {
            inner,
            applications: AtomicU32::new(0),
        }
    }

    /// Applications so far.
    pub fn applications(&self) -> u32 {
        self.applications.load(Ordering::Relaxed)
    }
}

impl Preconditioner for Counted<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        self.applications.fetch_add(1, Ordering::Relaxed);
        self.inner.apply(r, z, work);
    }
}
