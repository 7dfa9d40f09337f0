//! One batch of elements between its nodal values and its points; equations in
//! [`super`], of cells with curved edges in [`super::bend`].

use pulp::Simd;

use super::bend::{Bend, BendAt, Curve};
use super::points::{VertexGradients, at_point, hats};
use super::ring::{Ring, RingForces};
use crate::assembly::kernel::part::ElementPart;
use crate::assembly::kernel::points::{Vectors, traction, zeros};
use crate::assembly::kernel::{
    Batch, Element, NodeLanes, PRESSURE, edge_pairs, edge_share, gather, scatter,
};
use crate::assembly::lanes::{Lanes, Pack};
use crate::assembly::transpose::{Batched, Row, Transpose};
use crate::element::quadrature::Rule;
use crate::geometry::tensor::{Tensor, product};

/// A point of a batch.
pub(super) struct Site<'a, S: Simd, const V: usize> {
    /// Its number in the rule.
    pub(super) index: usize,
    /// Its measure.
    pub(super) weight: Pack<S>,
    /// Barycentric coordinates.
    pub(super) hats: &'a [Pack<S>; V],
    /// F0 of curved cells.
    bend: Option<&'a BendAt<S>>,
}

impl<S: Simd, const V: usize> Site<'_, S, V> {
    /// A gradient on the straight cells as one on the curved ones.
    #[inline(always)]
    pub(super) fn on_curved(&self, straight: Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        match self.bend {
            Some(bend) => product(&straight, &bend.inverse),
            None => straight,
        }
    }
}

/// What happens at a point: a stress follows from a displacement gradient.
pub(super) trait PointLaw<S: Simd, const V: usize> {
    /// The stress at a point.
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>>;
}

impl<S: Simd, const V: usize, const E: usize> ElementPart<'_, S, V, E> {
    /// Gradients at the vertices.
    #[inline(always)]
    fn vertex_gradients<const D: usize>(&self, g: &Vectors<S, V, D>) -> VertexGradients<S, V, D> {
        let (simd, part) = (self.simd, self.part);
        let mut constant = zeros::<S, D, D, f64>(simd);
        for i in 0..D {
            let first = Pack::load(simd, &self.vertices[0][i], part);
            for a in 1..V {
                let apart = Pack::load(simd, &self.vertices[a][i], part) - first;
                for j in 0..D {
                    constant[i][j] = constant[i][j].plus_product(apart, g[a][j]);
                }
            }
        }
        let share = Pack::splat(simd, edge_share::<V>());
        let mut out = [constant; V];
        for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
            for i in 0..D {
                let c = Pack::load(simd, &self.edges[e][i], part) * share;
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
    fn store_moments<const D: usize>(
        &mut self,
        g: &Vectors<S, V, D>,
        moments: &VertexGradients<S, V, D>,
    ) {
        let (simd, part) = (self.simd, self.part);
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
                force[i].store(&mut self.vertices[a][i], part);
            }
        }
        let share = Pack::splat(simd, edge_share::<V>());
        for (e, (a, b)) in edge_pairs::<E>().into_iter().enumerate() {
            let at_a = traction(simd, &moments[a], &g[b]);
            let at_b = traction(simd, &moments[b], &g[a]);
            for i in 0..D {
                ((at_a[i] + at_b[i]) * share).store(&mut self.edges[e][i], part);
            }
        }
    }
}

/// Cells of one part of a batch.
pub(super) struct Cells<S: Simd, const V: usize, const D: usize, const E: usize> {
    volume: Pack<S>,
    /// grad u at the vertices.
    vertex: VertexGradients<S, V, D>,
    /// About an axis.
    ring: Option<Ring<S, V, E>>,
    /// Curved edges.
    bend: Option<Bend<S, V, D, E>>,
}

