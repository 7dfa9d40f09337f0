//! The innermost element kernels, eight elements at a time: `V` vertices, `D`
//! components, `E` edges.
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

use pulp::Simd;

use super::lanes::{Lanes, Pack, WIDTH};
use super::transpose::{Row, Transpose};

/// Place of the pressure in a row.
pub const PRESSURE: usize = 3;

/// One batch of elements.
#[derive(Clone, Debug)]
pub struct Batch<const V: usize, const D: usize, const E: usize> {
    /// Vertices inside the block.
    pub vertices: [[u16; WIDTH]; V],
    /// Edge nodes inside the block.
    pub edges: [[u16; WIDTH]; E],
    /// Gradients of barycentric coordinates 1..V.
    pub gradients: [[Lanes; D]; D],
    /// Volume over number of points, times mu.
    pub shear: Lanes,
    /// Volume over number of points, times lambda of the displacement form.
    pub lame: Lanes,
    /// Volume over number of points.
    pub weight: Lanes,
}

/// Barycentric coordinates of the rule's points: at the own vertex, elsewhere.
pub fn rule(vertices: usize) -> (f64, f64) {
    match vertices {
        3 => (2.0 / 3.0, 1.0 / 6.0),
        _ => (0.585_410_196_624_968_5, 0.138_196_601_125_010_5),
    }
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

type Vectors<S, const N: usize, const D: usize> = [[Pack<S>; D]; N];
type Tensor<S, const D: usize> = [[Pack<S>; D]; D];
/// Nodal values of a batch in memory: displacement, pressure in the last place.
type NodeLanes<const N: usize> = [[Lanes; 4]; N];

/// Nodal values of the batch at work; made once for all batches of a pass, as
/// clearing it takes as long as a third of a batch.
#[derive(Clone, Debug)]
pub struct Element<const V: usize, const E: usize> {
    vertices: NodeLanes<V>,
    edges: NodeLanes<E>,
}

impl<const V: usize, const E: usize> Element<V, E> {
    /// All zero.
    pub const ZERO: Self = Self {
        vertices: [[Lanes::ZERO; 4]; V],
        edges: [[Lanes::ZERO; 4]; E],
    };
}

#[inline(always)]
fn gather<T: Transpose, const N: usize>(
    transpose: T,
    nodes: &[[u16; WIDTH]; N],
    x: &[Row],
    values: &mut NodeLanes<N>,
) {
    for (values, nodes) in values.iter_mut().zip(nodes) {
        *values = transpose.to_lanes(nodes.each_ref().map(|&node| &x[usize::from(node)]));
    }
}

#[inline(always)]
fn scatter<T: Transpose, const N: usize>(
    transpose: T,
    nodes: &[[u16; WIDTH]; N],
    values: &NodeLanes<N>,
    y: &mut [Row],
) {
    for (values, nodes) in values.iter().zip(nodes) {
        let rows = transpose.to_rows(values);
        for (row, &node) in rows.iter().zip(nodes) {
            let target = &mut y[usize::from(node)];
            for i in 0..4 {
                target[i] += row[i];
            }
        }
    }
}

#[inline(always)]
fn zeros<S: Simd, const N: usize, const D: usize>(simd: S) -> Vectors<S, N, D> {
    [[Pack::splat(simd, 0.0); D]; N]
}

/// Gradients of all barycentric coordinates in one part of a batch.
#[inline(always)]
fn gradients<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    batch: &Batch<V, D, E>,
    part: usize,
) -> Vectors<S, V, D> {
    let mut out = zeros::<S, V, D>(simd);
    for j in 0..D {
        for a in 0..D {
            let slope = Pack::load(simd, &batch.gradients[a][j], part);
            out[a + 1][j] = slope;
            out[0][j] = out[0][j] - slope;
        }
    }
    out
}

/// The edge between two vertices, by the order of [`edge_pairs`].
#[inline(always)]
const fn edge_of<const V: usize>(a: usize, b: usize) -> usize {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    // Edges of lower first vertices come before.
    low * V - low * (low + 1) / 2 + high - low - 1
}

/// Factor of edge corrections: in the kernels an edge carries
/// 4 (alpha - beta) c.
pub fn edge_factor(vertices: usize) -> f64 {
    let (alpha, beta) = rule(vertices);
    4.0 * (alpha - beta)
}

/// u_a + 4 beta sum_j c_aj, in one part of a batch.
#[inline(always)]
fn bases<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    vertices: &NodeLanes<V>,
    edges: &NodeLanes<E>,
    part: usize,
) -> Vectors<S, V, D> {
    let (alpha, beta) = rule(V);
    let shared = Pack::splat(simd, beta / (alpha - beta));
    let mut sums = zeros::<S, V, D>(simd);
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        for i in 0..D {
            let c = Pack::load(simd, &edges[e][i], part);
            sums[a][i] += c;
            sums[b][i] += c;
        }
    }
    for a in 0..V {
        for i in 0..D {
            let vertex = Pack::load(simd, &vertices[a][i], part);
            sums[a][i] = vertex.plus_product(sums[a][i], shared);
        }
    }
    sums
}

