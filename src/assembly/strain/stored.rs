//! The tangent of each cell of the plane as a matrix:
//!
//! ```text
//! [A + v mu int dJ dJ   (1 - s mu / K) B^T]
//! [B                    0                 ]      of 12 displacements and 3 pressures
//! ```
//!
//! A triangle has few unknowns and six points: its matrix is made by twelve products with
//! the laws and holds 115 numbers, and a product with it costs a tenth of one with the
//! laws. (A tetrahedron's holds 585, whose reading takes as long as the laws do.) Rows and
//! columns are those of the kernels, edge corrections by their factor. Cost: 920 bytes and
//! twelve products a cell.

use pulp::Simd;

use super::cells::{BatchState, Batches, Linearised, StrainGrid};
use super::kernel::{forces, store_volumes, vertex_pressures};
use super::laws::{Columns, Frozen};
use super::pass::{Mixed, gather_state};
use super::tangent::StiffnessTerm;
use crate::assembly::grid::{
    Basis, CellGrid, Rows, add_displacement, set_displacement, set_pressure,
};
use crate::assembly::kernel::{Element, PRESSURE, gather, scatter};
use crate::assembly::lanes::{Lanes, Pack};
use crate::assembly::simd::{BatchPass, prefetch_at};
use crate::assembly::transpose::{Batched, Row, Transpose};
use crate::linalg::Workspace;

/// Blocks of triangles.
pub(super) type Triangles = CellGrid<3, 2, 3>;
/// Displacements of a cell.
const DISPLACEMENTS: usize = 12;
/// Pressures of a cell.
const PRESSURES: usize = 3;
/// Where B begins, after the lower triangle of A.
const DIVERGENCE: usize = DISPLACEMENTS * (DISPLACEMENTS + 1) / 2;
/// Where 1 - s mu / K stands.
const TRANSPOSED: usize = DIVERGENCE + DISPLACEMENTS * PRESSURES;
/// Numbers of a cell.
const ENTRIES: usize = TRANSPOSED + 1;

/// Matrices of all triangles.
#[derive(Clone, Debug)]
pub(super) struct CellMatrices {
    /// Of each block, batch by batch.
    blocks: Vec<Vec<[Lanes; ENTRIES]>>,
}

/// What a product takes of the matrices.
#[derive(Clone, Copy)]
enum Part {
    Stiffness,
    Divergence,
    Transposed,
    All,
}

/// Node of a cell and component of a displacement.
const fn place(displacement: usize) -> (usize, usize) {
    (displacement / 2, displacement % 2)
}

impl CellMatrices {
    /// Matrices about the state that left `at`, `volumetric` being v.
    pub(super) fn new(
        (cells, grid): (&StrainGrid, &Triangles),
        at: &Linearised,
        volumetric: f64,
    ) -> Self {
        let mut blocks: Vec<Vec<[Lanes; ENTRIES]>> = vec![Vec::new(); at.blocks.len()];
        grid.pass_over(
            &mut blocks,
            &mut Workspace::new(),
            |_, _: &mut [Row]| (),
            |index, _, matrices, _, _| {
                let cells = cells.batches(grid, index);
                matrices.resize(cells.batches.len(), [<Lanes>::zero(); ENTRIES]);
                grid.instructions().run(MatrixPass {
                    cells,
                    states: &at.blocks[index],
                    volumetric,
                    matrices,
                });
            },
            |_| (),
        );
        Self { blocks }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let matrices: usize = self.blocks.iter().map(Vec::len).sum();
        (matrices * size_of::<[Lanes; ENTRIES]>()) as u64
    }

