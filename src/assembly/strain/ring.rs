//! What a body of revolution about the axis x = 0 adds to its plane section: every
//! point is a ring of radius x, stretched by its own displacement along the radius,
//!
//! ```text
//! F_33 = 1 + u_x / x,   int dV = int 2 pi x dA,   f_x(v) += int P_33 v_x / x dV
//! ```
//!
//! x is linear on a straight cell and u_x quadratic; points of the rule lie off the axis. The
//! volume of a cell is that of its full turn, area times 2 pi times the mean radius.
//! Cost: some 40 flops a point.

use pulp::Simd;

use crate::assembly::kernel::part::ElementPart;
use crate::assembly::kernel::{edge_pairs, edge_share};
use crate::assembly::lanes::{Lanes, Pack};
use crate::geometry::tensor::Number;

/// Radii and radial displacements of one part of a batch.
pub(super) struct Ring<S: Simd, const V: usize, const E: usize> {
    radii: [Pack<S>; V],
    /// One over the mean of the radii.
    curvature: Pack<S>,
    vertices: [Pack<S>; V],
    /// Four times the hierarchical values.
    edges: [Pack<S>; E],
}

/// A point of a ring.
pub(super) struct RingPoint<S: Simd> {
    /// Radius over mean radius of the cell.
    pub(super) share: Pack<S>,
    /// One over the radius.
    curvature: Pack<S>,
    /// u_x / x.
    pub(super) hoop: Pack<S>,
}

/// Forces along the radius.
pub(super) struct RingForces<S: Simd, const V: usize, const E: usize> {
    vertices: [Pack<S>; V],
    edges: [Pack<S>; E],
}

/// lambda_a lambda_b of each edge.
#[inline(always)]
fn products<S: Simd, const V: usize, const E: usize>(hats: &[Pack<S>; V]) -> [Pack<S>; E] {
    let mut out = [hats[0]; E];
    for (product, (a, b)) in out.iter_mut().zip(edge_pairs::<E>()) {
        *product = hats[a] * hats[b];
    }
    out
}

impl<S: Simd, const V: usize, const E: usize> Ring<S, V, E> {
    /// `radii` are those of the vertices; none in space and in the plane.
    #[inline(always)]
    pub(super) fn load(radii: &[Lanes], nodes: &ElementPart<'_, S, V, E>) -> Option<Self> {
        if V != 3 || radii.is_empty() {
            return None;
        }
        let (simd, part) = (nodes.simd, nodes.part);
        let zero = Pack::splat(simd, 0.0);
        let mut out = Self {
            radii: [zero; V],
            curvature: zero,
            vertices: [zero; V],
            edges: [zero; E],
        };
        let mut sum = zero;
        for (a, lanes) in radii.iter().enumerate().take(V) {
            out.radii[a] = Pack::load(simd, lanes, part);
            out.vertices[a] = Pack::load(simd, &nodes.vertices[a][0], part);
            sum += out.radii[a];
        }
        let share = Pack::splat(simd, edge_share::<V>());
        for (value, edge) in out.edges.iter_mut().zip(nodes.edges.iter()) {
            *value = Pack::load(simd, &edge[0], part) * share;
        }
        out.curvature = sum.inverse() * V as f64;
        Some(out)
    }

    /// A point; `offsets` of curved edges along the radius, times four.
    #[inline(always)]
    pub(super) fn at(&self, hats: &[Pack<S>; V], offsets: Option<&[Pack<S>; E]>) -> RingPoint<S> {
        let (mut radius, mut moved) = (hats[0] * self.radii[0], hats[0] * self.vertices[0]);
        for a in 1..V {
            radius = radius.plus_product(hats[a], self.radii[a]);
            moved = moved.plus_product(hats[a], self.vertices[a]);
        }
        for (product, value) in products::<S, V, E>(hats).iter().zip(&self.edges) {
            moved = moved.plus_product(*product, *value);
        }
        if let Some(offsets) = offsets {
            for (product, offset) in products::<S, V, E>(hats).iter().zip(offsets) {
                radius = radius.plus_product(*product, *offset);
            }
        }
        let curvature = radius.inverse();
        RingPoint {
            share: radius * self.curvature,
            curvature,
            hoop: moved * curvature,
        }
    }
}

impl<S: Simd, const V: usize, const E: usize> RingForces<S, V, E> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self {
            vertices: [Pack::splat(simd, 0.0); V],
            edges: [Pack::splat(simd, 0.0); E],
        }
    }

    /// Adds the force of `stress` around the axis on `weight` of the body.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        point: &RingPoint<S>,
        hats: &[Pack<S>; V],
        weight: Pack<S>,
        stress: Pack<S>,
    ) {
        let force = stress * weight * point.curvature;
        for (sum, hat) in self.vertices.iter_mut().zip(hats) {
            *sum = sum.plus_product(force, *hat);
        }
        for (sum, product) in self.edges.iter_mut().zip(products::<S, V, E>(hats)) {
            *sum = sum.plus_product(force, product);
        }
    }

    /// Adds to forces in the place of nodal values.
    #[inline(always)]
    pub(super) fn store(self, nodes: &mut ElementPart<'_, S, V, E>) {
        let (simd, part) = (nodes.simd, nodes.part);
        for (force, vertex) in self.vertices.iter().zip(nodes.vertices.iter_mut()) {
            (Pack::load(simd, &vertex[0], part) + *force).store(&mut vertex[0], part);
        }
        let share = Pack::splat(simd, edge_share::<V>());
        for (force, edge) in self.edges.iter().zip(nodes.edges.iter_mut()) {
            (Pack::load(simd, &edge[0], part) + *force * share).store(&mut edge[0], part);
        }
    }
}