/// Turns the displacement gradient at a point into a weighted stress. A trait
/// and not a closure: only a method is sure to be inlined, and without that
/// every sum is a call.
trait Law<S: Simd, const D: usize> {
    fn stress(&mut self, point: usize, h: &Tensor<S, D>) -> Tensor<S, D>;
}

/// 2 mu eps + lambda div I.
struct Elastic<S: Simd> {
    shear: Pack<S>,
    lame: Pack<S>,
}

impl<S: Simd, const D: usize> Law<S, D> for Elastic<S> {
    #[inline(always)]
    fn stress(&mut self, _point: usize, h: &Tensor<S, D>) -> Tensor<S, D> {
        stress(h, trace(h), self.shear, self.lame)
    }
}

/// The same less the pressure; keeps the divergences.
struct Pressed<S: Simd, const V: usize> {
    elastic: Elastic<S>,
    /// Weighted, at the points.
    pressure: [Pack<S>; V],
    traces: [Pack<S>; V],
}

impl<S: Simd, const V: usize, const D: usize> Law<S, D> for Pressed<S, V> {
    #[inline(always)]
    fn stress(&mut self, point: usize, h: &Tensor<S, D>) -> Tensor<S, D> {
        let divergence = trace(h);
        self.traces[point] = divergence;
        let mut total = stress(h, divergence, self.elastic.shear, self.elastic.lame);
        for i in 0..D {
            total[i][i] = total[i][i] - self.pressure[point];
        }
        total
    }
}

/// What the points of an element share, in one part of a batch.
struct Sweep<'a, S: Simd, const V: usize, const D: usize, const E: usize> {
    g: &'a Vectors<S, V, D>,
    edges: &'a NodeLanes<E>,
    constant: Tensor<S, D>,
    /// Stresses of the points so far.
    sum: Tensor<S, D>,
    /// What they add at edges.
    at_edges: Vectors<S, E, D>,
    part: usize,
}

impl<S: Simd, const V: usize, const D: usize, const E: usize> Sweep<'_, S, V, D, E> {
    /// Visits point `Q`, a constant so that the loops unroll and the sums stay
    /// in registers.
    #[inline(always)]
    fn visit<const Q: usize>(&mut self, simd: S, law: &mut impl Law<S, D>) {
        let mut h = self.constant;
        for k in 1..V {
            let a = (Q + k) % V;
            let edge = &self.edges[edge_of::<V>(a, Q)];
            for i in 0..D {
                let c = Pack::load(simd, &edge[i], self.part);
                for j in 0..D {
                    h[i][j] = h[i][j].plus_product(c, self.g[a][j]);
                }
            }
        }
        let stress = law.stress(Q, &h);
        for i in 0..D {
            for j in 0..D {
                self.sum[i][j] += stress[i][j];
            }
        }
        for k in 1..V {
            let a = (Q + k) % V;
            let force = &mut self.at_edges[edge_of::<V>(a, Q)];
            for i in 0..D {
                for j in 0..D {
                    force[i] = force[i].plus_product(stress[i][j], self.g[a][j]);
                }
            }
        }
    }
}

/// Visits the points in one part of a batch: nodal forces of the stress that
/// `law` gives replace the argument.
#[inline(always)]
fn visit_points<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    g: &Vectors<S, V, D>,
    (vertices, edges): (&mut NodeLanes<V>, &mut NodeLanes<E>),
    part: usize,
    law: &mut impl Law<S, D>,
) {
    let base = bases::<S, V, D, E>(simd, vertices, edges, part);
    let mut constant = zeros::<S, D, D>(simd);
    for a in 0..V {
        for i in 0..D {
            for j in 0..D {
                constant[i][j] = constant[i][j].plus_product(base[a][i], g[a][j]);
            }
        }
    }
    let mut sweep = Sweep {
        g,
        edges: &*edges,
        constant,
        sum: zeros::<S, D, D>(simd),
        at_edges: zeros::<S, E, D>(simd),
        part,
    };
    sweep.visit::<0>(simd, law);
    sweep.visit::<1>(simd, law);
    sweep.visit::<2>(simd, law);
    if V > 3 {
        sweep.visit::<3>(simd, law);
    }
    let (sum, at_edges) = (sweep.sum, sweep.at_edges);
    let mut totals = zeros::<S, V, D>(simd);
    for a in 0..V {
        totals[a] = traction(simd, &sum, &g[a]);
    }
    store_forces(simd, &totals, &at_edges, (vertices, edges), part);
}

