//! The passes over all cells; batches by the instruction set of the machine.

use pulp::Simd;

use super::cells::{BatchLaw, BatchState, Batches, Linearised, StrainGrid, WIDEST};
use super::kernel::{run_batch, store_volumes, vertex_pressures};
use super::laws::{Frozen, Pressures, Respond, Roots, Stiff, Tangent, Volumes};
use crate::assembly::grid::{
    Basis, CellGrid, Grid, Rows, add_displacement, set_displacement, set_pressure,
};
use crate::assembly::kernel::{Element, NodeLanes};
use crate::assembly::lanes::{Lanes, Pack};
use crate::assembly::simd::{BatchPass, prefetch_at};
use crate::assembly::transpose::{Row, Transpose};
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
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(Basis::Hierarchical, Rows::All, x);
                block.gather_pressure(p, x);
            },
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
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(Basis::Hierarchical, Rows::All, x);
                block.gather_pressure(p, x);
            },
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
            |block, x| {
                block.gather_displacement(u, x);
                block.prepare_argument(Basis::Hierarchical, rows, x);
                block.gather_pressure(p, x);
            },
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

struct RespondPass<'a, const V: usize, const D: usize, const E: usize> {
    cells: Batches<'a, V, D, E>,
    x: &'a [Row],
    y: &'a mut [Row],
}

impl<const V: usize, const D: usize, const E: usize> BatchPass for RespondPass<'_, V, D, E> {
    type Output = Response;
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) -> Response {
        let mut element = Element::ZERO;
        let zero = Pack::splat(simd, 0.0);
        let mut least: f64 = f64::INFINITY;
        let mut energy = 0.0;
        let cells = self.cells.batches.iter().zip(self.cells.laws);
        for (index, (batch, law)) in cells.enumerate() {
            let mut energies = Lanes::ZERO;
            run_batch(
                simd,
                transpose,
                self.cells.rule,
                (batch, self.cells.radii(index)),
                &mut element,
                (self.x, self.y),
                |part, _, vertices| Respond {
                    law: law.load(simd, part),
                    stretches: law.stretches::<S>(part),
                    pressures: vertex_pressures(simd, vertices, part),
                    volumes: [zero; V],
                    energy: zero,
                    least: [f64::INFINITY; WIDEST],
                },
                |part, done, vertices| {
                    store_volumes(&done.volumes, vertices, part);
                    done.energy.store(&mut energies, part);
                    least = done.least.into_iter().fold(least, f64::min);
                },
            );
            energy += energies.0.iter().sum::<f64>();
        }
        Response {
            energy,
            volume_change: 0.0,
            least_jacobian: 1.0 + least,
        }
    }
}

struct LinearisePass<'a, const V: usize, const D: usize, const E: usize> {
    cells: Batches<'a, V, D, E>,
    states: &'a mut [Lanes],
    x: &'a [Row],
    y: &'a mut [Row],
}

impl<const V: usize, const D: usize, const E: usize> BatchPass for LinearisePass<'_, V, D, E> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
        let mut element = Element::ZERO;
        let states = self.states.chunks_exact_mut(self.cells.stride);
        let cells = self.cells.batches.iter().zip(self.cells.laws);
        for (index, ((batch, law), state)) in cells.zip(states).enumerate() {
            let (fields, rest) = state.split_at_mut(V * D * D + V);
            let (roots, rest) = rest.split_at_mut(self.cells.rule.len());
            let (hoops, tangents) = rest.split_at_mut(self.cells.hoops);
            let roots = std::cell::RefCell::new(roots);
            let hoops = std::cell::RefCell::new(hoops);
            let tangents = std::cell::RefCell::new(tangents);
            run_batch(
                simd,
                transpose,
                self.cells.rule,
                (batch, self.cells.radii(index)),
                &mut element,
                (self.x, self.y),
                |part, gradients, vertices| {
                    for (j, gradient) in gradients.iter().enumerate() {
                        for i in 0..D {
                            for k in 0..D {
                                gradient[i][k].store(&mut fields[(j * D + i) * D + k], part);
                            }
                        }
                    }
                    let pressures = vertex_pressures::<S, V>(simd, vertices, part);
                    for (lanes, value) in fields[V * D * D..].iter_mut().zip(pressures) {
                        value.store(lanes, part);
                    }
                    Roots {
                        part,
                        roots: &roots,
                        hoops: &hoops,
                        tangents: &tangents,
                        stretches: law.stretches::<S>(part),
                    }
                },
                |_, _, _| (),
            );
        }
    }
}

