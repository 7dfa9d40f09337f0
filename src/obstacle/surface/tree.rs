//! The nearest facet, by a tree: facets are halved along the longest side of the box of their
//! middles until few are left, in parallel, and a [`BoundingDisc`] lies around each half.
//!
//! ```text
//! children of node i: 2 i and 2 i + 1;   leaves: the last level
//! ```
//!
//! A search may begin with any facet: what is farther than it is left out. Among facets at one
//! distance the first is taken, and discs are wider than rounding, so that where a search begins
//! changes no bit of what it finds. For points beside each other the nodes that may matter, as large
//! as they are apart, are found once. Coordinates are about one. Cost: n log n to build; some
//! hundred discs and 10 facets a search, a third of it for points beside each other.

use super::bounding_disc::{BoundingDisc, Flat, of_tree};
use super::triangle::{Place, nearest};
use crate::geometry::vector3::{add, scale};
use crate::parallel;

/// Facets of a leaf at most.
const LEAF: usize = 4;
/// Fewer facets are not worth a second thread.
const PARALLEL: usize = 4096;
/// Nodes that wait at most: one a level of a tree of 2^32 leaves.
const WAITING: usize = 32;

/// Discs around facets in an order of their own.
#[derive(Clone, Debug)]
pub(super) struct FacetTree {
    /// Nodes from 1; the first is not used.
    discs: Vec<BoundingDisc>,
    /// Where the facets of each leaf begin `[leaves + 1]`.
    starts: Vec<u32>,
}

/// Corners of facets in their order.
pub(super) trait Corners: Fn(usize) -> [[f64; 3]; 3] {}
impl<F: Fn(usize) -> [[f64; 3]; 3]> Corners for F {}

/// The nearest facet so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) facet: usize,
    pub(super) place: Place,
}

impl Found {
    /// One facet.
    pub(super) fn new(facet: usize, x: [f64; 3], corners: &impl Corners) -> Self {
        Self {
            facet,
            place: nearest(x, corners(facet)),
        }
    }
}

/// Nodes below which all lies that may be nearest to some points.
#[derive(Clone, Debug)]
pub(super) struct Region(Vec<usize>);

/// The middle of a facet, kept beside its number: halves are then read in a row.
#[derive(Clone, Copy)]
struct Middle {
    place: [f64; 3],
    facet: u32,
}

/// The order of the facets in which a tree takes them.
pub(super) fn order(corners: &[[[f64; 3]; 3]]) -> Vec<u32> {
    let middle = |facet: usize| {
        let [a, b, c] = corners[facet];
        Middle {
            place: scale(1.0 / 3.0, add(a, add(b, c))),
            facet: facet as u32,
        }
    };
    let mut middles = parallel::map(corners.len(), 1, &middle);
    halve(&mut middles, levels(corners.len()));
    middles.iter().map(|middle| middle.facet).collect()
}

/// Halvings until leaves are small enough.
fn levels(facets: usize) -> u32 {
    facets.div_ceil(LEAF).next_power_of_two().ilog2()
}

fn halve(part: &mut [Middle], levels: u32) {
    if levels == 0 || part.len() < 2 {
        return;
    }
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = part.iter().fold(start, |(low, high), middle| {
        let [x, y, z] = middle.place;
        (
            [low[0].min(x), low[1].min(y), low[2].min(z)],
            [high[0].max(x), high[1].max(y), high[2].max(z)],
        )
    });
    let width = |&axis: &usize| high[axis] - low[axis];
    let wider = |a: &usize, b: &usize| width(a).total_cmp(&width(b));
    let axis = (0..3).max_by(wider).unwrap_or_default();
    let half = part.len().div_ceil(2);
    part.select_nth_unstable_by(half - 1, |a, b| {
        let by_place = a.place[axis].total_cmp(&b.place[axis]);
        by_place.then(a.facet.cmp(&b.facet))
    });
    let is_large = part.len() > PARALLEL;
    let (left, right) = part.split_at_mut(half);
    let [mut left, mut right] = [left, right].map(|part| move || halve(part, levels - 1));
    if is_large {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

impl FacetTree {
    /// The tree over facets of a closed surface, which lie in the [`order`] of one.
    pub(super) fn new(facets: usize, flat: impl Fn(usize) -> Flat + Sync) -> Self {
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
        let discs = of_tree(leaves, |node| {
            // The leaves under a node of a level.
            let below = leaves >> node.ilog2();
            let first = node * below - leaves;
            let facets = starts[first] as usize..starts[first + below] as usize;
            facets.map(&flat)
        });
        Self { discs, starts }
    }

    /// The facet nearest to `x`, among facets with these corners.
    pub(super) fn nearest(&self, x: [f64; 3], corners: impl Corners) -> Found {
        let mut best = Found::new(0, x, &corners);
        self.descend(1, (x, &corners), &mut best);
        best
    }

    /// The same for a point of a region, from a facet that is near.
    pub(super) fn nearest_from(
        &self,
        (x, corners): ([f64; 3], impl Corners),
        near: Found,
        region: &Region,
    ) -> Found {
        let mut best = near;
        for &node in &region.0 {
            let square = self.discs[node].square_of_nearest(x, best.place.square);
            if square <= best.place.square {
                self.descend(node, (x, &corners), &mut best);
            }
        }
        best
    }

    /// The region of points within `reach` of `x`, to which `found` is the nearest facet.
    pub(super) fn region(&self, x: [f64; 3], found: &Found, reach: f64) -> Region {
        let leaves = self.starts.len() - 1;
        let farthest = found.place.square.sqrt() + 2.0 * reach;
        let mut open = vec![1];
        let mut nodes = Vec::new();
        while let Some(node) = open.pop() {
            let disc = &self.discs[node];
            if !disc.may_be_nearest((x, reach), farthest) {
                continue;
            }
            if node >= leaves || f64::from(disc.radius()) < reach {
                nodes.push(node)
            } else {
                open.extend([2 * node + 1, 2 * node])
            }
        }
        Region(nodes)
    }

    /// Looks through the facets of a leaf.
    fn look_through(&self, node: usize, (x, corners): ([f64; 3], &impl Corners), best: &mut Found) {
        let leaf = node - (self.starts.len() - 1);
        for facet in self.starts[leaf] as usize..self.starts[leaf + 1] as usize {
            let found = Found::new(facet, x, corners);
            if (found.place.square, found.facet) < (best.place.square, best.facet) {
                *best = found;
            }
        }
    }

    /// Looks through what is below a node and not farther than the best so far.
    fn descend(&self, from: usize, (x, corners): ([f64; 3], &impl Corners), best: &mut Found) {
        let leaves = self.starts.len() - 1;
        let mut waiting = [(0, 0.0); WAITING];
        let (mut count, mut node) = (0, from);
        loop {
            while node < leaves {
                let (a, b) = (2 * node, 2 * node + 1);
                let to = |node: usize| self.discs[node].square_of_nearest(x, best.place.square);
                let (to_a, to_b) = (to(a), to(b));
                let [near, far] = if to_b < to_a {
                    [(b, to_b), (a, to_a)]
                } else {
                    [(a, to_a), (b, to_b)]
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
                self.look_through(node, (x, corners), best);
            }
            loop {
                let Some(last) = count.checked_sub(1) else {
                    return;
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
        2 * leaves * size_of::<BoundingDisc>() + (leaves + 1) * size_of::<u32>()
    }
}
