//! The passes over all cells.

use super::batch_pass::{
    LinearisePass, PressurePass, RespondPass, StiffPass, TangentPass, VolumePass,
};
use super::cells::{Batches, Linearised, StrainGrid};
use crate::assembly::grid::{
    Basis, Block, CellGrid, Grid, Rows, add_displacement, set_displacement, set_pressure,
};
use crate::assembly::lanes::Lanes;
use crate::assembly::transpose::Row;
use crate::linalg::Workspace;

/// What a state amounts to beside its forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// int W, non-dimensional.
    pub energy: f64,
    /// int J - 1.
    pub volume_change: f64,
    /// Least J over all points.
    pub least_jacobian: f64,
}

impl Response {
    const NONE: Self = Self {
        energy: 0.0,
        volume_change: 0.0,
        least_jacobian: f64::INFINITY,
    };

    fn with(self, other: Self) -> Self {
        Self {
            energy: self.energy + other.energy,
            volume_change: self.volume_change + other.volume_change,
            least_jacobian: self.least_jacobian.min(other.least_jacobian),
        }
    }
}

impl StrainGrid {
    /// `(f, c)` at the state `(u, p)`, hierarchical, held rows included.
    pub fn respond(
        &self,
        (u, p): (&[f64], &[f64]),
        (f, c): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) -> Response {
        match &*self.grid {
            Grid::Triangles(grid) => self.respond_on(grid, (u, p), (f, c), work),
            Grid::Tetrahedra(grid) => self.respond_on(grid, (u, p), (f, c), work),
        }
    }

    /// Prepares products with the tangent at `(u, p)`.
    pub fn linearise(&self, (u, p): (&[f64], &[f64]), into: &mut Linearised, work: &mut Workspace) {
        match &*self.grid {
            Grid::Triangles(grid) => self.linearise_on(grid, (u, p), into, work),
            Grid::Tetrahedra(grid) => self.linearise_on(grid, (u, p), into, work),
        }
    }

    /// `(y, r) = (A u + B^T p, B u)`, hierarchical.
    pub fn tangent(
        &self,
        at: &Linearised,
        rows: Rows,
        (u, p): (&[f64], &[f64]),
        (y, r): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        match &*self.grid {
            Grid::Triangles(grid) => self.tangent_on(grid, at, rows, (u, p), (y, r), work),
            Grid::Tetrahedra(grid) => self.tangent_on(grid, at, rows, (u, p), (y, r), work),
        }
    }

    /// `y += factor (A + volumetric int dJ cof F) u`, held rows left alone.
    #[allow(clippy::too_many_arguments)]
    pub fn add_stiffness(
        &self,
        at: &Linearised,
        basis: Basis,
        volumetric: f64,
        factor: f64,
        u: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        match &*self.grid {
            Grid::Triangles(grid) => {
                self.stiffness_on(grid, at, (basis, volumetric, factor), u, y, work)
            }
            Grid::Tetrahedra(grid) => {
                self.stiffness_on(grid, at, (basis, volumetric, factor), u, y, work)
            }
        }
    }

    /// `r = B u`, hierarchical.
    pub fn divergence(&self, at: &Linearised, u: &[f64], r: &mut [f64], work: &mut Workspace) {
        match &*self.grid {
            Grid::Triangles(grid) => self.divergence_on(grid, at, u, r, work),
            Grid::Tetrahedra(grid) => self.divergence_on(grid, at, u, r, work),
        }
    }

    /// `y += factor B^T p`, hierarchical, held rows left alone.
    pub fn add_divergence_transposed(
        &self,
        at: &Linearised,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        match &*self.grid {
            Grid::Triangles(grid) => self.transposed_on(grid, at, factor, p, y, work),
            Grid::Tetrahedra(grid) => self.transposed_on(grid, at, factor, p, y, work),
        }
    }

