//! The innermost element kernels, eight elements at a time: `V` vertices, `D`
//! components, `E` edges.
//!
//! In the hierarchical basis grad u = sum_a H_a (x) grad lambda_a with
//! H_a(q) = u_a + 4 sum_j lambda_j(q) c_aj. The rule of degree 2 has V points;
//! at point q, lambda_j = ALPHA if j = q, else BETA, so one base per vertex and
//! one edge coefficient per (vertex, point) replace the dense tabulation. The
//! rule is exact for straight-sided linear elasticity.

use super::lanes::{Lanes, WIDTH};

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
        pairs[edge] = if E == 3 { triangle[edge] } else { tetrahedron[edge] };
        edge += 1;
    }
    pairs
}

type Vectors<const N: usize, const D: usize> = [[Lanes; D]; N];
type Tensor<const D: usize> = [[Lanes; D]; D];

#[inline(always)]
fn gather<const D: usize>(nodes: &[u32; WIDTH], x: &[f64]) -> [Lanes; D] {
    let mut out = [Lanes::ZERO; D];
    for lane in 0..WIDTH {
        let start = nodes[lane] as usize * D;
        let values = &x[start..start + D];
        for i in 0..D {
            out[i].0[lane] = values[i];
        }
    }
    out
}

#[inline(always)]
fn scatter<const D: usize>(nodes: &[u32; WIDTH], values: &[Lanes; D], y: &mut [f64]) {
    for lane in 0..WIDTH {
        let start = nodes[lane] as usize * D;
        let target = &mut y[start..start + D];
        for i in 0..D {
            target[i] += values[i].0[lane];
        }
    }
}

/// Nodal data of a batch: the constant part of H per vertex, edge corrections.
struct Local<const V: usize, const D: usize, const E: usize> {
    base: Vectors<V, D>,
    edges: Vectors<E, D>,
}

#[inline(always)]
fn load<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    x: &[f64],
) -> Local<V, D, E> {
    let (_, beta) = rule(V);
    let pairs = edge_pairs::<E>();
    let mut base = [[Lanes::ZERO; D]; V];
    let mut edges = [[Lanes::ZERO; D]; E];
    for a in 0..V {
        base[a] = gather::<D>(&batch.nodes[a], x);
    }
    for e in 0..E {
        edges[e] = gather::<D>(&batch.nodes[V + e], x);
        let (a, b) = pairs[e];
        for i in 0..D {
            let part = edges[e][i] * (4.0 * beta);
            base[a][i] += part;
            base[b][i] += part;
        }
    }
    Local { base, edges }
}

/// Gradient of barycentric coordinate `a`.
#[inline(always)]
fn gradient<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
) -> Vectors<V, D> {
    let mut out = [[Lanes::ZERO; D]; V];
    for j in 0..D {
        for a in 0..D {
            out[a + 1][j] = batch.gradients[a][j];
            out[0][j] = out[0][j] - batch.gradients[a][j];
        }
    }
    out
}

/// Displacement gradient at each point.
#[inline(always)]
fn gradients_at_points<const V: usize, const D: usize, const E: usize>(
    local: &Local<V, D, E>,
    g: &Vectors<V, D>,
) -> [Tensor<D>; V] {
    let (alpha, beta) = rule(V);
    let gamma = 4.0 * (alpha - beta);
    let mut constant = [[Lanes::ZERO; D]; D];
    for a in 0..V {
        for i in 0..D {
            for j in 0..D {
                constant[i][j] = constant[i][j].plus_product(local.base[a][i], g[a][j]);
            }
        }
    }
    let mut out = [constant; V];
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        for i in 0..D {
            let c = local.edges[e][i] * gamma;
            for j in 0..D {
                out[b][i][j] = out[b][i][j].plus_product(c, g[a][j]);
                out[a][i][j] = out[a][i][j].plus_product(c, g[b][j]);
            }
        }
    }
    out
}

