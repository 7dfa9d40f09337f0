//! Where a surface goes on to beyond its rims.
//!
//! From a corner of a rim it goes on straight across, by a share of how high its faces are there; at the
//! corner of two rims as far from both. That place is found at rest and moves with a face on from there,
//!
//! ```text
//! far = sum over the corners of a face of share_k x_k,   sum share_k = 1
//! ```
//!
//! so that it is linear in the places of three nodes. Cost: one pass over the rims.

use super::outline::Spot;
use super::patch::{EDGES, Patch};
use super::skin::{Far, Skin, across};
use crate::geometry::vector3::{add, dot, norm, normalised, scale, sub};
use crate::pairs::chain::BEYOND;

/// Least 1 + cosine between the directions across two rims at their corner, which bounds how far it
/// goes on: 120 degrees, without unit; chosen.
const SHARPEST: f64 = 0.5;

/// What rims at a corner add up to.
#[derive(Clone, Copy, Default)]
struct Rims {
    across: [f64; 3],
    height: f64,
    count: f64,
    /// A face of theirs, and which of its corners it is.
    first: Option<[usize; 2]>,
}

impl Rims {
    /// From the corner on.
    fn beyond(self) -> [f64; 3] {
        let mean = scale(self.count.recip(), self.across);
        let square = dot(mean, mean).max(0.5 * SHARPEST);
        scale(BEYOND * self.height / self.count / square, mean)
    }
}

impl Skin {
    /// Where it goes on to from its corners, by the numbers of their normals, if its faces are
    /// `patches` at rest; none inside.
    pub(super) fn found_beyond(&self, patches: &[Patch]) -> Vec<Option<Far>> {
        let mut sums = vec![Rims::default(); self.fans.len()];
        for (number, (face, patch)) in self.faces.iter().zip(patches).enumerate() {
            let [a, b, c, ..] = patch.nodes;
            let rims = EDGES.into_iter().zip(face.rims);
            for (ends, _) in rims.filter(|(_, is_rim)| *is_rim) {
                let outward = across(&[a, b, c], ends);
                let Some(unit) = normalised(outward) else {
                    continue;
                };
                for end in ends {
                    let sum = &mut sums[face.normals[end] as usize];
                    sum.across = add(sum.across, unit);
                    sum.height += norm(outward);
                    sum.count += 1.0;
                    sum.first.get_or_insert([number, end]);
                }
            }
        }
        let far = |sum: Rims| {
            let [face, corner] = sum.first?;
            let shares = shares(&patches[face], corner, sum.beyond());
            let face = face as u32;
            Some(Far { face, shares })
        };
        sums.into_iter().map(far).collect()
    }

    /// A face and the shares of its corners in a spot of the outline of `face`.
    pub(super) fn spot(&self, face: usize, spot: Spot) -> (usize, [f64; 3]) {
        let far = self.beyond[self.faces[face].normals[spot.corner] as usize];
        match far.filter(|_| spot.is_far) {
            Some(far) => (far.face as usize, far.shares),
            None => (face, unit(spot.corner)),
        }
    }
}

impl Far {
    /// Where it is.
    pub(super) fn place(&self, patches: &[Patch]) -> [f64; 3] {
        let nodes = patches[self.face as usize].nodes.iter().zip(self.shares);
        nodes.fold([0.0; 3], |sum, (node, share)| add(sum, scale(share, *node)))
    }
}

fn unit(corner: usize) -> [f64; 3] {
    [0, 1, 2].map(|k| if k == corner { 1.0 } else { 0.0 })
}

/// Shares of the corners of a flat triangle in the place `beyond` one of them, as near as its plane has
/// it.
fn shares(patch: &Patch, corner: usize, beyond: [f64; 3]) -> [f64; 3] {
    let [a, b, c, ..] = patch.nodes;
    let [u, v] = [sub(b, a), sub(c, a)];
    let [uu, uv, vv] = [dot(u, u), dot(u, v), dot(v, v)];
    let [along_u, along_v] = [dot(u, beyond), dot(v, beyond)];
    let determinant = uu * vv - uv * uv;
    let s = (along_u * vv - along_v * uv) / determinant;
    let t = (along_v * uu - along_u * uv) / determinant;
    let [r0, s0, t0] = unit(corner);
    [r0 - s - t, s0 + s, t0 + t]
}