    /// `(y, r) = (A u + B^T p, B u)`, hierarchical, held entries left out.
    pub(super) fn apply(
        &self,
        grid: &Triangles,
        (u, p): (&[f64], &[f64]),
        into: Mixed<'_>,
        work: &mut Workspace,
    ) {
        grid.pass(
            work,
            |block, x| gather_state(block, Rows::Free, (u, p), x),
            |index, block, x, y| {
                self.multiply((grid, index), Part::All, x, y);
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| {
                let copies = grid.copies();
                copies.sum::<2, f64>(local, into.displacement, set_displacement);
                copies.sum::<1, f64>(local, into.pressure, set_pressure);
            },
        );
    }

    /// `y += factor A u`, held rows left alone.
    pub(super) fn add_stiffness(
        &self,
        grid: &Triangles,
        StiffnessTerm { basis, factor, .. }: StiffnessTerm,
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
                self.multiply((grid, index), Part::Stiffness, x, y);
                block.finish_result(basis, Rows::Free, y);
            },
            |local| {
                grid.copies()
                    .sum::<2, f64>(local, y, add_displacement(factor))
            },
        );
    }

    /// `r = B u`, hierarchical.
    pub(super) fn divergence(
        &self,
        grid: &Triangles,
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
            |index, _, x, y| self.multiply((grid, index), Part::Divergence, x, y),
            |local| grid.copies().sum::<1, f64>(local, r, set_pressure),
        );
    }

    /// `y += factor B^T p`, hierarchical, held rows left alone.
    pub(super) fn add_divergence_transposed(
        &self,
        (grid, factor): (&Triangles, f64),
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
                self.multiply((grid, index), Part::Transposed, x, y);
                block.finish_result(Basis::Hierarchical, Rows::Free, y);
            },
            |local| {
                grid.copies()
                    .sum::<2, f64>(local, y, add_displacement(factor))
            },
        );
    }

    /// Products on the batches of a block.
    fn multiply(&self, (grid, block): (&Triangles, usize), part: Part, x: &[Row], y: &mut [Row]) {
        grid.instructions().run(ProductPass {
            cells: grid.batches(block),
            matrices: &self.blocks[block],
            part,
            x,
            y,
        });
    }
}

/// Makes the matrices of a block, a column a product.
struct MatrixPass<'a> {
    cells: Batches<'a, 3, 2, 3>,
    states: &'a [Lanes],
    volumetric: f64,
    matrices: &'a mut [[Lanes; ENTRIES]],
}

impl BatchPass for MatrixPass<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, _transpose: T) {
        let cells = &self.cells;
        let states = self.states.chunks_exact(cells.stride);
        let laws = cells.laws.iter().zip(states);
        let one = Lanes([1.0; crate::assembly::lanes::WIDTH]);
        for (index, ((law, state), matrix)) in laws.zip(self.matrices).enumerate() {
            let state = BatchState::<3, 2>(state);
            let points = cells.rule.len();
            for column in 0..DISPLACEMENTS {
                let mut element = Element::zero();
                *entry_of(&mut element, column) = one;
                forces(
                    simd,
                    cells.at(index),
                    &mut element,
                    &mut |part, _, _| Columns {
                        law: law.load(simd, part),
                        volumetric: law.modulus(simd, part) * self.volumetric,
                        frozen: Frozen {
                            simd,
                            part,
                            gradients: state.gradients(simd, part),
                            pressures: state.pressures(simd, part),
                            volume: law.volume(simd, part, cells.penalty),
                            roots: state.roots(points),
                            hoops: state.hoops(points, cells.hoops),
                            tangents: state.tangents(points, cells.hoops),
                        },
                        volumes: [Pack::splat(simd, 0.0); 3],
                    },
                    &mut |part, done: Columns<'_, S, 3, 2>, vertices| {
                        store_volumes(&done.volumes, vertices, part);
                    },
                );
                take_column(&mut element, column, matrix);
            }
            for part in 0..f64::parts::<S>() {
                let share = law.volume(simd, part, cells.penalty).pushed_share(simd);
                share.store(&mut matrix[TRANSPOSED], part);
            }
        }
    }
}

/// Lanes of a displacement.
#[inline(always)]
fn entry_of(element: &mut Element<3, 3>, displacement: usize) -> &mut Lanes {
    let (node, component) = place(displacement);
    match node.checked_sub(3) {
        None => &mut element.vertices[node][component],
        Some(edge) => &mut element.edges[edge][component],
    }
}

/// Writes forces and volumes into a column.
#[inline(always)]
fn take_column(element: &mut Element<3, 3>, column: usize, matrix: &mut [Lanes; ENTRIES]) {
    for row in column..DISPLACEMENTS {
        matrix[row * (row + 1) / 2 + column] = *entry_of(element, row);
    }
    for (row, vertex) in element.vertices.iter().enumerate() {
        matrix[DIVERGENCE + row * DISPLACEMENTS + column] = vertex[PRESSURE];
    }
}

