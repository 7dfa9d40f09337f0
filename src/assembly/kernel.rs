//! The innermost element kernels, eight elements at a time: `V` vertices, `D`
//! components, `E` edges.
//!
//! In the hierarchical basis grad u = sum_a H_a (x) grad lambda_a with
//! H_a(q) = u_a + 4 sum_j lambda_j(q) c_aj. The rule of degree 2 has V points;
//! at point q, lambda_j = ALPHA if j = q, else BETA, so one base per vertex and
//! one edge coefficient per (vertex, point) replace the dense tabulation. The
//! rule is exact for straight-sided linear elasticity.

use pulp::Simd;

use super::lanes::{Lanes, Pack, WIDTH};

/// One batch of elements.
#[derive(Clone, Debug)]
pub struct Batch<const V: usize, const D: usize, const E: usize> {
    /// Node numbers inside the block, vertices first.
    pub nodes: Vec<[u32; WIDTH]>,
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
/// Nodal vectors of a batch in memory.
type NodeLanes<const N: usize, const D: usize> = [[Lanes; D]; N];

#[inline(always)]
fn gather<const D: usize>(nodes: &[u32; WIDTH], x: &[f64]) -> [Lanes; D] {
    let mut out = [Lanes::ZERO; D];
    let (rows, _) = x.as_chunks::<D>();
    for lane in 0..WIDTH {
        let values = &rows[nodes[lane] as usize];
        for i in 0..D {
            out[i].0[lane] = values[i];
        }
    }
    out
}

#[inline(always)]
fn scatter<const D: usize>(nodes: &[u32; WIDTH], values: &[Lanes; D], y: &mut [f64]) {
    let (rows, _) = y.as_chunks_mut::<D>();
    for lane in 0..WIDTH {
        let target = &mut rows[nodes[lane] as usize];
        for i in 0..D {
            target[i] += values[i].0[lane];
        }
    }
}

/// Vertex values and edge corrections of a batch.
#[inline(always)]
fn gather_nodes<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    x: &[f64],
) -> (NodeLanes<V, D>, NodeLanes<E, D>) {
    let (mut vertices, mut edges) = ([[Lanes::ZERO; D]; V], [[Lanes::ZERO; D]; E]);
    for a in 0..V {
        vertices[a] = gather(&batch.nodes[a], x);
    }
    for e in 0..E {
        edges[e] = gather(&batch.nodes[V + e], x);
    }
    (vertices, edges)
}

