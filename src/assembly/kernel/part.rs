//! Nodal values of a batch, a register each, and what they become at the points of the rule and
//! back; the equations stand in [`super`].

use pulp::Simd;

use super::points::{Law, Sweep, Vectors, edge_of, traction, zeros};
use super::{NodeLanes, PRESSURE, edge_pairs, rule};
use crate::assembly::lanes::{Pack, Packed, WIDTH};

/// Nodal values of a batch in one part of its lanes, a register each.
pub(in crate::assembly) struct ElementPart<
    'a,
    S,
    const V: usize,
    const E: usize,
    R = f64,
    const W: usize = WIDTH,
> {
    pub(in crate::assembly) simd: S,
    pub(in crate::assembly) part: usize,
    pub(in crate::assembly) vertices: &'a mut NodeLanes<V, R, W>,
    pub(in crate::assembly) edges: &'a mut NodeLanes<E, R, W>,
}

impl<S: Simd, const V: usize, const E: usize, R: Packed, const W: usize>
    ElementPart<'_, S, V, E, R, W>
{
    /// u_a + 4 beta sum_j c_aj.
    #[inline(always)]
    pub(super) fn bases<const D: usize>(&self) -> Vectors<S, V, D, R> {
        let (simd, part) = (self.simd, self.part);
        let (alpha, beta) = rule(V);
        let shared = Pack::splat(simd, beta / (alpha - beta));
        let mut sums = zeros::<S, V, D, R>(simd);
        for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
            for i in 0..D {
                let c = Pack::load(simd, &self.edges[e][i], part);
                sums[a][i] += c;
                sums[b][i] += c;
            }
        }
        for a in 0..V {
            for i in 0..D {
                let vertex = Pack::load(simd, &self.vertices[a][i], part);
                sums[a][i] = vertex.plus_product(sums[a][i], shared);
            }
        }
        sums
    }

    /// Visits the points: nodal forces of the stress that `law` gives replace the values.
    #[inline(always)]
    pub(super) fn visit_points<const D: usize>(
        &mut self,
        g: &Vectors<S, V, D, R>,
        law: &mut impl Law<S, D, R>,
    ) {
        let simd = self.simd;
        let base = self.bases::<D>();
        let mut constant = zeros::<S, D, D, R>(simd);
        for a in 0..V {
            for i in 0..D {
                for j in 0..D {
                    constant[i][j] = constant[i][j].plus_product(base[a][i], g[a][j]);
                }
            }
        }
        let mut sweep = Sweep {
            g,
            edges: &*self.edges,
            constant,
            sum: zeros::<S, D, D, R>(simd),
            at_edges: zeros::<S, E, D, R>(simd),
            part: self.part,
        };
        sweep.visit::<0>(simd, law);
        sweep.visit::<1>(simd, law);
        sweep.visit::<2>(simd, law);
        if V > 3 {
            sweep.visit::<3>(simd, law);
        }
        let (sum, at_edges) = (sweep.sum, sweep.at_edges);
        let mut totals = zeros::<S, V, D, R>(simd);
        for a in 0..V {
            totals[a] = traction(simd, &sum, &g[a]);
        }
        self.store_forces(&totals, &at_edges);
    }

    /// Forces of vertices and edges from the sum over the points at vertices and
    /// what the points add at edges.
    #[inline(always)]
    pub(super) fn store_forces<const D: usize>(
        &mut self,
        totals: &Vectors<S, V, D, R>,
        at_edges: &Vectors<S, E, D, R>,
    ) {
        let (alpha, beta) = rule(V);
        let shared = Pack::splat(self.simd, beta / (alpha - beta));
        for a in 0..V {
            for i in 0..D {
                totals[a][i].store(&mut self.vertices[a][i], self.part);
            }
        }
        for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
            for i in 0..D {
                let both = totals[a][i] + totals[b][i];
                let force = at_edges[e][i].plus_product(both, shared);
                force.store(&mut self.edges[e][i], self.part);
            }
        }
    }

    /// Divergences at the points.
    #[inline(always)]
    pub(super) fn divergences<const D: usize>(&self, g: &Vectors<S, V, D, R>) -> [Pack<S, R>; V] {
        let base = self.bases::<D>();
        let mut constant = Pack::splat(self.simd, 0.0);
        for a in 0..V {
            for i in 0..D {
                constant = constant.plus_product(base[a][i], g[a][i]);
            }
        }
        let mut traces = [constant; V];
        for (q, trace) in traces.iter_mut().enumerate() {
            for a in (0..V).filter(|&a| a != q) {
                let edge = &self.edges[edge_of::<V>(a, q)];
                for i in 0..D {
                    let c = Pack::load(self.simd, &edge[i], self.part);
                    *trace = trace.plus_product(c, g[a][i]);
                }
            }
        }
        traces
    }

    /// Forces of the pressures, in the place of nodal values.
    #[inline(always)]
    pub(super) fn store_pressure_forces<const D: usize>(
        &mut self,
        g: &Vectors<S, V, D, R>,
        weight: Pack<S, R>,
    ) {
        let pressure = self.pressures(-weight);
        let mut sum = Pack::splat(self.simd, 0.0);
        for &value in &pressure {
            sum += value;
        }
        let mut totals = *g;
        for total in totals.as_flattened_mut() {
            *total = *total * sum;
        }
        let mut at_edges = zeros::<S, E, D, R>(self.simd);
        for (force, (a, b)) in at_edges.iter_mut().zip(edge_pairs::<E>()) {
            for i in 0..D {
                force[i] = (pressure[b] * g[a][i]).plus_product(pressure[a], g[b][i]);
            }
        }
        self.store_forces(&totals, &at_edges);
    }

    /// -int lambda_a div u from the divergences at the points, in the place of the pressure.
    #[inline(always)]
    pub(super) fn store_volumes(&mut self, traces: &[Pack<S, R>; V], weight: Pack<S, R>) {
        let (alpha, beta) = rule(V);
        let mut sum = Pack::splat(self.simd, 0.0);
        for &trace in traces {
            sum += trace;
        }
        let shared = sum * (-beta) * weight;
        let own = weight * (beta - alpha);
        for a in 0..V {
            let value = shared.plus_product(traces[a], own);
            value.store(&mut self.vertices[a][PRESSURE], self.part);
        }
    }

    /// Weighted pressures at the points.
    #[inline(always)]
    pub(super) fn pressures(&self, weight: Pack<S, R>) -> [Pack<S, R>; V] {
        let (alpha, beta) = rule(V);
        let mut values = [Pack::splat(self.simd, 0.0); V];
        let mut sum = Pack::splat(self.simd, 0.0);
        for a in 0..V {
            values[a] = Pack::load(self.simd, &self.vertices[a][PRESSURE], self.part);
            sum += values[a];
        }
        let shared = sum * beta * weight;
        let own = weight * (alpha - beta);
        for value in &mut values {
            *value = shared.plus_product(*value, own);
        }
        values
    }
}