/// Adds the nodal forces of weighted stresses at the points.
#[inline(always)]
fn scatter_stress<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    stress: &[Tensor<D>; V],
    g: &Vectors<V, D>,
    y: &mut [f64],
) {
    let (alpha, beta) = rule(V);
    let gamma = 4.0 * (alpha - beta);
    let mut sum = [[Lanes::ZERO; D]; D];
    for point in stress {
        for i in 0..D {
            for j in 0..D {
                sum[i][j] += point[i][j];
            }
        }
    }
    let mut total = [[Lanes::ZERO; D]; V];
    for a in 0..V {
        total[a] = traction(&sum, &g[a]);
        scatter(&batch.nodes[a], &total[a], y);
    }
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        let at_b = traction(&stress[b], &g[a]);
        let at_a = traction(&stress[a], &g[b]);
        let mut force = [Lanes::ZERO; D];
        for i in 0..D {
            force[i] = (total[a][i] + total[b][i]) * (4.0 * beta) + (at_a[i] + at_b[i]) * gamma;
        }
        scatter(&batch.nodes[V + e], &force, y);
    }
}

#[inline(always)]
fn traction<const D: usize>(stress: &Tensor<D>, direction: &[Lanes; D]) -> [Lanes; D] {
    let mut out = [Lanes::ZERO; D];
    for i in 0..D {
        for j in 0..D {
            out[i] = out[i].plus_product(stress[i][j], direction[j]);
        }
    }
    out
}

/// `y += A x` on one batch: A = int 2 mu eps : eps + lambda div div.
#[inline(never)]
pub fn stiffness<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    x: &[f64],
    y: &mut [f64],
) {
    let g = gradient(batch);
    let mut points = gradients_at_points(&load(batch, x), &g);
    for point in &mut points {
        let mut trace = Lanes::ZERO;
        for i in 0..D {
            trace += point[i][i];
        }
        let volumetric = trace * batch.lame;
        let h = *point;
        for i in 0..D {
            for j in 0..D {
                point[i][j] = (h[i][j] + h[j][i]) * batch.shear;
            }
            point[i][i] += volumetric;
        }
    }
    scatter_stress(batch, &points, &g, y);
}

/// `r_i += -int lambda_i div u` on one batch; `r` has one entry per node.
#[inline(never)]
pub fn divergence<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    x: &[f64],
    r: &mut [f64],
) {
    let (alpha, beta) = rule(V);
    let g = gradient(batch);
    let points = gradients_at_points(&load(batch, x), &g);
    let mut traces = [Lanes::ZERO; V];
    let mut sum = Lanes::ZERO;
    for (trace, point) in traces.iter_mut().zip(&points) {
        for i in 0..D {
            *trace += point[i][i];
        }
        sum += *trace;
    }
    for a in 0..V {
        let value = -((sum * beta + traces[a] * (alpha - beta)) * batch.weight);
        scatter(&batch.nodes[a], &[value], r);
    }
}

/// `y += B^T p` on one batch; `p` has one entry per node.
#[inline(never)]
pub fn divergence_transposed<const V: usize, const D: usize, const E: usize>(
    batch: &Batch<V, D, E>,
    p: &[f64],
    y: &mut [f64],
) {
    let (alpha, beta) = rule(V);
    let g = gradient(batch);
    let mut values = [Lanes::ZERO; V];
    let mut sum = Lanes::ZERO;
    for a in 0..V {
        values[a] = gather::<1>(&batch.nodes[a], p)[0];
        sum += values[a];
    }
    let mut points = [[[Lanes::ZERO; D]; D]; V];
    for (q, point) in points.iter_mut().enumerate() {
        let pressure = -((sum * beta + values[q] * (alpha - beta)) * batch.weight);
        for i in 0..D {
            point[i][i] = pressure;
        }
    }
    scatter_stress(batch, &points, &g, y);
}
