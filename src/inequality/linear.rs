//! Linear systems: programs without contact,
//!
//! ```text
//! [ A  B^T ] [ du ]   [ f ]
//! [ B  -S  ] [ dx ] = [ g ],   the second row where there is an internal pressure,
//! ```
//!
//! behind one trait for the methods that know no inequality.

use super::QpTargets;
use crate::krylov::cg::Cg;
use crate::krylov::{Monitor, Outcome};
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::saddle::EqualityBlock;

/// A linear system.
#[derive(Clone, Copy)]
pub struct LinearSystem<'a> {
    /// A `[displacement, displacement]`.
    pub stiffness: &'a dyn LinearOperator,
    /// Approximate inverse of A.
    pub displacement: &'a dyn Preconditioner,
    /// The internal pressure as an equality block; none in displacement form.
    pub pressure: Option<&'a EqualityBlock<'a>>,
    /// When the system counts as solved.
    pub targets: QpTargets,
    /// Number of iterations at most.
    pub iterations: usize,
}

/// A method for linear systems.
pub trait LinearSolver {
    /// Improves (du, dx) until the monitor stops; the residuals (f, g) are those of
    /// the unknowns on entry and exit.
    fn solve(
        &self,
        system: &LinearSystem<'_>,
        unknowns: (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome;
}

/// Conjugate gradients on the displacement.
pub struct ConjugateGradients;

impl LinearSolver for ConjugateGradients {
    fn solve(
        &self,
        system: &LinearSystem<'_>,
        unknowns: (&mut [f64], &mut [f64]),
        monitor: &mut dyn Monitor,
        work: &mut Workspace,
    ) -> Outcome {
        let method = Cg {
            operator: system.stiffness,
            preconditioner: system.displacement,
            iterations: system.iterations,
        };
        method.solve(unknowns, monitor, work)
    }
}
