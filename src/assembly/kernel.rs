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

pub(super) mod points;

use pulp::Simd;

use super::lanes::{Lanes, Pack, WIDTH};
use super::transpose::{Batched, Row, Transpose};
use crate::linalg::Scalar;
pub use points::edge_factor;
use points::{
    Elastic, Pressed, Tangent, bases, edge_of, gradients, pressures, store_forces, visit_points,
    volumes, zeros,
};

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

/// `y += A x` on one batch: A = int 2 mu eps : eps + lambda div div.
#[inline(always)]
pub fn stiffness<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E, R, W>,
    element: &mut Element<V, E, R, W>,
    x: &[Row<R>],
    y: &mut [Row<R>],
) {
    elastic(simd, transpose, (batch, &batch.lame), element, x, y);
}

/// The same with the lambda of an approximate inverse.
#[inline(always)]
pub fn augmented_stiffness<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E, R, W>,
    element: &mut Element<V, E, R, W>,
    x: &[Row<R>],
    y: &mut [Row<R>],
) {
    elastic(simd, transpose, (batch, &batch.augmented), element, x, y);
}

/// [`stiffness`] with `lame` for lambda.
#[inline(always)]
fn elastic<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    (batch, lame): (&Batch<V, D, E, R, W>, &Lanes<R, W>),
    element: &mut Element<V, E, R, W>,
    x: &[Row<R>],
    y: &mut [Row<R>],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..R::parts::<S>() {
        let g = gradients(simd, batch, part);
        let shear = Pack::load(simd, &batch.shear, part);
        let lame = Pack::load(simd, lame, part);
        let mut law = Elastic { shear, lame };
        visit_points(simd, &g, (&mut *vertices, &mut *edges), part, &mut law);
    }
    scatter(transpose, &batch.vertices, vertices, y);
    scatter(transpose, &batch.edges, edges, y);
}

/// `y += A x` on one batch of tetrahedra, the stress being a symmetric matrix times the displacement
/// gradient: `tensor` is its upper triangle, row by row, times the weight.
#[inline(always)]
pub fn tangent<S: Simd, T: Transpose, R: Batched<W>, const W: usize>(
    simd: S,
    transpose: T,
    (batch, tensor): (&Batch<4, 3, 6, R, W>, &[Lanes<R, W>; SYMMETRIC_ENTRIES]),
    element: &mut Element<4, 6, R, W>,
    x: &[Row<R>],
    y: &mut [Row<R>],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..R::parts::<S>() {
        let g = gradients(simd, batch, part);
        let mut law = Tangent { simd, part, tensor };
        visit_points(simd, &g, (&mut *vertices, &mut *edges), part, &mut law);
    }
    scatter(transpose, &batch.vertices, vertices, y);
    scatter(transpose, &batch.edges, edges, y);
}

/// `r_i += -int lambda_i div u` on one batch, in the place of the pressure.
#[inline(always)]
pub fn divergence<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E, R, W>,
    element: &mut Element<V, E, R, W>,
    x: &[Row<R>],
    r: &mut [Row<R>],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..R::parts::<S>() {
        let g = gradients(simd, batch, part);
        let base = bases::<S, V, D, E, R, W>(simd, vertices, edges, part);
        let mut constant = Pack::splat(simd, 0.0);
        for a in 0..V {
            for i in 0..D {
                constant = constant.plus_product(base[a][i], g[a][i]);
            }
        }
        let mut traces = [constant; V];
        for (q, trace) in traces.iter_mut().enumerate() {
            for a in (0..V).filter(|&a| a != q) {
                let edge = &edges[edge_of::<V>(a, q)];
                for i in 0..D {
                    let c = Pack::load(simd, &edge[i], part);
                    *trace = trace.plus_product(c, g[a][i]);
                }
            }
        }
        let weight = Pack::load(simd, &batch.weight, part);
        volumes(simd, &traces, weight, vertices, part);
    }
    scatter(transpose, &batch.vertices, vertices, r);
}

/// `y += B^T p` on one batch; p in the place of the pressure.
#[inline(always)]
pub fn divergence_transposed<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E, R, W>,
    element: &mut Element<V, E, R, W>,
    p: &[Row<R>],
    y: &mut [Row<R>],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, p, vertices);
    for part in 0..R::parts::<S>() {
        let g = gradients(simd, batch, part);
        let weight = Pack::load(simd, &batch.weight, part);
        let pressure = pressures(simd, vertices, -weight, part);
        let mut sum = Pack::splat(simd, 0.0);
        for &value in &pressure {
            sum += value;
        }
        let mut totals = g;
        for total in totals.as_flattened_mut() {
            *total = *total * sum;
        }
        let mut at_edges = zeros::<S, E, D, R>(simd);
        for (force, (a, b)) in at_edges.iter_mut().zip(edge_pairs::<E>()) {
            for i in 0..D {
                force[i] = (pressure[b] * g[a][i]).plus_product(pressure[a], g[b][i]);
            }
        }
        store_forces(
            simd,
            &totals,
            &at_edges,
            (&mut *vertices, &mut *edges),
            part,
        );
    }
    scatter(transpose, &batch.vertices, vertices, y);
    scatter(transpose, &batch.edges, edges, y);
}

/// `(y, r) += (A u + B^T p, B u)` on one batch.
#[inline(always)]
pub fn saddle<
    S: Simd,
    T: Transpose,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Batched<W>,
    const W: usize,
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E, R, W>,
    element: &mut Element<V, E, R, W>,
    x: &[Row<R>],
    y: &mut [Row<R>],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..R::parts::<S>() {
        let g = gradients(simd, batch, part);
        let shear = Pack::load(simd, &batch.shear, part);
        let lame = Pack::load(simd, &batch.lame, part);
        let weight = Pack::load(simd, &batch.weight, part);
        let pressure = pressures(simd, vertices, weight, part);
        let mut law = Pressed {
            elastic: Elastic { shear, lame },
            pressure,
            traces: pressure,
        };
        visit_points(simd, &g, (&mut *vertices, &mut *edges), part, &mut law);
        volumes(simd, &law.traces, weight, vertices, part);
    }
    scatter(transpose, &batch.vertices, vertices, y);
    scatter(transpose, &batch.edges, edges, y);
}
