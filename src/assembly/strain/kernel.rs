//! One batch of elements between its nodal values and its points; equations in
//! [`super`].

use pulp::Simd;

use super::ring::{Ring, RingForces};
use crate::assembly::kernel::points::{Tensor as Square, Vectors, gradients, traction, zeros};
use crate::assembly::kernel::{
    Batch, Element, NodeLanes, PRESSURE, edge_pairs, edge_share, gather, scatter,
};
use crate::assembly::lanes::{Batched, Lanes, Pack};
use crate::assembly::transpose::{Row, Transpose};
use crate::element::quadrature::Rule;
use crate::geometry::tensor::Tensor;

/// grad u at the vertices.
pub(super) type VertexGradients<S, const V: usize, const D: usize> = [Square<S, D>; V];

/// What happens at a point: a stress follows from a displacement gradient.
pub(super) trait PointLaw<S: Simd, const V: usize> {
    /// `hats` are the barycentric coordinates, `weight` times volume the measure.
    fn stress(
        &mut self,
        point: usize,
        hats: &[Pack<S>; V],
        weight: Pack<S>,
        gradient: &Tensor<Pack<S>>,
    ) -> Tensor<Pack<S>>;
}

/// A plane tensor in space.
#[inline(always)]
pub(super) fn in_space<S: Simd, const D: usize>(simd: S, plane: &Square<S, D>) -> Tensor<Pack<S>> {
    let mut out = [[Pack::splat(simd, 0.0); 3]; 3];
    for i in 0..D {
        for j in 0..D {
            out[i][j] = plane[i][j];
        }
    }
    out
}

/// Gradients at the vertices of one part of a batch.
#[inline(always)]
pub(super) fn vertex_gradients<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    g: &Vectors<S, V, D>,
    (vertices, edges): (&NodeLanes<V>, &NodeLanes<E>),
    part: usize,
) -> VertexGradients<S, V, D> {
    let mut constant = zeros::<S, D, D, f64>(simd);
    for a in 0..V {
        for i in 0..D {
            let value = Pack::load(simd, &vertices[a][i], part);
            for j in 0..D {
                constant[i][j] = constant[i][j].plus_product(value, g[a][j]);
            }
        }
    }
    let share = Pack::splat(simd, edge_share::<V>());
    let mut out = [constant; V];
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        for i in 0..D {
            let c = Pack::load(simd, &edges[e][i], part) * share;
            for j in 0..D {
                out[a][i][j] = out[a][i][j].plus_product(c, g[b][j]);
                out[b][i][j] = out[b][i][j].plus_product(c, g[a][j]);
            }
        }
    }
    out
}

/// Forces from the moments of the stress, in the place of nodal values.
#[inline(always)]
pub(super) fn store_moments<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    g: &Vectors<S, V, D>,
    moments: &VertexGradients<S, V, D>,
    (vertices, edges): (&mut NodeLanes<V>, &mut NodeLanes<E>),
    part: usize,
) {
    let mut sum = moments[0];
    for moment in &moments[1..] {
        for i in 0..D {
            for j in 0..D {
                sum[i][j] += moment[i][j];
            }
        }
    }
    for a in 0..V {
        let force = traction(simd, &sum, &g[a]);
        for i in 0..D {
            force[i].store(&mut vertices[a][i], part);
        }
    }
    let share = Pack::splat(simd, edge_share::<V>());
    for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
        let (at_a, at_b) = (
            traction(simd, &moments[a], &g[b]),
            traction(simd, &moments[b], &g[a]),
        );
        for i in 0..D {
            ((at_a[i] + at_b[i]) * share).store(&mut edges[e][i], part);
        }
    }
}

/// sum_j lambda_j G_j.
#[inline(always)]
pub(super) fn at_point<S: Simd, const V: usize, const D: usize>(
    simd: S,
    hats: &[Pack<S>; V],
    vertex: &VertexGradients<S, V, D>,
) -> Tensor<Pack<S>> {
    let mut out = zeros::<S, D, D, f64>(simd);
    for (hat, gradient) in hats.iter().zip(vertex) {
        for i in 0..D {
            for j in 0..D {
                out[i][j] = out[i][j].plus_product(*hat, gradient[i][j]);
            }
        }
    }
    in_space(simd, &out)
}

/// Barycentric coordinates of a point.
#[inline(always)]
pub(super) fn hats<S: Simd, const V: usize>(simd: S, point: &[f64; 4]) -> [Pack<S>; V] {
    let mut out = [Pack::splat(simd, 0.0); V];
    for (hat, value) in out.iter_mut().zip(point) {
        *hat = Pack::splat(simd, *value);
    }
    out
}

