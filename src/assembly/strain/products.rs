//! How products with a tangent are made: in the plane by the matrices of the cells, in
//! space anew from the laws, whichever is faster.

use std::sync::Arc;

use super::cells::{Linearised, StrainGrid};
use super::pass::Mixed;
use super::stored::{CellMatrices, Triangles};
use super::tangent::StiffnessTerm;
use crate::assembly::grid::{Basis, Grid, Rows};
use crate::linalg::Workspace;

/// Products with the tangent at one state.
#[derive(Clone, Debug)]
pub struct TangentProducts {
    cells: Arc<StrainGrid>,
    way: Way,
}

#[derive(Clone, Debug)]
enum Way {
    /// From what the state left, `volumetric` times mu int dJ cof F added to A.
    Laws {
        at: Arc<Linearised>,
        volumetric: f64,
    },
    Matrices(Arc<CellMatrices>),
}

impl TangentProducts {
    /// Products with A + `volumetric` mu int dJ cof F, and with B, about the state that
    /// left `at`.
    pub fn new(cells: &Arc<StrainGrid>, at: &Arc<Linearised>, volumetric: f64) -> Self {
        let way = match &*cells.grid {
            Grid::Triangles(grid) => {
                Way::Matrices(Arc::new(CellMatrices::new((cells, grid), at, volumetric)))
            }
            Grid::Tetrahedra(_) => Way::Laws {
                at: at.clone(),
                volumetric,
            },
        };
        Self {
            cells: cells.clone(),
            way,
        }
    }

    /// Bytes of the matrices.
    pub fn bytes(&self) -> u64 {
        match &self.way {
            Way::Matrices(matrices) => matrices.bytes(),
            Way::Laws { .. } => 0,
        }
    }

    /// `(y, r) = (A u + B^T p, B u)` without a volumetric term, hierarchical, held entries
    /// left out.
    pub(super) fn apply(
        &self,
        x: (&[f64], &[f64]),
        (y, r): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        let into = Mixed {
            displacement: y,
            pressure: r,
        };
        match &self.way {
            Way::Laws { at, .. } => self.cells.about(at).apply(Rows::Free, x, into, work),
            Way::Matrices(matrices) => {
                self.on_triangles(|grid| matrices.apply(grid, x, into, work));
            }
        }
    }

    /// `y += factor A u`, held rows left alone.
    pub(super) fn add_stiffness(
        &self,
        (basis, factor): (Basis, f64),
        u: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        let mut term = StiffnessTerm {
            basis,
            volumetric: 0.0,
            factor,
        };
        match &self.way {
            Way::Laws { at, volumetric } => {
                term.volumetric = *volumetric;
                self.cells.about(at).add_stiffness(term, u, y, work);
            }
            Way::Matrices(matrices) => {
                self.on_triangles(|grid| matrices.add_stiffness(grid, term, u, y, work));
            }
        }
    }

    /// `r = B u`, hierarchical.
    pub(super) fn divergence(&self, u: &[f64], r: &mut [f64], work: &mut Workspace) {
        match &self.way {
            Way::Laws { at, .. } => self.cells.about(at).divergence(u, r, work),
            Way::Matrices(matrices) => {
                self.on_triangles(|grid| matrices.divergence(grid, u, r, work));
            }
        }
    }

    /// `y += factor B^T p`, hierarchical, held rows left alone.
    pub(super) fn add_divergence_transposed(
        &self,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        match &self.way {
            Way::Laws { at, .. } => {
                let tangent = self.cells.about(at);
                tangent.add_divergence_transposed(factor, p, y, work);
            }
            Way::Matrices(matrices) => self.on_triangles(|grid| {
                matrices.add_divergence_transposed((grid, factor), p, y, work);
            }),
        }
    }

    /// Runs `product` on the grid that matrices belong to.
    fn on_triangles(&self, product: impl FnOnce(&Triangles)) {
        if let Grid::Triangles(grid) = &*self.cells.grid {
            product(grid);
        }
    }
}
