//! The coins of all nodes of a tree: those of the last levels lie around their facets, those above
//! around coins some levels below, which is little wider and does not read all facets again on
//! every level. Cost: one pass over the facets for each of the last levels.

use rayon::prelude::*;

use super::coin::{Coin, Flat, Piece};

/// Levels whose coins lie around facets.
const LAST: u32 = 3;
/// Levels between a coin and those that it lies around, at most.
const APART: u32 = 5;

/// Coins of the nodes of a tree `[2 leaves]` from 1, `facets` being those under a node; the first
/// is not used. `leaves` is a power of two.
pub(super) fn around<I>(leaves: usize, facets: impl Fn(usize) -> I + Sync) -> Vec<Coin>
where
    I: Iterator<Item = Flat>,
{
    let levels = leaves.ilog2();
    let mut coins = vec![Coin::default(); 2 * leaves];
    let last = (leaves..2 * leaves).into_par_iter();
    let mut pieces: Vec<Piece> = last.map(|node| Piece::of(facets(node))).collect();
    for level in (0..=levels).rev() {
        let first = 1 << level;
        let (upper, lower) = coins.split_at_mut(2 * first);
        let nodes = upper[first..].par_iter_mut().zip(&pieces).enumerate();
        nodes.for_each(|(place, (coin, piece))| {
            *coin = match levels - level {
                apart if apart < LAST => Coin::around(piece, facets(first + place)),
                apart => Coin::around_coins(piece, below(lower, (place, apart.min(APART)), first)),
            };
        });
        let pairs = pieces.as_chunks::<2>().0.par_iter();
        pieces = pairs.map(|[left, right]| left.with(right)).collect();
    }
    coins
}

/// The coins some levels below node `place` of a level of `size`, among those of all levels below.
fn below(lower: &[Coin], (place, apart): (usize, u32), size: usize) -> &[Coin] {
    let first = (size << apart) - 2 * size;
    &lower[first + (place << apart)..first + ((place + 1) << apart)]
}