/// A pass over the batches that reads a state: the law of each part, and what it
/// leaves in the place of the pressure.
macro_rules! frozen_pass {
    ($pass:ident { $($field:ident: $kind:ty),* }, $make:expr, $finish:expr) => {
        struct $pass<'a, const V: usize, const D: usize, const E: usize> {
            cells: Batches<'a, V, D, E>,
            states: &'a [Lanes],
            $($field: $kind,)*
            x: &'a [Row],
            y: &'a mut [Row],
        }

        impl<const V: usize, const D: usize, const E: usize> BatchPass for $pass<'_, V, D, E> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
                let mut element = Element::ZERO;
                let (stride, points) = (self.cells.stride, self.cells.rule.len());
                let hoops = self.cells.hoops;
                let cells = self.cells.batches.iter().zip(self.cells.laws);
                for (index, ((batch, law), state)) in
                    cells.zip(self.states.chunks_exact(stride)).enumerate()
                {
                    prefetch_at(self.cells.batches, index + 1);
                    let state = BatchState::<V, D>(state);
                    run_batch(
                        simd,
                        transpose,
                        self.cells.rule,
                        (batch, self.cells.radii(index)),
                        &mut element,
                        (self.x, &mut *self.y),
                        |part, _, vertices| {
                            let frozen = Frozen {
                                simd,
                                part,
                                gradients: state.gradients(simd, part),
                                pressures: state.pressures(simd, part),
                                roots: state.roots(points),
                                hoops: state.hoops(points, hoops),
                                tangents: state.tangents(points, hoops),
                            };
                            let at = At { simd, part, law, vertices };
                            $make(frozen, at $(, self.$field)*)
                        },
                        |part, done, vertices| $finish(done, part, vertices),
                    );
                }
            }
        }
    };
}

/// One part of a batch at work.
struct At<'a, S, const V: usize> {
    simd: S,
    part: usize,
    law: &'a BatchLaw,
    vertices: &'a NodeLanes<V>,
}

frozen_pass!(
    TangentPass {},
    |frozen, at: At<'_, S, V>| Tangent {
        frozen,
        law: at.law.load(at.simd, at.part),
        changes: vertex_pressures(at.simd, at.vertices, at.part),
        volumes: [Pack::splat(at.simd, 0.0); V],
    },
    |done: Tangent<'_, S, V, D>, part, vertices| store_volumes(&done.volumes, vertices, part)
);

frozen_pass!(
    StiffPass { volumetric: f64 },
    |frozen, at: At<'_, S, V>, volumetric| {
        Stiff {
            frozen,
            volumetric: at.law.modulus(at.simd, at.part) * volumetric,
            law: at.law.load(at.simd, at.part),
        }
    },
    |_, _, _| ()
);

frozen_pass!(
    VolumePass {},
    |frozen, at: At<'_, S, V>| Volumes {
        frozen,
        volumes: [Pack::splat(at.simd, 0.0); V],
    },
    |done: Volumes<'_, S, V, D>, part, vertices| store_volumes(&done.volumes, vertices, part)
);

frozen_pass!(
    PressurePass {},
    |frozen, at: At<'_, S, V>| Pressures {
        frozen,
        changes: vertex_pressures(at.simd, at.vertices, at.part),
    },
    |_, _, _| ()
);
