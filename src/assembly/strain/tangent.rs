//! Products with the tangent at a state, pass by pass over all cells; equations in
//! [`super`]. Nothing but the state is read of it.

use super::batch_pass::{PressurePass, StiffPass, TangentPass, VolumePass};
use super::cells::{Linearised, StrainGrid};
use super::pass::{Mixed, gather_state};
use crate::assembly::grid::{
    Basis, CellGrid, Grid, Rows, add_displacement, set_displacement, set_pressure,
};
use crate::linalg::Workspace;

/// Cells and the state that they are linearised about.
#[derive(Clone, Copy, Debug)]
pub struct TangentAt<'a> {
    cells: &'a StrainGrid,
    at: &'a Linearised,
}

/// A multiple of A and of what is added to it.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessTerm {
    /// Basis of argument and result.
    pub basis: Basis,
    /// Multiplies the shear modulus times int dJ cof F, which is added to A.
    pub volumetric: f64,
    /// Multiplies the sum.
    pub factor: f64,
}

impl StrainGrid {
    /// Products with the tangent at the state that left `at`.
    pub fn about<'a>(&'a self, at: &'a Linearised) -> TangentAt<'a> {
        TangentAt { cells: self, at }
    }
}

/// The same call on either cell kind.
macro_rules! either {
    ($tangent:expr, $on:ident => $call:expr) => {
        match &*$tangent.cells.grid {
            Grid::Triangles(grid) => {
                let $on = OnGrid {
                    tangent: *$tangent,
                    grid,
                };
                $call
            }
            Grid::Tetrahedra(grid) => {
                let $on = OnGrid {
                    tangent: *$tangent,
                    grid,
                };
                $call
            }
        }
    };
}

impl TangentAt<'_> {
    /// `(y, r) = (A u + B^T p, B u)`, hierarchical.
    pub fn apply(
        &self,
        rows: Rows,
        (u, p): (&[f64], &[f64]),
        into: Mixed<'_>,
        work: &mut Workspace,
    ) {
        either!(self, on => on.apply(rows, (u, p), into, work));
    }

    /// `y += factor (A + volumetric int dJ cof F) u`, held rows left alone.
    pub fn add_stiffness(
        &self,
        term: StiffnessTerm,
        u: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        either!(self, on => on.add_stiffness(term, u, y, work));
    }

    /// `r = B u`, hierarchical.
    pub fn divergence(&self, u: &[f64], r: &mut [f64], work: &mut Workspace) {
        either!(self, on => on.divergence(u, r, work));
    }

    /// `y += factor B^T p`, hierarchical, held rows left alone.
    pub fn add_divergence_transposed(
        &self,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        either!(self, on => on.add_divergence_transposed(factor, p, y, work));
    }
}

/// The tangent on the blocks of one cell kind.
struct OnGrid<'a, const V: usize, const D: usize, const E: usize> {
    tangent: TangentAt<'a>,
    grid: &'a CellGrid<V, D, E>,
}

impl<const V: usize, const D: usize, const E: usize> OnGrid<'_, V, D, E> {
    fn apply(&self, rows: Rows, (u, p): (&[f64], &[f64]), into: Mixed<'_>, work: &mut Workspace) {
        let Self { tangent, grid } = self;
        grid.pass(
            work,
            |block, x| gather_state(block, rows, (u, p), x),
            |index, block, x, y| {
                let pass = TangentPass {
                    cells: tangent.cells.batches(grid, index),
                    states: &tangent.at.blocks[index],
                    x,
                    y: &mut *y,
                };
                grid.instructions().run(pass);
                block.finish_result(Basis::Hierarchical, rows, y);
            },
            |local| {
                let copies = grid.copies();
                copies.sum::<D, f64>(local, into.displacement, set_displacement);
                copies.sum::<1, f64>(local, into.pressure, set_pressure);
            },
        );
    }

    fn add_stiffness(&self, term: StiffnessTerm, u: &[f64], y: &mut [f64], work: &mut Workspace) {
        let Self { tangent, grid } = self;
        grid.pass(
            work,
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(term.basis, Rows::Free, x);
            },
            |index, block, x, y| {
                let pass = StiffPass {
                    cells: tangent.cells.batches(grid, index),
                    states: &tangent.at.blocks[index],
                    volumetric: term.volumetric,
                    x,
                    y: &mut *y,
                };
                grid.instructions().run(pass);
                block.finish_result(term.basis, Rows::Free, y);
            },
            |local| {
                grid.copies()
                    .sum::<D, f64>(local, y, add_displacement(term.factor));
            },
        );
    }

    fn divergence(&self, u: &[f64], r: &mut [f64], work: &mut Workspace) {
        let Self { tangent, grid } = self;
        grid.pass(
            work,
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(Basis::Hierarchical, Rows::Free, x);
            },
            |index, _, x, y| {
                let pass = VolumePass {
                    cells: tangent.cells.batches(grid, index),
                    states: &tangent.at.blocks[index],
                    x,
                    y,
                };
                grid.instructions().run(pass);
            },
            |local| grid.copies().sum::<1, f64>(local, r, set_pressure),
        );
    }

    fn add_divergence_transposed(
        &self,
        factor: f64,
        p: &[f64],
        y: &mut [f64],
        work: &mut Workspace,
    ) {
        let Self { tangent, grid } = self;
        grid.pass(
            work,
            |block, x| {
                x.fill([0.0; 4]);
                block.gather_pressure(p, x);
            },
            |index, block, x, y| {
                let pass = PressurePass {
                    cells: tangent.cells.batches(grid, index),
                    states: &tangent.at.blocks[index],
                    x,
                    y: &mut *y,
                };
                grid.instructions().run(pass);
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| {
                grid.copies()
                    .sum::<D, f64>(local, y, add_displacement(factor))
            },
        );
    }
}
