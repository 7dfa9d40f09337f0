//! Small matrices and a monitor for the tests of what works with them.

use signorini::krylov::{Monitor, Verdict};
use signorini::linalg::vector::norm;
use signorini::linalg::{Preconditioner, SparseRows, SparseRowsBuilder, Workspace};

/// A matrix from its rows.
pub(crate) fn rows<R: AsRef<[f64]>>(rows: &[R]) -> SparseRows {
    let mut builder = SparseRowsBuilder::new(rows[0].as_ref().len());
    for row in rows {
        let entries = row.as_ref().iter().enumerate();
        let mut entries: Vec<_> = entries.map(|(j, &value)| (j as u32, value)).collect();
        builder.push_row(&mut entries);
    }
    builder.finish()
}

/// A multiple of the identity.
pub(crate) struct Scaled(pub(crate) f64);

impl Preconditioner for Scaled {
    fn apply(&self, r: &[f64], z: &mut [f64], _work: &mut Workspace) {
        z.iter_mut().zip(r).for_each(|(z, r)| *z = self.0 * r);
    }
}

/// Stops where the norm of the residual is below a bound; counts.
pub(crate) struct Below {
    bound: f64,
    pub(crate) iterations: usize,
}

impl Below {
    pub(crate) fn new(bound: f64) -> Self {
        let iterations = 0;
        Self { bound, iterations }
    }
}

impl Monitor for Below {
    fn judge(&mut self, residual: &[f64]) -> Verdict {
        self.iterations += 1;
        if norm(residual) < self.bound {
            Verdict::Stop
        } else {
            Verdict::Continue
        }
    }
}
