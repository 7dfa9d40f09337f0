//! Laws that are taken point by point, one lane after the other: eigenvalues and logarithms are
//! not a matter of registers. Products take the tangent that the state left, 45 products and sums
//! a point in registers again.

use std::sync::Arc;

use pulp::Simd;

use crate::assembly::lanes::{Lanes, Pack};
use crate::geometry::tensor::{Tensor, volume_change};
use crate::material::Isochoric;

/// A law taken point by point; none in lanes of a law that registers take.
pub(super) type LaneLaw = Option<Arc<Isochoric>>;

/// Numbers of a symmetric tangent matrix; those of a point lie together.
pub(super) const TANGENT: usize = 45;

/// The displacement gradients of all lanes, one after the other, that are the
/// right side out and have a law taken point by point.
#[inline(always)]
fn each_lane<S: Simd>(
    laws: &[LaneLaw],
    gradient: &Tensor<Pack<S>>,
    mut visit: impl FnMut(usize, &Isochoric, &Tensor<f64>),
) {
    let mut lanes = [[<Lanes>::zero(); 3]; 3];
    for (row, packs) in lanes.iter_mut().zip(gradient) {
        let pairs = row.iter_mut().zip(packs);
        pairs.for_each(|(lanes, pack)| pack.store(lanes, 0));
    }
    for (lane, law) in laws.iter().enumerate() {
        let h: Tensor<f64> = lanes.map(|row| row.map(|lanes| lanes.0[lane]));
        if let Some(law) = law
            && volume_change(&h) > -1.0
        {
            visit(lane, law, &h);
        }
    }
}

/// Adds dW/dF to `stress`; W.
#[inline(always)]
pub(super) fn add_response<S: Simd>(
    laws: &[LaneLaw],
    gradient: &Tensor<Pack<S>>,
    stress: &mut Tensor<Pack<S>>,
) -> Pack<S> {
    let mut energies = <Lanes>::zero();
    let mut stresses = [[<Lanes>::zero(); 3]; 3];
    each_lane(laws, gradient, |lane, law, h| {
        energies.0[lane] = law.energy(h);
        let found = law.stress(h);
        for (row, values) in stresses.iter_mut().zip(found) {
            (0..3).for_each(|j| row[j].0[lane] = values[j]);
        }
    });
    for (row, lanes) in stress.iter_mut().zip(&stresses) {
        for (sum, lanes) in row.iter_mut().zip(lanes) {
            *sum += sum.first_of(lanes);
        }
    }
    gradient[0][0].first_of(&energies)
}

/// Writes d2W/dF2 at a point to the front of `tangents`, row by row from the diagonal
/// on.
#[inline(always)]
pub(super) fn store_tangent<S: Simd>(
    laws: &[LaneLaw],
    gradient: &Tensor<Pack<S>>,
    tangents: &mut [Lanes],
    part: usize,
) {
    let mut entries = [<Lanes>::zero(); TANGENT];
    each_lane(laws, gradient, |lane, law, h| {
        let tangent = law.tangent(h);
        let upper = tangent.iter().enumerate().flat_map(|(i, row)| &row[i..]);
        for (entry, value) in entries.iter_mut().zip(upper) {
            entry.0[lane] = *value;
        }
    });
    let like = gradient[0][0];
    for (lanes, entry) in tangents.iter_mut().zip(&entries) {
        like.first_of(entry).store(lanes, part);
    }
}

/// Adds d2W/dF2 : `change` to `stress`; `tangents` begin with those of the point.
#[inline(always)]
pub(super) fn add_tangent<S: Simd>(
    (simd, part): (S, usize),
    tangents: &[Lanes],
    change: &Tensor<Pack<S>>,
    stress: &mut Tensor<Pack<S>>,
) {
    let mut entries = tangents.iter();
    for row in 0..9 {
        let (i, j) = (row / 3, row % 3);
        for (column, lanes) in (row..9).zip(&mut entries) {
            let (k, l) = (column / 3, column % 3);
            let entry = Pack::load(simd, lanes, part);
            stress[i][j] = stress[i][j].plus_product(entry, change[k][l]);
            if column > row {
                stress[k][l] = stress[k][l].plus_product(entry, change[i][j]);
            }
        }
    }
}
