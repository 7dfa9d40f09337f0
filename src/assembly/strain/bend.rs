//! What curved edges make of the points of a batch ([`crate::element::curved_cell`]):
//!
//! ```text
//! F0 = I + sum_j l_j O_j,   grad u -> grad u F0^-1,   dV -> det F0 dV,   P -> P F0^-T
//! ```
//!
//! About an axis the offsets move the radius, too. Cost: some 100 flops a point; nothing in a batch of
//! straight cells.

use pulp::Simd;

use super::points::{VertexGradients, at_point};
use crate::assembly::lanes::{Lanes, Pack, WIDTH};
use crate::element::curved_cell::CurvedCell;
use crate::geometry::tensor::{Number, Tensor, cofactor, contract, plus_unit, scaled, transposed};

/// Offsets of the edges of a batch; zero in straight cells.
#[derive(Clone, Debug)]
pub(in crate::assembly) struct Curve<const V: usize, const D: usize, const E: usize> {
    /// Gradients of the offsets at the vertices.
    slopes: [[[Lanes; D]; D]; V],
    /// Four times the offsets along the radius.
    radii: [Lanes; E],
}

impl<const V: usize, const D: usize, const E: usize> Curve<V, D, E> {
    /// Of the cells in the lanes, straight ones being none.
    pub(in crate::assembly) fn new(cells: [Option<&CurvedCell>; WIDTH]) -> Self {
        let lanes = |of: &dyn Fn(&CurvedCell) -> f64| Lanes(cells.map(|cell| cell.map_or(0.0, of)));
        Self {
            slopes: std::array::from_fn(|a| {
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| lanes(&|cell| cell.slopes[a][i][j]))
                })
            }),
            radii: std::array::from_fn(|e| lanes(&|cell| 4.0 * cell.offsets[e][0])),
        }
    }

    /// One part of the lanes.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, part: usize) -> Bend<S, V, D, E> {
        let zero = Pack::splat(simd, 0.0);
        let mut out = Bend {
            slopes: [[[zero; D]; D]; V],
            radii: [zero; E],
        };
        for (slopes, lanes) in out.slopes.iter_mut().zip(&self.slopes) {
            for i in 0..D {
                for j in 0..D {
                    slopes[i][j] = Pack::load(simd, &lanes[i][j], part);
                }
            }
        }
        for (radius, lanes) in out.radii.iter_mut().zip(&self.radii) {
            *radius = Pack::load(simd, lanes, part);
        }
        out
    }
}

/// One part of a curved batch.
pub(super) struct Bend<S: Simd, const V: usize, const D: usize, const E: usize> {
    slopes: VertexGradients<S, V, D>,
    /// Four times the offsets along the radius.
    pub(super) radii: [Pack<S>; E],
}

/// F0 at a point.
pub(super) struct BendAt<S: Simd> {
    pub(super) inverse: Tensor<Pack<S>>,
    pub(super) measure: Pack<S>,
}

impl<S: Simd, const V: usize, const D: usize, const E: usize> Bend<S, V, D, E> {
    #[inline(always)]
    pub(super) fn at(&self, simd: S, hats: &[Pack<S>; V]) -> BendAt<S> {
        let base = plus_unit(&at_point(simd, hats, &self.slopes));
        let turned = cofactor(&base);
        let measure = contract(&base, &turned) * (1.0 / 3.0);
        BendAt {
            inverse: scaled(measure.inverse(), &transposed(&turned)),
            measure,
        }
    }
}

impl<S: Simd> BendAt<S> {
    /// P F0^-T.
    #[inline(always)]
    pub(super) fn pulled<const D: usize>(&self, stress: &Tensor<Pack<S>>) -> Tensor<Pack<S>> {
        let mut out = *stress;
        for i in 0..D {
            for j in 0..D {
                out[i][j] = stress[i][0] * self.inverse[j][0];
                for k in 1..D {
                    out[i][j] = out[i][j].plus_product(stress[i][k], self.inverse[j][k]);
                }
            }
        }
        out
    }
}
