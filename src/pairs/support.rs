//! Functions of a carrier of which the other surface covers next to nothing.
//!
//! ```text
//! share_k = max over the faces of k of   int over what has a partner psi_k da / int psi_k da
//! ```
//!
//! A function with a small share presses on a sliver alone: to balance what its neighbours leave, its
//! pressure grows without bound (800 times, where a punch ends by a tenth of a face beyond a vertex).
//! Where a neighbour has a share that is not small, the nearest ones take such a function over in
//! equal parts, as they do where supports hold it: pressures stay positive, and an even one stays even.
//! Where all shares are small, as under a body smaller than a face, the largest one keeps its multiplier.
//! Shares count face by face, so that a surface that ends at a vertex keeps its function.
//!
//! Which functions lend is found where an increment begins and holds in it, so that gaps stay smooth.
//! Shapes `[multipliers]`. Cost: one search of partners, one sort.

use super::surface::PairSurface;
use crate::contact::{ContactSurface, Deformed};
use crate::geometry::vector3::{norm, sub};

/// Share up to which it is small, without unit; chosen, away from those of faces of which a quarter, a
/// third or a half is covered, where rounding would decide.
const SMALL: f64 = 0.33;
/// Distances that differ by less, relative, are equal.
const AS_NEAR: f64 = 1e-6;

/// What a multiplier has to press on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Support {
    /// Nothing: none of its functions has a partner.
    Nothing,
    /// Nothing yet, beside one that presses: what slides over it would begin with a sliver, and its
    /// neighbours take its function over.
    Nearly,
    /// Too little: its neighbours take its function over.
    Little,
    /// Enough.
    #[default]
    Enough,
}

impl Support {
    /// Whether others take its function over.
    pub fn lends(self) -> bool {
        matches!(self, Self::Nearly | Self::Little)
    }
}

impl PairSurface {
    /// What each multiplier of `surface` has to press on where `body` has both sides, and they press by
    /// `pressures` `[multipliers]`.
    pub fn supports(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
    ) -> Vec<Support> {
        let shares = self.gaps_of((body, surface), |found| found.shares());
        let beside = beside(surface);
        let mut found = supports((surface, &beside), &shares);
        let presses = |m: &u32| pressures[*m as usize] > 0.0;
        let nearly = (0..found.len()).filter(|&m| {
            let is_beside = || takers(&beside, &found, m).any(|taker| presses(&taker));
            found[m] == Support::Nothing && is_beside()
        });
        for m in nearly.collect::<Vec<usize>>() {
            found[m] = Support::Nearly;
        }
        found
    }

    /// The same of linear bodies for good: where the surfaces of `body`, which is at rest, touch.
    pub fn supports_at_rest(&self, body: &Deformed<'_>, surface: &ContactSurface) -> Vec<Support> {
        let moved = self.touching(body, surface);
        let at = Deformed {
            displacement: &moved,
            ..*body
        };
        self.supports(&at, (surface, &vec![0.0; surface.multipliers()]))
    }

    /// What `pressures` `[multipliers]` exert along the normals on what has a partner.
    pub fn normal_force(
        &self,
        body: &Deformed<'_>,
        (surface, pressures): (&ContactSurface, &[f64]),
    ) -> f64 {
        let coefficients = surface.shares.spread(pressures);
        let [covered, _] = self.gaps_of((body, surface), |found| found.covered());
        let terms = coefficients.iter().zip(covered);
        terms.map(|(pressure, area)| pressure * area).sum()
    }
}

/// By the shares of functions `[functions]`.
fn supports((surface, beside): (&ContactSurface, &[Vec<u32>]), shares: &[f64]) -> Vec<Support> {
    let of = |m: u32| {
        surface
            .shares
            .function(m)
            .map_or(0.0, |k| shares[k as usize])
    };
    let share: Vec<f64> = (0..surface.multipliers() as u32).map(of).collect();
    let mut order: Vec<usize> = (0..share.len()).filter(|&m| share[m] > 0.0).collect();
    order.sort_by(|&a, &b| share[b].total_cmp(&share[a]));
    let mut found = vec![Support::Nothing; share.len()];
    for m in order {
        let is_enough = |&other: &u32| found[other as usize] == Support::Enough;
        let lends = share[m] < SMALL && beside[m].iter().any(is_enough);
        found[m] = if lends {
            Support::Little
        } else {
            Support::Enough
        };
    }
    found
}

/// The multipliers with enough support that may take over the function of `m`: those beside it, and
/// those beside neighbours that lend theirs, too.
fn takers<'a>(
    beside: &'a [Vec<u32>],
    supports: &'a [Support],
    m: usize,
) -> impl Iterator<Item = u32> + 'a {
    let around = beside[m].iter().copied();
    let lends = move |other: &u32| supports[*other as usize] == Support::Little;
    let beyond = around.clone().filter(lends);
    let beyond = beyond.flat_map(|other| beside[other as usize].iter().copied());
    let is_enough = |other: &u32| supports[*other as usize] == Support::Enough;
    let direct = around.clone().any(|other| is_enough(&other));
    let all = around.chain(beyond.filter(move |_| !direct));
    all.filter(is_enough)
}

/// The surface of `mesh` where multipliers with little support lend their functions.
pub fn lending(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    supports: &[Support],
) -> ContactSurface {
    let place = |m: u32| {
        let function = surface.shares.function(m);
        let node = function.map(|k| surface.carriers[k as usize]);
        node.map_or([0.0; 3], |node| body.space.node_place(body.mesh, node))
    };
    let beside = beside(surface);
    let takers = supports.iter().enumerate().map(|(m, support)| {
        let others = takers(&beside, supports, m).map(|other| (other, place(other)));
        support.lends().then(|| nearest(place(m as u32), others))
    });
    surface.lending(&takers.collect::<Vec<_>>())
}

/// The nearest ones to a place, ascending.
fn nearest(from: [f64; 3], others: impl Iterator<Item = (u32, [f64; 3])>) -> Vec<u32> {
    let found: Vec<(u32, f64)> = others.map(|(m, at)| (m, norm(sub(at, from)))).collect();
    let distances = found.iter().map(|&(_, distance)| distance);
    let least = distances.fold(f64::INFINITY, f64::min);
    let near = found.into_iter();
    let near = near.filter(|&(_, distance)| distance <= (1.0 + AS_NEAR) * least);
    let mut near: Vec<u32> = near.map(|(m, _)| m).collect();
    near.sort_unstable();
    near.dedup();
    near
}

/// The multipliers that have functions on common faces with each, ascending.
fn beside(surface: &ContactSurface) -> Vec<Vec<u32>> {
    let mut beside = vec![Vec::new(); surface.multipliers()];
    for face in &surface.faces {
        let all = face.functions.iter().flat_map(|&k| surface.shares.of(k));
        let all: Vec<u32> = all.map(|(m, _)| m).collect();
        for &m in &all {
            beside[m as usize].extend(all.iter().filter(|&&other| other != m));
        }
    }
    for own in &mut beside {
        own.sort_unstable();
        own.dedup();
    }
    beside
}
