//! The facets around each vertex, the vertices behind them, and whatever else belongs to
//! vertices, sorted by them: counted into the places of its vertex, then the few of each among
//! themselves, in parallel. Cost: two passes over all, and a number a vertex.

use crate::parallel;
use rayon::prelude::*;

/// Vertices that a thread takes at a time.
const AT_A_TIME: usize = 4096;

/// The facets at each vertex, ascending.
pub(super) struct Rings {
    /// Where the facets of a vertex begin `[vertices + 1]`.
    starts: Vec<u32>,
    facets: Vec<u32>,
    /// Place of each corner of each facet among `facets`.
    pub(super) places: Vec<[u32; 3]>,
}

impl Rings {
    /// Those of `facets` between `vertices` vertices.
    pub(super) fn new(facets: &[[u32; 3]], vertices: usize) -> Self {
        let mut starts = vec![0_u32; vertices + 1];
        for &vertex in facets.as_flattened() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut all = vec![0; 3 * facets.len()];
        let mut places = vec![[0; 3]; facets.len()];
        for (facet, corners) in facets.iter().enumerate() {
            for (place, &vertex) in places[facet].iter_mut().zip(corners) {
                *place = next[vertex as usize];
                all[*place as usize] = facet as u32;
                next[vertex as usize] += 1;
            }
        }
        Self {
            starts,
            facets: all,
            places,
        }
    }

    pub(super) fn vertices(&self) -> usize {
        self.starts.len() - 1
    }

    /// The facets at a vertex.
    pub(super) fn of(&self, vertex: usize) -> &[u32] {
        &self.facets[self.range(vertex)]
    }

    /// Where the facets of a vertex are among those of all.
    pub(super) fn range(&self, vertex: usize) -> std::ops::Range<usize> {
        self.starts[vertex] as usize..self.starts[vertex + 1] as usize
    }

    /// The vertex that each facet around a vertex names behind it, beside the facets of [`Self::of`].
    pub(super) fn behind(&self, facets: &[[u32; 3]]) -> Vec<u32> {
        let vertices = (0..self.vertices() as u32).into_par_iter();
        let of_vertex = |vertex: u32| {
            let ring = self.of(vertex as usize).iter();
            ring.map(move |&facet| {
                let [a, b, c] = facets[facet as usize];
                match (a == vertex, b == vertex) {
                    (true, _) => b,
                    (_, true) => c,
                    _ => a,
                }
            })
        };
        vertices.flat_map_iter(of_vertex).collect()
    }
}

/// The facet across the edge opposite each corner, where every edge has one facet in each
/// direction; none where one has not, or both its ends have more facets than are looked through.
pub(super) fn across(corners: &[[u32; 3]], rings: &Rings) -> Option<Vec<[u32; 3]>> {
    /// Facets around a vertex that are looked through.
    const MOST: usize = 64;
    let mate = |from: u32, to: u32| {
        let [own, other] = [from, to].map(|vertex| rings.of(vertex as usize));
        let ring = if own.len() < other.len() { own } else { other };
        if ring.len() > MOST {
            return None;
        }
        let mut mates = ring.iter().filter(|&&facet| {
            let [a, b, c] = corners[facet as usize];
            (a == to && b == from) || (b == to && c == from) || (c == to && a == from)
        });
        match (mates.next(), mates.next()) {
            (Some(mate), None) => Some(*mate),
            _ => None,
        }
    };
    let of_facet = |facet: usize| {
        let [a, b, c] = corners[facet];
        Some([mate(b, c)?, mate(c, a)?, mate(a, b)?])
    };
    let found = parallel::map(corners.len(), 1, &of_facet);
    found.into_iter().collect()
}

/// Sorts what belongs to vertices, the `first` of which is what it is sorted by first: by vertex
/// in one pass, then the few of each.
pub(super) fn sorted_by_vertex<T: Ord + Copy + Default + Send>(
    all: impl Iterator<Item = T> + Clone,
    vertices: usize,
    first: impl Fn(&T) -> u32,
) -> Vec<T> {
    let mut next = vec![0_u32; vertices + 1];
    for one in all.clone() {
        next[first(&one) as usize + 1] += 1;
    }
    for vertex in 0..vertices {
        next[vertex + 1] += next[vertex];
    }
    let count = next[vertices] as usize;
    let mut sorted = vec![T::default(); count];
    for one in all {
        let place = &mut next[first(&one) as usize];
        sorted[*place as usize] = one;
        *place += 1;
    }
    // Now `next` holds where each vertex ends.
    let mut rest = &mut sorted[..];
    let mut parts = Vec::with_capacity(vertices.div_ceil(AT_A_TIME));
    let mut start = 0;
    for ends in next[..vertices].chunks(AT_A_TIME) {
        let end = ends.last().copied().unwrap_or(start);
        let (part, others) = rest.split_at_mut((end - start) as usize);
        parts.push((part, start, ends));
        (rest, start) = (others, end);
    }
    parts.into_par_iter().for_each(|(part, start, ends)| {
        let mut from = 0;
        for end in ends.iter().map(|end| (end - start) as usize) {
            part[from..end].sort_unstable();
            from = end;
        }
    });
    sorted
}
