//! The innermost element kernels, W elements at a time (eight in double precision, sixteen
//! in single): `V` vertices, `D` components, `E` edges.
//!
//! In the hierarchical basis grad u = sum_a H_a (x) grad lambda_a with
//! H_a(q) = u_a + 4 sum_j lambda_j(q) c_aj. The rule of degree 2 has V points;
//! at point q, lambda_j = ALPHA if j = q, else BETA, so one base per vertex and
//! one edge coefficient per (vertex, point) replace the dense tabulation. The
//! rule is exact for straight-sided linear elasticity.
//!
//! A node is a row of four numbers, displacement first and pressure last, so
//! that it moves as one register. Numbers that a kernel does not write carry
//! what was gathered, and callers ignore them.

pub(super) mod part;
pub(super) mod points;

use pulp::Simd;

use super::lanes::{Lanes, Pack, WIDTH};
use super::transpose::{Batched, Row, Transpose};
use crate::linalg::Scalar;
use part::ElementPart;
pub use points::edge_factor;
use points::{Elastic, Pressed, Tangent};

/// Place of the pressure in a row.
pub const PRESSURE: usize = 3;

/// Entries of a symmetric matrix of nine rows, its upper triangle row by row.
pub const SYMMETRIC_ENTRIES: usize = 45;

/// One batch of elements.
#[derive(Clone, Debug)]
pub struct Batch<const V: usize, const D: usize, const E: usize, R = f64, const W: usize = WIDTH> {
    /// Vertices inside the block.
    pub vertices: [[u16; W]; V],
    /// Edge nodes inside the block.
    pub edges: [[u16; W]; E],
    /// Gradients of barycentric coordinates 1..V.
    pub gradients: [[Lanes<R, W>; D]; D],
    /// Volume over number of points, times mu.
    pub shear: Lanes<R, W>,
    /// Volume over number of points, times lambda of the displacement form.
    pub lame: Lanes<R, W>,
    /// Volume over number of points, times the lambda that an approximate inverse holds.
    pub augmented: Lanes<R, W>,
    /// Volume over number of points.
    pub weight: Lanes<R, W>,
}

/// Barycentric coordinates of the rule's points: at the own vertex, elsewhere.
pub fn rule(vertices: usize) -> (f64, f64) {
    match vertices {
        3 => (2.0 / 3.0, 1.0 / 6.0),
        _ => (0.585_410_196_624_968_5, 0.138_196_601_125_010_5),
    }
}

/// What edge corrections are gathered times.
pub(super) fn edge_share<const V: usize>() -> f64 {
    let (alpha, beta) = rule(V);
    1.0 / (alpha - beta)
}

/// Local vertex pairs of the edges, in the order (0,1), (0,2), .. of the mesh.
pub const fn edge_pairs<const E: usize>() -> [(usize, usize); E] {
    let tetrahedron = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let triangle = [(0, 1), (0, 2), (1, 2)];
    let mut pairs = [(0, 0); E];
    let mut edge = 0;
    while edge < E {
        pairs[edge] = if E == 3 {
            triangle[edge]
        } else {
            tetrahedron[edge]
        };
        edge += 1;
    }
    pairs
}

/// Nodal values of a batch in memory: displacement, pressure in the last place.
pub(super) type NodeLanes<const N: usize, R = f64, const W: usize = WIDTH> = [[Lanes<R, W>; 4]; N];

/// Nodal values of the batch at work; made once for all batches of a pass, as
/// clearing it takes as long as a third of a batch.
#[derive(Clone, Debug)]
pub struct Element<const V: usize, const E: usize, R = f64, const W: usize = WIDTH> {
    pub(super) vertices: NodeLanes<V, R, W>,
    pub(super) edges: NodeLanes<E, R, W>,
}

impl<const V: usize, const E: usize, R: Scalar, const W: usize> Element<V, E, R, W> {
    /// All zero.
    pub fn zero() -> Self {
        Self {
            vertices: [[Lanes::zero(); 4]; V],
            edges: [[Lanes::zero(); 4]; E],
        }
    }
}

#[inline(always)]
pub(super) fn gather<T: Transpose, R: Batched<W>, const N: usize, const W: usize>(
    transpose: T,
    nodes: &[[u16; W]; N],
    x: &[Row<R>],
    values: &mut NodeLanes<N, R, W>,
) {
    for (values, nodes) in values.iter_mut().zip(nodes) {
        let mut rows = [&x[usize::from(nodes[0])]; W];
        for (row, &node) in rows.iter_mut().zip(nodes) {
            *row = &x[usize::from(node)];
        }
        *values = R::to_lanes(transpose, rows);
    }
}

#[inline(always)]
pub(super) fn scatter<T: Transpose, R: Batched<W>, const N: usize, const W: usize>(
    transpose: T,
    nodes: &[[u16; W]; N],
    values: &NodeLanes<N, R, W>,
    y: &mut [Row<R>],
) {
    for (values, nodes) in values.iter().zip(nodes) {
        let rows = R::to_rows(transpose, values);
        for (row, &node) in rows.iter().zip(nodes) {
            // As one value: number by number the compiler adds in four registers.
            let target = &mut y[usize::from(node)];
            let old = *target;
            *target = std::array::from_fn(|i| old[i] + row[i]);
        }
    }
}

