//! What the solver is compared with: methods that a scene may name beside those of the library.
//!
//! | key of a scene | names | room |
//! |---|---|---|
//! | `solver.displacement_preconditioner` | `hierarchical-ssor`, `hierarchical-multiplicative`, `hierarchical-additive` | `precond` |
//! | `solver.p1_solver` | `ic-cg` | `precond` |
//! | `solver.saddle` | `arrow-hurwicz`, `uzawa-cg`, `minres`, `stationary` | `saddle`, `krylov`, `linear` |
//! | `solver.contact` | `active-set`, `nested`, `conjugate-projected-gradient`, `projected-arrow-hurwicz`, `threshold-iteration`, `regularised-friction` | `contact` |
//!
//! [`Methods`] is what [`Plan::with_comparisons`](signorini::Plan::with_comparisons) takes.
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]

mod contact;
mod edge_stiffness;
mod krylov;
mod linear;
#[cfg(test)]
#[allow(dead_code)]
#[path = "../../../tests/common/meshes.rs"]
mod meshes;
mod precond;
mod saddle;
#[cfg(test)]
mod sample_body;
#[cfg(test)]
mod samples;

use signorini::comparisons::{Comparisons, SplitBody, StepAbout, WithBytes};
use signorini::inequality::{InequalitySolver, LinearSolver, QpProblem};
use signorini::linalg::Workspace;
use signorini::precond::p1::VertexBlocks;
use signorini::saddle::BlockStep;
use signorini::scene::{ContactMethod, DisplacementMethod, P1Solver, SaddleMethod};

/// All of them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Methods;

impl Comparisons for Methods {
    fn displacement(&self, method: DisplacementMethod, body: &SplitBody<'_>) -> Option<WithBytes> {
        precond::displacement(method, body)
    }

    fn p1(&self, solver: P1Solver, blocks: &VertexBlocks<'_>) -> Option<WithBytes> {
        precond::p1(solver, blocks)
    }

    fn linear(&self, method: SaddleMethod) -> Option<Box<dyn LinearSolver>> {
        linear::linear(method)
    }

    fn block_step(
        &self,
        method: SaddleMethod,
        about: &StepAbout<'_>,
        work: &mut Workspace,
    ) -> Option<Box<dyn BlockStep>> {
        saddle::block_step(method, about, work)
    }

    fn contact<'a>(
        &self,
        method: ContactMethod,
        problem: QpProblem<'a>,
    ) -> Option<Box<dyn InequalitySolver + 'a>> {
        contact::contact(method, problem)
    }
}