#[inline(always)]
fn scatter_nodes<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    vertices: &NodeLanes<V, D>,
    edges: &NodeLanes<E, D>,
    y: &mut [f64],
) {
    for a in 0..V {
        scatter(&batch.nodes[a], &vertices[a], y);
    }
    for e in 0..E {
        scatter(&batch.nodes[V + e], &edges[e], y);
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

/// Displacement gradient at each point, in one part of a batch.
#[inline(always)]
fn gradients_at_points<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    vertices: &NodeLanes<V, D>,
    edges: &NodeLanes<E, D>,
    g: &Vectors<S, V, D>,
    part: usize,
) -> [Tensor<S, D>; V] {
    let (alpha, beta) = rule(V);
    let gamma = 4.0 * (alpha - beta);
    let pairs = edge_pairs::<E>();
    let mut base = zeros::<S, V, D>(simd);
    for a in 0..V {
        for i in 0..D {
            base[a][i] = Pack::load(simd, &vertices[a][i], part);
        }
    }
    for (e, &(a, b)) in pairs.iter().enumerate() {
        for i in 0..D {
            let shared = Pack::load(simd, &edges[e][i], part) * (4.0 * beta);
            base[a][i] += shared;
            base[b][i] += shared;
        }
    }
    let mut constant = zeros::<S, D, D>(simd);
    for a in 0..V {
        for i in 0..D {
            for j in 0..D {
                constant[i][j] = constant[i][j].plus_product(base[a][i], g[a][j]);
            }
        }
    }
    let mut out = [constant; V];
    for (e, &(a, b)) in pairs.iter().enumerate() {
        for i in 0..D {
            let c = Pack::load(simd, &edges[e][i], part) * gamma;
            for j in 0..D {
                out[b][i][j] = out[b][i][j].plus_product(c, g[a][j]);
                out[a][i][j] = out[a][i][j].plus_product(c, g[b][j]);
            }
        }
    }
    out
}

/// Nodal forces of weighted stresses at the points, in one part of a batch.
#[inline(always)]
fn forces<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    stress: &[Tensor<S, D>; V],
    g: &Vectors<S, V, D>,
    part: usize,
    vertices: &mut NodeLanes<V, D>,
    edges: &mut NodeLanes<E, D>,
) {
    let (alpha, beta) = rule(V);
    let gamma = 4.0 * (alpha - beta);
    let mut sum = zeros::<S, D, D>(simd);
    for point in stress {
        for i in 0..D {
            for j in 0..D {
                sum[i][j] += point[i][j];
            }
        }
    }
    let mut total = zeros::<S, V, D>(simd);
    for a in 0..V {
        total[a] = traction(simd, &sum, &g[a]);
        for i in 0..D {
            total[a][i].store(&mut vertices[a][i], part);
        }
    }
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        let at_b = traction(simd, &stress[b], &g[a]);
        let at_a = traction(simd, &stress[a], &g[b]);
        for i in 0..D {
            let force = (total[a][i] + total[b][i]) * (4.0 * beta) + (at_a[i] + at_b[i]) * gamma;
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

/// `y += A x` on one batch: A = int 2 mu eps : eps + lambda div div.
#[inline(always)]
pub fn stiffness<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    batch: &Batch<V, D, E>,
    x: &[f64],
    y: &mut [f64],
) {
    let (mut vertices, mut edges) = gather_nodes(batch, x);
    for part in 0..Pack::<S>::PARTS {
        let g = gradients(simd, batch, part);
        let mut points = gradients_at_points(simd, &vertices, &edges, &g, part);
        let shear = Pack::load(simd, &batch.shear, part);
        let lame = Pack::load(simd, &batch.lame, part);
        for point in &mut points {
            let h = *point;
            let mut trace = h[0][0];
            for i in 1..D {
                trace += h[i][i];
            }
            let volumetric = trace * lame;
            for i in 0..D {
                for j in 0..D {
                    point[i][j] = (h[i][j] + h[j][i]) * shear;
                }
                point[i][i] += volumetric;
            }
        }
        forces(simd, &points, &g, part, &mut vertices, &mut edges);
    }
    scatter_nodes(batch, &vertices, &edges, y);
}

/// `r_i += -int lambda_i div u` on one batch; `r` has one entry per node.
#[inline(always)]
pub fn divergence<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    batch: &Batch<V, D, E>,
    x: &[f64],
    r: &mut [f64],
) {
    let (alpha, beta) = rule(V);
    let (vertices, edges) = gather_nodes(batch, x);
    let mut out = [[Lanes::ZERO; 1]; V];
    for part in 0..Pack::<S>::PARTS {
        let g = gradients(simd, batch, part);
        let points = gradients_at_points(simd, &vertices, &edges, &g, part);
        let weight = -Pack::load(simd, &batch.weight, part);
        let mut traces = [Pack::splat(simd, 0.0); V];
        let mut sum = Pack::splat(simd, 0.0);
        for (trace, point) in traces.iter_mut().zip(&points) {
            for i in 0..D {
                *trace += point[i][i];
            }
            sum += *trace;
        }
        for a in 0..V {
            let value = (sum * beta + traces[a] * (alpha - beta)) * weight;
            value.store(&mut out[a][0], part);
        }
    }
    for a in 0..V {
        scatter(&batch.nodes[a], &out[a], r);
    }
}

/// `y += B^T p` on one batch; `p` has one entry per node.
#[inline(always)]
pub fn divergence_transposed<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    batch: &Batch<V, D, E>,
    p: &[f64],
    y: &mut [f64],
) {
    let (alpha, beta) = rule(V);
    let mut pressures = [[Lanes::ZERO; 1]; V];
    for a in 0..V {
        pressures[a] = gather(&batch.nodes[a], p);
    }
    let (mut vertices, mut edges) = ([[Lanes::ZERO; D]; V], [[Lanes::ZERO; D]; E]);
    for part in 0..Pack::<S>::PARTS {
        let g = gradients(simd, batch, part);
        let weight = -Pack::load(simd, &batch.weight, part);
        let mut values = [Pack::splat(simd, 0.0); V];
        let mut sum = Pack::splat(simd, 0.0);
        for a in 0..V {
            values[a] = Pack::load(simd, &pressures[a][0], part);
            sum += values[a];
        }
        let mut points = [zeros::<S, D, D>(simd); V];
        for (q, point) in points.iter_mut().enumerate() {
            let pressure = (sum * beta + values[q] * (alpha - beta)) * weight;
            for i in 0..D {
                point[i][i] = pressure;
            }
        }
        forces(simd, &points, &g, part, &mut vertices, &mut edges);
    }
    scatter_nodes(batch, &vertices, &edges, y);
}
