//! The passes over all cells that take a state.

use super::batch_pass::{LinearisePass, RespondPass};
use super::cells::{Batches, Linearised, StrainGrid};
use super::response::Response;
use crate::assembly::grid::{Basis, Block, CellGrid, Grid, Rows, set_displacement, set_pressure};
use crate::assembly::lanes::Lanes;
use crate::assembly::transpose::Row;
use crate::linalg::Workspace;

/// What a pass over a mixed body writes.
pub struct Mixed<'a> {
    /// Rows of the displacement `[displacement unknowns]`.
    pub displacement: &'a mut [f64],
    /// Rows of the pressure `[vertices]`.
    pub pressure: &'a mut [f64],
}

impl StrainGrid {
    /// `(f, c)` at the state `(u, p)`, hierarchical, held rows included.
    pub fn respond(
        &self,
        (u, p): (&[f64], &[f64]),
        (f, c): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) -> Response {
        let into = Mixed {
            displacement: f,
            pressure: c,
        };
        match &*self.grid {
            Grid::Triangles(grid) => self.respond_on(grid, (u, p), into, work),
            Grid::Tetrahedra(grid) => self.respond_on(grid, (u, p), into, work),
        }
    }

    /// Prepares products with the tangent at `(u, p)`.
    pub fn linearise(&self, (u, p): (&[f64], &[f64]), into: &mut Linearised, work: &mut Workspace) {
        match &*self.grid {
            Grid::Triangles(grid) => self.linearise_on(grid, (u, p), into, work),
            Grid::Tetrahedra(grid) => self.linearise_on(grid, (u, p), into, work),
        }
    }

    /// Batches of a block of `grid` with their laws.
    pub(super) fn batches<'a, const V: usize, const D: usize, const E: usize>(
        &'a self,
        grid: &'a CellGrid<V, D, E>,
        block: usize,
    ) -> Batches<'a, V, D, E> {
        Batches::new(self, grid, block)
    }

    fn respond_on<const V: usize, const D: usize, const E: usize>(
        &self,
        grid: &CellGrid<V, D, E>,
        (u, p): (&[f64], &[f64]),
        into: Mixed<'_>,
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
                let copies = grid.copies();
                copies.sum::<D, f64>(local, into.displacement, set_displacement);
                copies.sum::<1, f64>(local, into.pressure, set_pressure);
            },
        );
        let mut response = parts.into_iter().fold(Response::NONE, Response::with);
        response.volume_change = -into.pressure.iter().sum::<f64>();
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
                states.resize(stride * cells.batches.len(), <Lanes>::zero());
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
}

/// Displacements and pressures of a block, hierarchical.
pub(super) fn gather_state<const V: usize, const D: usize, const E: usize>(
    block: &Block<V, D, E>,
    rows: Rows,
    (u, p): (&[f64], &[f64]),
    x: &mut [Row],
) {
    block.gather_displacement(u, x);
    block.prepare_argument(Basis::Hierarchical, rows, x);
    block.gather_pressure(p, x);
}
