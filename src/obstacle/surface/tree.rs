//! The nearest facet, by a tree: facets are halved along the longest side of the box of their
//! middles until few are left, in parallel, and a [`Coin`] lies around each half.
//!
//! ```text
//! children of node i: 2 i and 2 i + 1;   leaves: the last level
//! ```
//!
//! A search may begin with any facet: what is farther than it is left out. Among facets at one
//! distance the first is taken, and coins are wider than rounding, so that where a search begins
//! changes no bit of what it finds. Coordinates are about one. Cost: n log n to build, some 40
//! coins and 10 facets a search, less from a facet nearby.

use rayon::prelude::*;

use super::coin::Coin;
use super::triangle::{Place, nearest};
use crate::geometry::vector3::{add, scale};

/// Facets of a leaf at most.
const LEAF: usize = 4;
/// Fewer facets are not worth a second thread.
const PARALLEL: usize = 4096;
/// Nodes that wait at most: one a level of a tree of 2^32 leaves.
const WAITING: usize = 32;

/// Coins around facets in an order of their own.
#[derive(Clone, Debug)]
pub(super) struct FacetTree {
    /// Nodes from 1; the first is not used.
    coins: Vec<Coin>,
    /// Where the facets of each leaf begin `[leaves + 1]`.
    starts: Vec<u32>,
}

/// The nearest facet so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) facet: usize,
    pub(super) place: Place,
}

/// The order of the facets in which a tree takes them.
pub(super) fn order(corners: &[[[f64; 3]; 3]]) -> Vec<u32> {
    let middle = |[a, b, c]: &[[f64; 3]; 3]| scale(1.0 / 3.0, add(*a, add(*b, *c)));
    let middles: Vec<[f64; 3]> = corners.par_iter().map(middle).collect();
    let mut order: Vec<u32> = (0..corners.len() as u32).collect();
    halve(&mut order, &middles, levels(corners.len()));
    order
}

/// Halvings until leaves are small enough.
fn levels(facets: usize) -> u32 {
    facets.div_ceil(LEAF).next_power_of_two().ilog2()
}

fn halve(part: &mut [u32], middles: &[[f64; 3]], levels: u32) {
    if levels == 0 || part.len() < 2 {
        return;
    }
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = part.iter().fold(start, |(low, high), &facet| {
        let [x, y, z] = middles[facet as usize];
        (
            [low[0].min(x), low[1].min(y), low[2].min(z)],
            [high[0].max(x), high[1].max(y), high[2].max(z)],
        )
    });
    let width = |&axis: &usize| high[axis] - low[axis];
    let wider = |a: &usize, b: &usize| width(a).total_cmp(&width(b));
    let axis = (0..3).max_by(wider).unwrap_or_default();
    let half = part.len().div_ceil(2);
    let key = |facet: u32| middles[facet as usize][axis];
    part.select_nth_unstable_by(half - 1, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    let is_large = part.len() > PARALLEL;
    let (left, right) = part.split_at_mut(half);
    let [mut left, mut right] = [left, right].map(|part| move || halve(part, middles, levels - 1));
    match is_large {
        true => {
            rayon::join(left, right);
        }
        false => {
            left();
            right();
        }
    }
}

impl FacetTree {
    /// The tree over facets with these corners, which lie in the [`order`] of one.
    pub(super) fn new(facets: usize, corners: impl Fn(usize) -> [[f64; 3]; 3] + Sync) -> Self {
        let mut sizes = vec![facets as u32];
        for _ in 0..levels(facets) {
            let halves = sizes.iter().flat_map(|size| [size.div_ceil(2), size / 2]);
            sizes = halves.collect();
        }
        let mut starts = vec![0];
        starts.extend(sizes.iter().scan(0, |start, size| {
            *start += size;
            Some(*start)
        }));
        let leaves = sizes.len();
        let coin = |node: usize| {
            // The leaves under a node of a level.
            let below = leaves >> node.max(1).ilog2();
            let first = node * below - leaves.min(node * below);
            let facets = starts[first] as usize..starts[first + below] as usize;
            Coin::around(facets.map(&corners))
        };
        let coins = (0..2 * leaves).into_par_iter().map(coin).collect();
        Self { coins, starts }
    }

    /// The facet nearest to `x`, among facets with these corners, no farther than that of `best`.
    pub(super) fn nearest(
        &self,
        x: [f64; 3],
        corners: impl Fn(usize) -> [[f64; 3]; 3],
        best: Option<usize>,
    ) -> Found {
        let own = |facet: usize| Found {
            facet,
            place: nearest(x, corners(facet)),
        };
        let mut best = own(best.unwrap_or_default());
        let leaves = self.starts.len() - 1;
        let mut waiting = [(0, 0.0); WAITING];
        let (mut count, mut node) = (0, 1);
        loop {
            while node < leaves {
                let (a, b) = (2 * node, 2 * node + 1);
                let (to_a, to_b) = (self.coins[a].square_to(x), self.coins[b].square_to(x));
                let [near, far] = match to_b < to_a {
                    true => [(b, to_b), (a, to_a)],
                    false => [(a, to_a), (b, to_b)],
                };
                if far.1 <= best.place.square {
                    waiting[count] = far;
                    count += 1;
                }
                if near.1 > best.place.square {
                    break;
                }
                node = near.0;
            }
            if node >= leaves {
                let leaf = node - leaves;
                for facet in self.starts[leaf] as usize..self.starts[leaf + 1] as usize {
                    let found = own(facet);
                    if (found.place.square, found.facet) < (best.place.square, best.facet) {
                        best = found;
                    }
                }
            }
            loop {
                let Some(last) = count.checked_sub(1) else {
                    return best;
                };
                count = last;
                if waiting[last].1 <= best.place.square {
                    node = waiting[last].0;
                    break;
                }
            }
        }
    }

    /// Bytes of a tree over so many facets.
    pub(super) fn bytes(facets: usize) -> usize {
        let leaves = 1_usize << levels(facets);
        2 * leaves * size_of::<Coin>() + (leaves + 1) * size_of::<u32>()
    }
}
