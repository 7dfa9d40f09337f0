//! Gradients, stresses and forces at the points of an element, in one part of
//! a batch; the equations stand in [`super`].

use pulp::Simd;

use super::{Batch, NodeLanes, SYMMETRIC_ENTRIES, rule};
use crate::assembly::lanes::{Lanes, Pack, Packed};

pub(in crate::assembly) type Vectors<S, const N: usize, const D: usize, R = f64> =
    [[Pack<S, R>; D]; N];
pub(in crate::assembly) type Tensor<S, const D: usize, R = f64> = [[Pack<S, R>; D]; D];

#[inline(always)]
pub(in crate::assembly) fn zeros<S: Simd, const N: usize, const D: usize, R: Packed>(
    simd: S,
) -> Vectors<S, N, D, R> {
    [[Pack::splat(simd, 0.0); D]; N]
}

impl<const V: usize, const D: usize, const E: usize, R: Packed, const W: usize>
    Batch<V, D, E, R, W>
{
    /// Gradients of all barycentric coordinates in one part of the batch.
    #[inline(always)]
    pub(in crate::assembly) fn gradients_at<S: Simd>(
        &self,
        simd: S,
        part: usize,
    ) -> Vectors<S, V, D, R> {
        let mut out = zeros::<S, V, D, R>(simd);
        for j in 0..D {
            for a in 0..D {
                let slope = Pack::load(simd, &self.gradients[a][j], part);
                out[a + 1][j] = slope;
                out[0][j] = out[0][j] - slope;
            }
        }
        out
    }
}

/// The edge between two vertices, by the order of [`edge_pairs`].
#[inline(always)]
pub(super) const fn edge_of<const V: usize>(a: usize, b: usize) -> usize {
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

/// Turns the displacement gradient at a point into a weighted stress. A trait
/// and not a closure: only a method is sure to be inlined, and without that
/// every sum is a call.
pub(super) trait Law<S: Simd, const D: usize, R: Packed> {
    fn stress(&mut self, point: usize, h: &Tensor<S, D, R>) -> Tensor<S, D, R>;
}

/// 2 mu eps + lambda div I.
pub(super) struct Elastic<S: Simd, R: Packed> {
    pub(super) shear: Pack<S, R>,
    pub(super) lame: Pack<S, R>,
}

impl<S: Simd, const D: usize, R: Packed> Law<S, D, R> for Elastic<S, R> {
    #[inline(always)]
    fn stress(&mut self, _point: usize, h: &Tensor<S, D, R>) -> Tensor<S, D, R> {
        stress(h, trace(h), self.shear, self.lame)
    }
}

/// A symmetric matrix times the gradient, row 3 i + j being component ij of the stress.
pub(super) struct Tangent<'a, S, R, const W: usize> {
    pub(super) simd: S,
    pub(super) part: usize,
    pub(super) tensor: &'a [Lanes<R, W>; SYMMETRIC_ENTRIES],
}

impl<S: Simd, R: Packed, const W: usize> Law<S, 3, R> for Tangent<'_, S, R, W> {
    #[inline(always)]
    fn stress(&mut self, _point: usize, h: &Tensor<S, 3, R>) -> Tensor<S, 3, R> {
        let mut out = zeros::<S, 3, 3, R>(self.simd);
        let mut entry = 0;
        for row in 0..9 {
            for column in row..9 {
                let value = Pack::load(self.simd, &self.tensor[entry], self.part);
                entry += 1;
                let (i, j, k, l) = (row / 3, row % 3, column / 3, column % 3);
                out[i][j] = out[i][j].plus_product(value, h[k][l]);
                if column > row {
                    out[k][l] = out[k][l].plus_product(value, h[i][j]);
                }
            }
        }
        out
    }
}

/// That of [`Elastic`] less the pressure; keeps the divergences.
pub(super) struct Pressed<S: Simd, const V: usize, R: Packed> {
    pub(super) elastic: Elastic<S, R>,
    /// Weighted, at the points.
    pub(super) pressure: [Pack<S, R>; V],
    pub(super) traces: [Pack<S, R>; V],
}

impl<S: Simd, const V: usize, const D: usize, R: Packed> Law<S, D, R> for Pressed<S, V, R> {
    #[inline(always)]
    fn stress(&mut self, point: usize, h: &Tensor<S, D, R>) -> Tensor<S, D, R> {
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
pub(super) struct Sweep<
    'a,
    S: Simd,
    const V: usize,
    const D: usize,
    const E: usize,
    R: Packed,
    const W: usize,
> {
    pub(super) g: &'a Vectors<S, V, D, R>,
    pub(super) edges: &'a NodeLanes<E, R, W>,
    pub(super) constant: Tensor<S, D, R>,
    /// Stresses of the points so far.
    pub(super) sum: Tensor<S, D, R>,
    /// What they add at edges.
    pub(super) at_edges: Vectors<S, E, D, R>,
    pub(super) part: usize,
}

impl<S: Simd, const V: usize, const D: usize, const E: usize, R: Packed, const W: usize>
    Sweep<'_, S, V, D, E, R, W>
{
    /// Visits point `Q`, a constant so that the loops unroll and the sums stay
    /// in registers.
    #[inline(always)]
    pub(super) fn visit<const Q: usize>(&mut self, simd: S, law: &mut impl Law<S, D, R>) {
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

#[inline(always)]
pub(in crate::assembly) fn traction<S: Simd, const D: usize, R: Packed>(
    simd: S,
    stress: &Tensor<S, D, R>,
    direction: &[Pack<S, R>; D],
) -> [Pack<S, R>; D] {
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
pub(super) fn stress<S: Simd, const D: usize, R: Packed>(
    h: &Tensor<S, D, R>,
    trace: Pack<S, R>,
    shear: Pack<S, R>,
    lame: Pack<S, R>,
) -> Tensor<S, D, R> {
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
pub(super) fn trace<S: Simd, const D: usize, R: Packed>(h: &Tensor<S, D, R>) -> Pack<S, R> {
    let mut sum = h[0][0];
    for i in 1..D {
        sum += h[i][i];
    }
    sum
}
