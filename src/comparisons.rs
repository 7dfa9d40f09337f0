//! Methods beside the solver's own, which a caller brings along: what the solver is compared
//! with.
//!
//! A scene names methods from closed lists ([`Named`](crate::scene::Named)); some of the names are
//! not the library's to serve. [`Plan::with_comparisons`](crate::Plan::with_comparisons) takes
//! a value of [`Comparisons`] for them; a plan made by [`Plan::new`](crate::Plan::new) refuses
//! them. One function a kind of method: it returns what the production path works with by the
//! same traits as the solver's own methods; where it returns none, the solver's own serves.

use std::fmt::Debug;
use std::sync::Arc;

use crate::assembly::{CellGeometry, CellModuli};
use crate::inequality::{InequalitySolver, LinearSolver, QpProblem};
use crate::linalg::{Held, LinearOperator, Preconditioner, Workspace};
use crate::mesh::Mesh;
use crate::precond::p1::VertexBlocks;
use crate::saddle::{BlockStep, EqualityBlock};
use crate::scene::{ContactMethod, DisplacementMethod, P1Solver, SaddleMethod};

/// A preconditioner and the bytes that it holds beside what it was made from.
pub type WithBytes = (Arc<dyn Preconditioner>, u64);

/// Methods that scenes may name beside the solver's own. A plan that is made with them takes every
/// name of the lists: for one that is not the solver's own each function returns some method.
pub trait Comparisons: Debug + Send + Sync {
    /// The preconditioner of the displacement block.
    fn displacement(&self, _: DisplacementMethod, _: &SplitBody<'_>) -> Option<WithBytes> {
        None
    }

    /// The solver of the P1 block.
    fn p1(&self, _: P1Solver, _: &VertexBlocks<'_>) -> Option<WithBytes> {
        None
    }

    /// The method of programs without contact; none for those that serve contact too.
    fn linear(&self, _: SaddleMethod) -> Option<Box<dyn LinearSolver>> {
        None
    }

    /// The step of GCR about the internal pressure; none for the upper block triangle.
    fn block_step(
        &self,
        _: SaddleMethod,
        _: &StepAbout<'_>,
        _: &mut Workspace,
    ) -> Option<Box<dyn BlockStep>> {
        None
    }

    /// The solver of a problem by a method for contact.
    fn contact<'a>(
        &self,
        _: ContactMethod,
        _: QpProblem<'a>,
    ) -> Option<Box<dyn InequalitySolver + 'a>> {
        None
    }
}

/// The linear body by vertices and edges: what a preconditioner of the displacement block is
/// built from.
pub struct SplitBody<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Gradients and volumes of its cells.
    pub geometry: &'a CellGeometry,
    /// Moduli of its cells.
    pub moduli: &'a CellModuli,
    /// Held unknowns.
    pub held: &'a Held,
    /// Components of a node.
    pub components: usize,
    /// Number of vertices; edges follow.
    pub vertices: usize,
    /// A in the hierarchical basis `[unknowns, unknowns]`.
    pub stiffness: Arc<dyn LinearOperator>,
    /// Approximate inverse of A11, the P1 block.
    pub p1: Arc<dyn Preconditioner>,
}

/// What a step of GCR starts from.
pub struct StepAbout<'a> {
    /// Approximate inverse of A.
    pub displacement: &'a dyn Preconditioner,
    /// The internal pressure.
    pub pressure: &'a EqualityBlock<'a>,
    /// Present residual of the forces `[displacement]`.
    pub force: &'a [f64],
    /// Present residual of the constraint `[pressure]`.
    pub constraint: &'a [f64],
}