/// One batch at work: nodal values in, what a kernel makes of them added to the result. `A` is
/// int 2 mu eps : eps + lambda div div.
pub(super) struct Kernel<
    'a,
    S,
    T,
    const V: usize,
    const D: usize,
    const E: usize,
    R = f64,
    const W: usize = WIDTH,
> {
    /// Instructions.
    pub(super) simd: S,
    /// How rows become lanes.
    pub(super) transpose: T,
    pub(super) batch: &'a Batch<V, D, E, R, W>,
    pub(super) element: &'a mut Element<V, E, R, W>,
    /// Nodal values of the block.
    pub(super) x: &'a [Row<R>],
    /// Result of the block.
    pub(super) y: &'a mut [Row<R>],
}

impl<S, T, const V: usize, const D: usize, const E: usize, R, const W: usize>
    Kernel<'_, S, T, V, D, E, R, W>
where
    S: Simd,
    T: Transpose,
    R: Batched<W>,
{
    /// `y += A x`.
    #[inline(always)]
    pub(super) fn stiffness(self) {
        let lame = &self.batch.lame;
        self.elastic(lame);
    }

    /// The same with the lambda of an approximate inverse.
    #[inline(always)]
    pub(super) fn augmented_stiffness(self) {
        let lame = &self.batch.augmented;
        self.elastic(lame);
    }

    /// `y += A x` with `lame` for lambda.
    #[inline(always)]
    fn elastic(mut self, lame: &Lanes<R, W>) {
        self.gather();
        for part in 0..R::parts::<S>() {
            let g = self.batch.gradients_at(self.simd, part);
            let mut law = Elastic {
                shear: Pack::load(self.simd, &self.batch.shear, part),
                lame: Pack::load(self.simd, lame, part),
            };
            self.part(part).visit_points(&g, &mut law);
        }
        self.scatter();
    }

    /// `y_i += -int lambda_i div x`, in the place of the pressure.
    #[inline(always)]
    pub(super) fn divergence(mut self) {
        self.gather();
        for part in 0..R::parts::<S>() {
            let g = self.batch.gradients_at(self.simd, part);
            let weight = Pack::load(self.simd, &self.batch.weight, part);
            let mut here = self.part(part);
            let traces = here.divergences(&g);
            here.store_volumes(&traces, weight);
        }
        self.scatter_vertices();
    }

    /// `y += B^T p`, p in the place of the pressure of `x`.
    #[inline(always)]
    pub(super) fn divergence_transposed(mut self) {
        self.gather_vertices();
        for part in 0..R::parts::<S>() {
            let g = self.batch.gradients_at(self.simd, part);
            let weight = Pack::load(self.simd, &self.batch.weight, part);
            self.part(part).store_pressure_forces(&g, weight);
        }
        self.scatter();
    }

    /// `y += (A u + B^T p, B u)`.
    #[inline(always)]
    pub(super) fn saddle(mut self) {
        self.gather();
        for part in 0..R::parts::<S>() {
            let g = self.batch.gradients_at(self.simd, part);
            let shear = Pack::load(self.simd, &self.batch.shear, part);
            let lame = Pack::load(self.simd, &self.batch.lame, part);
            let weight = Pack::load(self.simd, &self.batch.weight, part);
            let mut here = self.part(part);
            let pressure = here.pressures(weight);
            let mut law = Pressed {
                elastic: Elastic { shear, lame },
                pressure,
                traces: pressure,
            };
            here.visit_points(&g, &mut law);
            here.store_volumes(&law.traces, weight);
        }
        self.scatter();
    }

    #[inline(always)]
    fn part(&mut self, part: usize) -> ElementPart<'_, S, V, E, R, W> {
        ElementPart {
            simd: self.simd,
            part,
            vertices: &mut self.element.vertices,
            edges: &mut self.element.edges,
        }
    }

    #[inline(always)]
    fn gather(&mut self) {
        self.gather_vertices();
        let edges = &mut self.element.edges;
        gather(self.transpose, &self.batch.edges, self.x, edges);
    }

    #[inline(always)]
    fn gather_vertices(&mut self) {
        let vertices = &mut self.element.vertices;
        gather(self.transpose, &self.batch.vertices, self.x, vertices);
    }

    #[inline(always)]
    fn scatter(mut self) {
        self.scatter_vertices();
        let edges = &self.element.edges;
        scatter(self.transpose, &self.batch.edges, edges, self.y);
    }

    #[inline(always)]
    fn scatter_vertices(&mut self) {
        let vertices = &self.element.vertices;
        scatter(self.transpose, &self.batch.vertices, vertices, self.y);
    }
}

impl<S: Simd, T: Transpose, R: Batched<W>, const W: usize> Kernel<'_, S, T, 4, 3, 6, R, W> {
    /// `y += A x` on tetrahedra, the stress being a symmetric matrix times the displacement
    /// gradient: `tensor` is its upper triangle, row by row, times the weight.
    #[inline(always)]
    pub(super) fn tangent(mut self, tensor: &[Lanes<R, W>; SYMMETRIC_ENTRIES]) {
        let simd = self.simd;
        self.gather();
        for part in 0..R::parts::<S>() {
            let g = self.batch.gradients_at(simd, part);
            let mut law = Tangent { simd, part, tensor };
            self.part(part).visit_points(&g, &mut law);
        }
        self.scatter();
    }
}