/// Moments of the stresses that `law` gives where the gradients are `vertex`, and
/// the forces of those around an axis.
#[inline(always)]
pub(super) fn moments<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    rule: &Rule,
    volume: Pack<S>,
    vertex: &VertexGradients<S, V, D>,
    ring: Option<&Ring<S, V, E>>,
    law: &mut impl PointLaw<S, V>,
) -> (VertexGradients<S, V, D>, RingForces<S, V, E>) {
    let mut out = [zeros::<S, D, D, f64>(simd); V];
    let mut forces = RingForces::zero(simd);
    for (index, (point, weight)) in rule.points.iter().zip(&rule.weights).enumerate() {
        let hats = hats::<S, V>(simd, point);
        let mut weight = volume * *weight;
        let mut gradient = at_point(simd, &hats, vertex);
        let around = ring.map(|ring| ring.at(&hats));
        if let Some(around) = &around {
            weight = weight * around.share;
            gradient[2][2] = around.hoop;
        }
        let stress = law.stress(index, &hats, weight, &gradient);
        if let Some(around) = &around {
            forces.add(around, &hats, weight, stress[2][2]);
        }
        for (hat, moment) in hats.iter().zip(&mut out) {
            let factor = *hat * weight;
            for i in 0..D {
                for j in 0..D {
                    moment[i][j] = moment[i][j].plus_product(factor, stress[i][j]);
                }
            }
        }
    }
    (out, forces)
}

/// What all batches of a block take.
pub(super) struct BatchRun<'a, S, T> {
    /// Instructions.
    pub(super) simd: S,
    /// How rows become lanes.
    pub(super) transpose: T,
    /// Points.
    pub(super) rule: &'a Rule,
    /// Nodal values of the block.
    pub(super) x: &'a [Row],
    /// Forces of the block.
    pub(super) y: &'a mut [Row],
}

impl<S: Simd, T: Transpose> BatchRun<'_, S, T> {
    /// One batch: nodal values in, forces of the law's stresses out; `begin` makes
    /// the law of each part from the gathered values, `end` takes it back.
    #[inline(always)]
    pub(super) fn run<L, const V: usize, const D: usize, const E: usize>(
        self,
        (batch, radii): (&Batch<V, D, E>, &[Lanes]),
        element: &mut Element<V, E>,
        mut begin: impl FnMut(usize, &VertexGradients<S, V, D>, &NodeLanes<V>) -> L,
        mut end: impl FnMut(usize, L, &mut NodeLanes<V>),
    ) where
        L: PointLaw<S, V>,
    {
        let Self {
            simd,
            transpose,
            rule,
            x,
            y,
        } = self;
        gather(transpose, &batch.vertices, x, &mut element.vertices);
        gather(transpose, &batch.edges, x, &mut element.edges);
        forces((simd, rule), (batch, radii), element, &mut begin, &mut end);
        scatter(transpose, &batch.vertices, &element.vertices, y);
        scatter(transpose, &batch.edges, &element.edges, y);
    }
}

/// Nodal values of one batch in, forces of the law's stresses in their place; `begin` and
/// `end` as in [`BatchRun::run`].
#[inline(always)]
pub(super) fn forces<S: Simd, L, const V: usize, const D: usize, const E: usize>(
    (simd, rule): (S, &Rule),
    (batch, radii): (&Batch<V, D, E>, &[Lanes]),
    element: &mut Element<V, E>,
    begin: &mut impl FnMut(usize, &VertexGradients<S, V, D>, &NodeLanes<V>) -> L,
    end: &mut impl FnMut(usize, L, &mut NodeLanes<V>),
) where
    L: PointLaw<S, V>,
{
    let Element { vertices, edges } = element;
    for part in 0..f64::parts::<S>() {
        let g = gradients(simd, batch, part);
        let vertex = vertex_gradients(simd, &g, (&*vertices, &*edges), part);
        let mut law = begin(part, &vertex, vertices);
        let volume = Pack::load(simd, &batch.weight, part) * V as f64;
        let ring = Ring::load(simd, radii, (&*vertices, &*edges), part);
        let (moments, forces) = moments(simd, rule, volume, &vertex, ring.as_ref(), &mut law);
        store_moments(simd, &g, &moments, (&mut *vertices, &mut *edges), part);
        if ring.is_some() {
            forces.store(simd, (&mut *vertices, &mut *edges), part);
        }
        end(part, law, vertices);
    }
}

/// Pressures at the vertices of one part.
#[inline(always)]
pub(super) fn vertex_pressures<S: Simd, const V: usize>(
    simd: S,
    vertices: &NodeLanes<V>,
    part: usize,
) -> [Pack<S>; V] {
    let mut out = [Pack::splat(simd, 0.0); V];
    for (value, vertex) in out.iter_mut().zip(vertices) {
        *value = Pack::load(simd, &vertex[PRESSURE], part);
    }
    out
}

/// Writes volume moments in the place of the pressure.
#[inline(always)]
pub(super) fn store_volumes<S: Simd, const V: usize>(
    volumes: &[Pack<S>; V],
    vertices: &mut NodeLanes<V>,
    part: usize,
) {
    for (value, vertex) in volumes.iter().zip(vertices) {
        (-*value).store(&mut vertex[PRESSURE], part);
    }
}
