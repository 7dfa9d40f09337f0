//! What stands in the place of `compare` in a library built without comparisons: none
//! of its methods is there. Plans refuse their names.

use std::sync::Arc;

use crate::inequality::{InequalitySolver, QpProblem};
use crate::linalg::{Preconditioner, Workspace};
use crate::mesh::Mesh;
use crate::plan::Plan;
use crate::precond::p1::VertexBlocks;
use crate::prepare::PrepareError;
use crate::prepare::bodies::DisplacementBody;
use crate::report::{CancelToken, Seconds};
use crate::saddle::{BlockStep, EqualityBlock};
use crate::scene::{ContactMethod, DisplacementMethod, ElementKind, P1Solver, SaddleMethod};
use crate::session::body::Body;
use crate::sqp::linear::LinearSolver;

/// Whether comparison methods are there.
pub(crate) const IS_BUILT: bool = false;

/// No comparison element has unknowns.
pub(crate) fn unknowns(_: ElementKind, _: &Mesh) -> Option<(usize, usize)> {
    None
}

/// The data of a comparison element, of which there is none.
#[derive(Debug)]
pub(crate) enum ComparisonData {}

impl ComparisonData {
    /// Bytes of nothing.
    pub(crate) fn bytes(&self) -> u64 {
        match *self {}
    }

    /// Seconds that nothing took.
    pub(crate) fn seconds(&self) -> Seconds {
        match *self {}
    }
}

/// No comparison element is prepared.
pub(crate) fn prepared(
    _: &Plan,
    _: &Arc<Mesh>,
    _: &CancelToken,
) -> Result<Option<ComparisonData>, PrepareError> {
    Ok(None)
}

/// No body has data of a comparison element.
pub(crate) fn body(_: Arc<Plan>, _: Arc<Mesh>, data: Arc<ComparisonData>) -> Box<dyn Body> {
    match *data {}
}

/// No preconditioner but the solver's own.
pub(crate) fn displacement(
    _: DisplacementMethod,
    _: &DisplacementBody<'_>,
) -> Option<(Arc<dyn Preconditioner>, u64)> {
    None
}

/// No P1 solver but the solver's own.
pub(crate) fn p1(_: P1Solver, _: &VertexBlocks<'_>) -> Option<(Arc<dyn Preconditioner>, u64)> {
    None
}

/// No linear method but the solver's own.
pub(crate) fn linear(_: SaddleMethod) -> Option<Box<dyn LinearSolver>> {
    None
}

/// No block step but the solver's own.
pub(crate) fn block_step(
    _: SaddleMethod,
    _: &dyn Preconditioner,
    _: &EqualityBlock<'_>,
    _: (&[f64], &[f64]),
    _: &mut Workspace,
) -> Option<Box<dyn BlockStep>> {
    None
}

/// No method for contact but the solver's own.
pub(crate) fn contact<'a>(
    _: ContactMethod,
    _: QpProblem<'a>,
) -> Option<Box<dyn InequalitySolver + 'a>> {
    None
}