    fn batches<'a, const V: usize, const D: usize, const E: usize>(
        &'a self,
        grid: &'a CellGrid<V, D, E>,
        block: usize,
    ) -> Batches<'a, V, D, E> {
        Batches::new(self, grid.batches(block), block)
    }

    fn respond_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        (u, p): (&[f64], &[f64]),
        (f, c): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) -> Response {
        let mut parts = vec![Response::NONE; self.laws.len()];
        grid.pass_over(
            &mut parts,
            work,
            |block, x| gather_state(block, Rows::All, (u, p), x),
            |index, block, part, x, y| {
                let cells = self.batches(grid, index);
                *part = grid.instructions().run(RespondPass { cells, x, y });
                block.finish_result(Basis::Hierarchical, Rows::All, y);
            },
            |local| {
                grid.copies().sum::<D>(local, f, set_displacement);
                grid.copies().sum::<1>(local, c, set_pressure);
            },
        );
        let mut response = parts.into_iter().fold(Response::NONE, Response::with);
        response.volume_change = -c.iter().sum::<f64>();
        response
    }

    fn linearise_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        (u, p): (&[f64], &[f64]),
        into: &mut Linearised,
        work: &mut Workspace,
    ) {
        let stride = self.stride();
        into.blocks.resize_with(self.laws.len(), Vec::new);
        grid.pass_over(
            &mut into.blocks,
            work,
            |block, x| gather_state(block, Rows::All, (u, p), x),
            |index, _, states, x, y| {
                let cells = self.batches(grid, index);
                states.resize(stride * cells.batches.len(), Lanes::ZERO);
                grid.instructions().run(LinearisePass {
                    cells,
                    states,
                    x,
                    y,
                });
            },
            |_| (),
        );
    }

    fn tangent_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        at: &Linearised,
        rows: Rows,
        (u, p): (&[f64], &[f64]),
        (y, r): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        grid.pass(
            work,
            |block, x| gather_state(block, rows, (u, p), x),
            |index, block, x, y| {
                let cells = self.batches(grid, index);
                let states = &at.blocks[index];
                grid.instructions().run(TangentPass {
                    cells,
                    states,
                    x,
                    y,
                });
                block.finish_result(Basis::Hierarchical, rows, y);
            },
            |local| {
                grid.copies().sum::<D>(local, y, set_displacement);
                grid.copies().sum::<1>(local, r, set_pressure);
            },
        );
    }

    fn stiffness_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        at: &Linearised,
        (basis, volumetric, factor): (Basis, f64, f64),
        u: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        grid.pass(
            work,
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(basis, Rows::Free, x);
            },
            |index, block, x, y| {
                let cells = self.batches(grid, index);
                let states = &at.blocks[index];
                grid.instructions().run(StiffPass {
                    cells,
                    states,
                    volumetric,
                    x,
                    y,
                });
                block.finish_result(basis, Rows::Free, y);
            },
            |local| grid.copies().sum::<D>(local, y, add_displacement(factor)),
        );
    }

    fn divergence_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        at: &Linearised,
        u: &[f64],
        r: &mut [f64],
        work: &mut Workspace,
    ) {
        grid.pass(
            work,
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(Basis::Hierarchical, Rows::Free, x);
            },
            |index, _, x, y| {
                let cells = self.batches(grid, index);
                let states = &at.blocks[index];
                grid.instructions().run(VolumePass {
                    cells,
                    states,
                    x,
                    y,
                });
            },
            |local| grid.copies().sum::<1>(local, r, set_pressure),
        );
    }

    fn transposed_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        at: &Linearised,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        grid.pass(
            work,
            |block, x| {
                x.fill([0.0; 4]);
                block.gather_pressure(p, x);
            },
            |index, block, x, y| {
                let cells = self.batches(grid, index);
                let states = &at.blocks[index];
                grid.instructions().run(PressurePass {
                    cells,
                    states,
                    x,
                    y,
                });
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| grid.copies().sum::<D>(local, y, add_displacement(factor)),
        );
    }
}

/// Displacements and pressures of a block, hierarchical.
fn gather_state<const V: usize, const D: usize, const E: usize>(
    block: &Block<V, D, E>,
    rows: Rows,
    (u, p): (&[f64], &[f64]),
    x: &mut [Row],
) {
    block.gather_displacement(u, x);
    block.prepare_argument(Basis::Hierarchical, rows, x);
    block.gather_pressure(p, x);
}