/// Products on the batches of a block.
struct ProductPass<'a> {
    cells: &'a [crate::assembly::kernel::Batch<3, 2, 3>],
    matrices: &'a [[Lanes; ENTRIES]],
    part: Part,
    x: &'a [Row],
    y: &'a mut [Row],
}

impl BatchPass for ProductPass<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
        let mut element = Element::zero();
        for (index, (batch, matrix)) in self.cells.iter().zip(self.matrices).enumerate() {
            prefetch_at(self.cells, index + 1);
            gather(transpose, &batch.vertices, self.x, &mut element.vertices);
            gather(transpose, &batch.edges, self.x, &mut element.edges);
            for part in 0..f64::parts::<S>() {
                let product = Product { simd, part, matrix };
                product.run(self.part, &mut element);
            }
            scatter(transpose, &batch.vertices, &element.vertices, self.y);
            scatter(transpose, &batch.edges, &element.edges, self.y);
        }
    }
}

/// Displacements of one part of a batch.
type Displacements<S> = [Pack<S>; DISPLACEMENTS];

/// One part of a batch at work.
#[derive(Clone, Copy)]
struct Product<'a, S> {
    simd: S,
    part: usize,
    matrix: &'a [Lanes; ENTRIES],
}

impl<S: Simd> Product<'_, S> {
    #[inline(always)]
    fn entry(&self, index: usize) -> Pack<S> {
        Pack::load(self.simd, &self.matrix[index], self.part)
    }

    #[inline(always)]
    fn run(self, what: Part, element: &mut Element<3, 3>) {
        let zero = Pack::splat(self.simd, 0.0);
        let (mut x, mut y) = ([zero; DISPLACEMENTS], [zero; DISPLACEMENTS]);
        for (displacement, value) in x.iter_mut().enumerate() {
            *value = Pack::load(self.simd, entry_of(element, displacement), self.part);
        }
        let p = vertex_pressures(self.simd, &element.vertices, self.part);
        if matches!(what, Part::Stiffness | Part::All) {
            self.add_stiffness(&x, &mut y);
        }
        if matches!(what, Part::Transposed | Part::All) {
            self.add_transposed(&p, &mut y);
        }
        if matches!(what, Part::Divergence | Part::All) {
            self.store_divergence(&x, element);
        }
        for (displacement, value) in y.into_iter().enumerate() {
            value.store(entry_of(element, displacement), self.part);
        }
    }

    #[inline(always)]
    fn add_stiffness(&self, x: &Displacements<S>, y: &mut Displacements<S>) {
        let mut index = 0;
        for row in 0..DISPLACEMENTS {
            for column in 0..row {
                let entry = self.entry(index);
                y[row] = y[row].plus_product(entry, x[column]);
                y[column] = y[column].plus_product(entry, x[row]);
                index += 1;
            }
            y[row] = y[row].plus_product(self.entry(index), x[row]);
            index += 1;
        }
    }

    #[inline(always)]
    fn add_transposed(&self, p: &[Pack<S>; PRESSURES], y: &mut Displacements<S>) {
        let share = self.entry(TRANSPOSED);
        for (row, pressure) in p.iter().enumerate() {
            let pressure = *pressure * share;
            for (column, force) in y.iter_mut().enumerate() {
                let entry = self.entry(DIVERGENCE + row * DISPLACEMENTS + column);
                *force = force.plus_product(entry, pressure);
            }
        }
    }

    #[inline(always)]
    fn store_divergence(&self, x: &Displacements<S>, element: &mut Element<3, 3>) {
        for (row, vertex) in element.vertices.iter_mut().enumerate() {
            let mut volume = Pack::splat(self.simd, 0.0);
            for (column, value) in x.iter().enumerate() {
                let entry = self.entry(DIVERGENCE + row * DISPLACEMENTS + column);
                volume = volume.plus_product(entry, *value);
            }
            volume.store(&mut vertex[PRESSURE], self.part);
        }
    }
}
