//! Facets that bound nothing, as programs write many: without area, or there twice. They are left
//! out where the surface stays closed without them.
//!
//! ```text
//! two corners alike           the facet goes; its neighbours meet
//! c on the edge from a to b   the edge a b of it and of a d b turns into c d
//! twice, once turned around   both go: nothing lies between them
//! ```
//!
//! Places of vertices do not change. Cost: a table of all edges, only where a facet has no area;
//! a sort of all facets, only where one is there twice.

use std::collections::HashMap;

use super::checks::{SurfaceError, is_flat};

/// Turns of an edge a facet without area, more of which lead nowhere.
const MOST_TURNS: usize = 4;

/// What was left out of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Number of facets.
    pub facets: usize,
    /// The first of them, as the caller counts.
    pub first: usize,
}

impl LeftOut {
    /// Both.
    pub(super) fn and(before: Option<Self>, other: Self) -> Option<Self> {
        let first = before.map_or(other.first, |one| one.first.min(other.first));
        let facets = before.map_or(0, |one| one.facets) + other.facets;
        Some(Self { facets, first })
    }
}

/// Facets by the edges that they go along.
struct Table<'t> {
    vertices: &'t [[f64; 3]],
    facets: Vec<[u32; 3]>,
    by_edge: HashMap<(u32, u32), usize>,
}

impl Table<'_> {
    fn enter(&mut self, facet: usize) {
        let [a, b, c] = self.facets[facet];
        for edge in [(a, b), (b, c), (c, a)] {
            self.by_edge.insert(edge, facet);
        }
    }

    fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        self.facets[facet].map(|vertex| self.vertices[vertex as usize])
    }

    /// Turns the longest edge of a facet without area; the facet beyond it, none where that is
    /// not possible.
    fn turn(&mut self, facet: usize) -> Option<usize> {
        let [a, b, c] = self.longest_first(facet);
        let other = *self.by_edge.get(&(b, a))?;
        let d = *self.facets[other].iter().find(|v| **v != a && **v != b)?;
        let is_there = [(c, d), (d, c)]
            .iter()
            .any(|edge| self.by_edge.contains_key(edge));
        if d == c || other == facet || is_there {
            return None;
        }
        self.by_edge.remove(&(a, b));
        self.by_edge.remove(&(b, a));
        self.facets[facet] = [a, d, c];
        self.facets[other] = [d, b, c];
        self.enter(facet);
        self.enter(other);
        Some(other)
    }

    /// Corners of a facet, those of its longest edge first.
    fn longest_first(&self, facet: usize) -> [u32; 3] {
        let [a, b, c] = self.facets[facet];
        let square = |from: u32, to: u32| {
            let ends = [from, to].map(|vertex| self.vertices[vertex as usize]);
            let terms = ends[0].iter().zip(ends[1]).map(|(x, y)| (x - y).powi(2));
            terms.sum::<f64>()
        };
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let longer = |x: &[u32; 3], y: &[u32; 3]| square(x[0], x[1]).total_cmp(&square(y[0], y[1]));
        turned.into_iter().max_by(longer).unwrap_or([a, b, c])
    }
}

/// The facets without those that have no area, and what that was; as they are where nothing
/// leads further.
pub(super) fn with_area(
    vertices: &[[f64; 3]],
    facets: Vec<[u32; 3]>,
) -> (Vec<[u32; 3]>, Option<LeftOut>) {
    let is_flat_one = |corners: &[u32; 3]| is_flat(corners.map(|v| vertices[v as usize]));
    let Some(first) = facets.iter().position(is_flat_one) else {
        return (facets, None);
    };
    let count = facets.iter().filter(|corners| is_flat_one(corners)).count();
    let left_out = LeftOut {
        facets: count,
        first,
    };
    let apart = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    let facets: Vec<[u32; 3]> = facets.into_iter().filter(apart).collect();
    let mut table = Table {
        vertices,
        by_edge: HashMap::with_capacity(3 * facets.len()),
        facets,
    };
    (0..table.facets.len()).for_each(|facet| table.enter(facet));
    let all = 0..table.facets.len();
    let mut flat: Vec<usize> = all.filter(|&at| is_flat(table.corners(at))).collect();
    let mut turns = MOST_TURNS * flat.len();
    while let Some(facet) = flat.pop() {
        if !is_flat(table.corners(facet)) {
            continue;
        }
        let turned = table.turn(facet).filter(|_| turns > 0);
        turns = turns.saturating_sub(1);
        match turned {
            Some(other) => flat.extend([facet, other]),
            None => break,
        }
    }
    (table.facets, Some(left_out))
}

/// Checks that every facet has an area, once those that could be left out are; a fault names the
/// first one that was given.
pub(super) fn areas(
    vertices: &[[f64; 3]],
    (facets, left_out): (&[[u32; 3]], Option<LeftOut>),
) -> Result<(), SurfaceError> {
    let at = |corners: &[u32; 3]| corners.map(|vertex| vertices[vertex as usize]);
    let flat = left_out.and_then(|_| facets.iter().map(at).find(|corners| is_flat(*corners)));
    match (flat, left_out) {
        (Some(corners), Some(left_out)) => Err(SurfaceError::Degenerate {
            facet: left_out.first,
            at: corners[0],
        }),
        _ => Ok(()),
    }
}

/// The facets without those that are there twice; pairs that face each other go both.
pub(super) fn without_twice(facets: &[[u32; 3]]) -> (Vec<[u32; 3]>, Option<LeftOut>) {
    let key = |corners: &[u32; 3]| {
        let mut sorted = *corners;
        sorted.sort_unstable();
        let [a, b, c] = *corners;
        let least = sorted[0];
        let is_even = [[a, b, c], [b, c, a], [c, a, b]]
            .iter()
            .any(|turned| turned[0] == least && turned[1] == sorted[1]);
        (sorted, if is_even { 1_i32 } else { -1 })
    };
    let mut sums: HashMap<[u32; 3], i32> = HashMap::with_capacity(facets.len());
    for (sorted, side) in facets.iter().map(key) {
        *sums.entry(sorted).or_default() += side;
    }
    let mut left_out = None;
    let mut kept = Vec::with_capacity(facets.len());
    for (index, corners) in facets.iter().enumerate() {
        let (sorted, side) = key(corners);
        match sums.get_mut(&sorted) {
            Some(sum) if sum.signum() == side => {
                kept.push(*corners);
                *sum = 0;
            }
            _ => {
                let one = LeftOut {
                    facets: 1,
                    first: index,
                };
                left_out = LeftOut::and(left_out, one);
            }
        }
    }
    (kept, left_out)
}
