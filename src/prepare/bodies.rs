//! What preconditioners are built from: the body as the P1 solver and as the
//! preconditioner of the whole displacement block see it, at rest or deformed.

use std::sync::Arc;

use super::deformed::Deformed;
use crate::assembly::grid::{Basis, SingleGrid, VolumeTerm};
use crate::assembly::p1_stiffness::CellStiffness;
use crate::assembly::strain::{CellTangents, SingleTangent, TangentProducts, TangentStiffness};
use crate::assembly::{CellGeometry, CellModuli, Constrained, Grid, SingleStiffness, Stiffness};
use crate::comparisons::SplitBody;
use crate::linalg::{Held, LinearOperator, Preconditioner, ResidualUpdate};
use crate::mesh::Mesh;
use crate::plan::augmentation::VOLUMETRIC;
use crate::precond::NodeBlocks;
use crate::space::TaylorHood;

/// Mesh and material of A11.
#[derive(Clone, Copy)]
pub(crate) struct P1Body<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) space: &'a TaylorHood,
    pub(crate) geometry: &'a CellGeometry,
    pub(crate) stiffness: &'a dyn CellStiffness,
    pub(crate) held: &'a Held,
    /// Hierarchical displacement of the surface; empty at rest.
    pub(crate) moved: &'a [f64],
}

/// What the preconditioner of the displacement block is built from.
pub(crate) struct DisplacementBody<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) space: &'a TaylorHood,
    pub(crate) geometry: &'a CellGeometry,
    pub(crate) moduli: &'a CellModuli,
    pub(crate) held: &'a Held,
    pub(crate) grid: &'a Arc<Grid>,
    pub(crate) node_blocks: &'a NodeBlocks,
    pub(crate) p1: Arc<dyn Preconditioner>,
    /// None at rest.
    pub(crate) tangent: Option<Deformed<'a>>,
    /// The tangents of cells there, where they have been made.
    pub(crate) tangents: Option<&'a CellTangents>,
}

impl DisplacementBody<'_> {
    /// A in the given basis.
    pub(crate) fn stiffness(&self, basis: Basis) -> Constrained<Stiffness> {
        self.linear(basis, VolumeTerm::Own)
    }

    /// The linear body by vertices and edges.
    pub(crate) fn split(&self) -> SplitBody<'_> {
        SplitBody {
            mesh: self.mesh,
            geometry: self.geometry,
            moduli: self.moduli,
            held: self.held,
            components: self.space.components,
            vertices: self.space.vertices,
            stiffness: Arc::new(self.stiffness(Basis::Hierarchical)),
            p1: self.p1.clone(),
        }
    }

    fn linear(&self, basis: Basis, volume: VolumeTerm) -> Constrained<Stiffness> {
        Constrained {
            free: Stiffness {
                grid: self.grid.clone(),
                basis,
                volume,
                size: self.space.displacement_unknowns(),
            },
            held: self.held.clone(),
        }
    }

    /// What the smoother of the inverse takes on Lagrange values in single precision, and its bytes:
    /// about a deformed state by one tangent a cell. None there in the plane.
    pub(crate) fn single_operator(&self) -> Option<(Arc<dyn ResidualUpdate<f32>>, u64)> {
        let (basis, held) = (Basis::Lagrange, self.held.clone());
        if self.tangent.is_none() {
            let grid = SingleGrid::new(self.grid);
            let bytes = grid.bytes();
            let stiffness = SingleStiffness { grid, basis, held };
            return Some((Arc::new(stiffness), bytes));
        }
        let tangent = SingleTangent::new((self.mesh, self.grid), self.tangents?, basis, held)?;
        let bytes = tangent.bytes();
        Some((Arc::new(tangent), bytes))
    }

    /// What the inverse approximates the inverse of, in the given basis: A or the tangent, with
    /// a volume term.
    pub(crate) fn operator(&self, basis: Basis) -> Arc<dyn LinearOperator> {
        let Some(state) = self.tangent else {
            return Arc::new(self.linear(basis, VolumeTerm::Augmented));
        };
        Arc::new(Constrained {
            free: TangentStiffness {
                products: TangentProducts::new(state.cells, state.at, VOLUMETRIC),
                basis,
                size: self.space.displacement_unknowns(),
            },
            held: self.held.clone(),
        })
    }
}