/// Forces of vertices and edges from the sum over the points at vertices and
/// what the points add at edges.
#[inline(always)]
fn store_forces<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    totals: &Vectors<S, V, D>,
    at_edges: &Vectors<S, E, D>,
    (vertices, edges): (&mut NodeLanes<V>, &mut NodeLanes<E>),
    part: usize,
) {
    let (alpha, beta) = rule(V);
    let shared = Pack::splat(simd, beta / (alpha - beta));
    for a in 0..V {
        for i in 0..D {
            totals[a][i].store(&mut vertices[a][i], part);
        }
    }
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        for i in 0..D {
            let both = totals[a][i] + totals[b][i];
            let force = at_edges[e][i].plus_product(both, shared);
            force.store(&mut edges[e][i], part);
        }
    }
}

#[inline(always)]
fn traction<S: Simd, const D: usize>(
    simd: S,
    stress: &Tensor<S, D>,
    direction: &[Pack<S>; D],
) -> [Pack<S>; D] {
    let mut out = [Pack::splat(simd, 0.0); D];
    for i in 0..D {
        for j in 0..D {
            out[i] = out[i].plus_product(stress[i][j], direction[j]);
        }
    }
    out
}

/// Weighted stress 2 mu eps + lambda div I from a displacement gradient.
#[inline(always)]
fn stress<S: Simd, const D: usize>(
    h: &Tensor<S, D>,
    trace: Pack<S>,
    shear: Pack<S>,
    lame: Pack<S>,
) -> Tensor<S, D> {
    let volumetric = trace * lame;
    let mut out = *h;
    for i in 0..D {
        for j in 0..D {
            out[i][j] = (h[i][j] + h[j][i]) * shear;
        }
        out[i][i] += volumetric;
    }
    out
}

#[inline(always)]
fn trace<S: Simd, const D: usize>(h: &Tensor<S, D>) -> Pack<S> {
    let mut sum = h[0][0];
    for i in 1..D {
        sum += h[i][i];
    }
    sum
}

/// -int lambda_a div u from the divergences at the points, in one part.
#[inline(always)]
fn volumes<S: Simd, const V: usize>(
    simd: S,
    traces: &[Pack<S>; V],
    weight: Pack<S>,
    vertices: &mut NodeLanes<V>,
    part: usize,
) {
    let (alpha, beta) = rule(V);
    let mut sum = Pack::splat(simd, 0.0);
    for &trace in traces {
        sum += trace;
    }
    let shared = sum * (-beta) * weight;
    let own = weight * (beta - alpha);
    for a in 0..V {
        let value = shared.plus_product(traces[a], own);
        value.store(&mut vertices[a][PRESSURE], part);
    }
}

/// Weighted pressures at the points, in one part.
#[inline(always)]
fn pressures<S: Simd, const V: usize>(
    simd: S,
    vertices: &NodeLanes<V>,
    weight: Pack<S>,
    part: usize,
) -> [Pack<S>; V] {
    let (alpha, beta) = rule(V);
    let mut values = [Pack::splat(simd, 0.0); V];
    let mut sum = Pack::splat(simd, 0.0);
    for a in 0..V {
        values[a] = Pack::load(simd, &vertices[a][PRESSURE], part);
        sum += values[a];
    }
    let shared = sum * beta * weight;
    let own = weight * (alpha - beta);
    values.map(|value| shared.plus_product(value, own))
}

/// `y += A x` on one batch: A = int 2 mu eps : eps + lambda div div.
#[inline(always)]
pub fn stiffness<S: Simd, T: Transpose, const V: usize, const D: usize, const E: usize>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E>,
    element: &mut Element<V, E>,
    x: &[Row],
    y: &mut [Row],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..Pack::<S>::PARTS {
        let g = gradients(simd, batch, part);
        let shear = Pack::load(simd, &batch.shear, part);
        let lame = Pack::load(simd, &batch.lame, part);
        let mut law = Elastic { shear, lame };
        visit_points(simd, &g, (&mut *vertices, &mut *edges), part, &mut law);
    }
    scatter(transpose, &batch.vertices, vertices, y);
    scatter(transpose, &batch.edges, edges, y);
}

/// `r_i += -int lambda_i div u` on one batch, in the place of the pressure.
#[inline(always)]
pub fn divergence<S: Simd, T: Transpose, const V: usize, const D: usize, const E: usize>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E>,
    element: &mut Element<V, E>,
    x: &[Row],
    r: &mut [Row],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..Pack::<S>::PARTS {
        let g = gradients(simd, batch, part);
        let base = bases::<S, V, D, E>(simd, vertices, edges, part);
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
>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E>,
    element: &mut Element<V, E>,
    p: &[Row],
    y: &mut [Row],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, p, vertices);
    for part in 0..Pack::<S>::PARTS {
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
        let mut at_edges = zeros::<S, E, D>(simd);
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
pub fn saddle<S: Simd, T: Transpose, const V: usize, const D: usize, const E: usize>(
    simd: S,
    transpose: T,
    batch: &Batch<V, D, E>,
    element: &mut Element<V, E>,
    x: &[Row],
    y: &mut [Row],
) {
    let Element { vertices, edges } = element;
    gather(transpose, &batch.vertices, x, vertices);
    gather(transpose, &batch.edges, x, edges);
    for part in 0..Pack::<S>::PARTS {
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