/// Moments of the stresses that `law` gives in `cells`, and the forces of those around an axis.
#[inline(always)]
pub(super) fn moments<S: Simd, const V: usize, const D: usize, const E: usize>(
    simd: S,
    rule: &Rule,
    cells: &Cells<S, V, D, E>,
    law: &mut impl PointLaw<S, V>,
) -> (VertexGradients<S, V, D>, RingForces<S, V, E>) {
    let mut out = [zeros::<S, D, D, f64>(simd); V];
    let mut forces = RingForces::zero(simd);
    for (index, (point, weight)) in rule.points.iter().zip(&rule.weights).enumerate() {
        let hats = hats::<S, V>(simd, point);
        let bend = cells.bend.as_ref().map(|bend| bend.at(simd, &hats));
        let mut site = Site {
            index,
            weight: cells.volume * *weight,
            hats: &hats,
            bend: bend.as_ref(),
        };
        if let Some(bend) = &bend {
            site.weight = site.weight * bend.measure;
        }
        let mut gradient = site.on_curved(at_point(simd, &hats, &cells.vertex));
        let around = cells
            .ring
            .as_ref()
            .map(|ring| ring.at(&hats, cells.bend.as_ref().map(|bend| &bend.radii)));
        if let Some(around) = &around {
            site.weight = site.weight * around.share;
            gradient[2][2] = around.hoop;
        }
        let mut stress = law.stress(&site, &gradient);
        if let Some(around) = &around {
            forces.add(around, &hats, site.weight, stress[2][2]);
        }
        if let Some(bend) = &bend {
            stress = bend.pulled::<D>(&stress);
        }
        for (hat, moment) in hats.iter().zip(&mut out) {
            let factor = *hat * site.weight;
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
        batch: BatchCells<'_, V, D, E>,
        element: &mut Element<V, E>,
        mut begin: impl FnMut(usize, &VertexGradients<S, V, D>, &NodeLanes<V>) -> L,
        mut end: impl FnMut(usize, L, &mut NodeLanes<V>),
    ) where
        L: PointLaw<S, V>,
    {
        let Self {
            simd,
            transpose,
            x,
            y,
        } = self;
        let nodes = batch.batch;
        gather(transpose, &nodes.vertices, x, &mut element.vertices);
        gather(transpose, &nodes.edges, x, &mut element.edges);
        forces(simd, batch, element, &mut begin, &mut end);
        scatter(transpose, &nodes.vertices, &element.vertices, y);
        scatter(transpose, &nodes.edges, &element.edges, y);
    }
}

/// A batch with what its cells have beside it.
#[derive(Clone, Copy)]
pub(super) struct BatchCells<'a, const V: usize, const D: usize, const E: usize> {
    pub(super) batch: &'a Batch<V, D, E>,
    /// Points.
    pub(super) rule: &'a Rule,
    /// Radii of the vertices about an axis, or empty.
    pub(super) radii: &'a [Lanes],
    /// Curved edges; none where all are lines.
    pub(super) curve: Option<&'a Curve<V, D, E>>,
}

/// Nodal values of one batch in, forces of the law's stresses in their place; `begin` and
/// `end` as in [`BatchRun::run`].
#[inline(always)]
pub(super) fn forces<S: Simd, L, const V: usize, const D: usize, const E: usize>(
    simd: S,
    cells: BatchCells<'_, V, D, E>,
    element: &mut Element<V, E>,
    begin: &mut impl FnMut(usize, &VertexGradients<S, V, D>, &NodeLanes<V>) -> L,
    end: &mut impl FnMut(usize, L, &mut NodeLanes<V>),
) where
    L: PointLaw<S, V>,
{
    for part in 0..f64::parts::<S>() {
        let g = cells.batch.gradients_at(simd, part);
        let mut nodes = ElementPart {
            simd,
            part,
            vertices: &mut element.vertices,
            edges: &mut element.edges,
        };
        let here = Cells {
            volume: Pack::load(simd, &cells.batch.weight, part) * V as f64,
            vertex: nodes.vertex_gradients(&g),
            ring: Ring::load(cells.radii, &nodes),
            bend: cells.curve.map(|curve| curve.load(simd, part)),
        };
        let mut law = begin(part, &here.vertex, nodes.vertices);
        let (moments, forces) = moments(simd, cells.rule, &here, &mut law);
        nodes.store_moments(&g, &moments);
        if here.ring.is_some() {
            forces.store(&mut nodes);
        }
        end(part, law, nodes.vertices);
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
