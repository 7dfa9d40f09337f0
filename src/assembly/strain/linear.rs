//! Cells of linear elasticity with curved edges and those about an axis, point by point:
//!
//! ```text
//! A u + B^T p = int (2 mu eps + lambda div u I - p I) : grad v,   B u = -int q div u
//! ```
//!
//! with eps_33 = u_x / x about the axis x = 0 ([`super::ring`]). By the rule of degree 4, by which an
//! even pressure has no force inside a curved body: cof F0 : grad u is cubic at most; about an axis
//! strain times radius is, too, but for the strain around it, which is no polynomial. Cost: 14
//! points a tetrahedron instead of 4, on the curved cells alone.

use std::sync::LazyLock;

use pulp::Simd;

use super::bend::Curve;
use super::kernel::{BatchCells, BatchRun, PointLaw, Site, store_volumes, vertex_pressures};
use super::laws::{add_moments, interpolate};
use crate::assembly::kernel::{Batch, Element};
use crate::assembly::lanes::{Lanes, Pack};
use crate::assembly::simd::{BatchPass, InstructionSet};
use crate::assembly::transpose::{Row, Transpose};
use crate::element::quadrature::{Rule, Simplex, rule};
use crate::geometry::tensor::{Number, Tensor, trace};

/// Degree of the rule: that of `lambda_j div u` times the measure of a curved cell, in space.
pub const CURVED_DEGREE: u32 = 4;

static RULES: LazyLock<[Rule; 2]> = LazyLock::new(|| {
    [Simplex::Triangle, Simplex::Tetrahedron].map(|cell| rule(cell, CURVED_DEGREE))
});

/// Which products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::assembly) enum Terms {
    /// `(A u + B^T p, B u)`.
    Saddle,
    /// `B^T p`; displacements of the argument are not read.
    Pressure,
}

/// Batches of a block that go by points, argument and result.
pub(in crate::assembly) struct PointPass<'a, const V: usize, const D: usize, const E: usize> {
    /// Batches of straight cells.
    pub(in crate::assembly) batches: &'a [Batch<V, D, E>],
    /// Curved edges of the last of them.
    pub(in crate::assembly) curves: &'a [Curve<V, D, E>],
    /// Radii of their vertices, batch by batch, or empty.
    pub(in crate::assembly) radii: &'a [Lanes],
    /// Nodal values of the block.
    pub(in crate::assembly) x: &'a [Row],
    /// Forces and volumes of the block, which are added to.
    pub(in crate::assembly) y: &'a mut [Row],
}

impl<const V: usize, const D: usize, const E: usize> PointPass<'_, V, D, E> {
    /// Adds the products to the result.
    pub(in crate::assembly) fn run(self, set: InstructionSet, terms: Terms) {
        if !self.batches.is_empty() {
            set.run(Products(self, terms));
        }
    }
}

struct Products<'a, const V: usize, const D: usize, const E: usize>(PointPass<'a, V, D, E>, Terms);

impl<const V: usize, const D: usize, const E: usize> BatchPass for Products<'_, V, D, E> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd, T: Transpose>(self, simd: S, transpose: T) {
        let Self(
            PointPass {
                batches,
                curves,
                radii,
                x,
                y,
            },
            terms,
        ) = self;
        let mut element = Element::zero();
        let zero = Pack::splat(simd, 0.0);
        let straight = batches.len() - curves.len();
        for (index, batch) in batches.iter().enumerate() {
            let cells = BatchCells {
                batch,
                rule: &RULES[D - 2],
                radii: radii.get(V * index..V * (index + 1)).unwrap_or_default(),
                curve: index.checked_sub(straight).map(|place| &curves[place]),
            };
            BatchRun {
                simd,
                transpose,
                x,
                y: &mut *y,
            }
            .run(
                cells,
                &mut element,
                |part, _, vertices| {
                    let weight = Pack::load(simd, &batch.weight, part);
                    // The moduli of a batch hold the weight, that of missing cells zero.
                    let share =
                        weight.each(|weight| if weight > 0.0 { weight.recip() } else { 0.0 });
                    Hooke {
                        terms,
                        shear: Pack::load(simd, &batch.shear, part) * share,
                        lame: Pack::load(simd, &batch.lame, part) * share,
                        pressures: vertex_pressures(simd, vertices, part),
                        volumes: [zero; V],
                    }
                },
                |part, done, vertices| store_volumes(&done.volumes, vertices, part),
            );
        }
    }
}

/// 2 mu eps + lambda div I - p I, and div u.
struct Hooke<S: Simd, const V: usize> {
    terms: Terms,
    shear: Pack<S>,
    lame: Pack<S>,
    pressures: [Pack<S>; V],
    /// int lambda_j div u.
    volumes: [Pack<S>; V],
}

impl<S: Simd, const V: usize> PointLaw<S, V> for Hooke<S, V> {
    #[inline(always)]
    fn stress(&mut self, site: &Site<'_, S, V>, gradient: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let mut stress = *gradient;
        let mut volume = -interpolate(site.hats, &self.pressures);
        if self.terms == Terms::Saddle {
            let dilation = trace(gradient);
            add_moments(&mut self.volumes, site.hats, site.weight * dilation);
            volume = volume.plus_product(self.lame, dilation);
        }
        for i in 0..3 {
            for j in 0..3 {
                stress[i][j] = match self.terms {
                    Terms::Saddle => (gradient[i][j] + gradient[j][i]) * self.shear,
                    Terms::Pressure => volume.constant(0.0),
                };
            }
            stress[i][i] += volume;
        }
        stress
    }
}
