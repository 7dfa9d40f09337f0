//! Vertices whose facets lie around them in one closed ring without a feature, as nearly all of a
//! fine triangulation do: their neighbours are listed once, and two rings around one of them
//! are the neighbours of its neighbours, without a search. Cost: a walk around each vertex.

use super::flats::{Flats, is_like};
use super::rings::Rings;
use super::topology::Facets;
use crate::parallel;

/// Facets that a fit looks at, at most: fans of many more show nothing new.
pub(super) const MOST: usize = 512;
/// Facets around such a vertex at most.
const MOST_AROUND: usize = 32;

/// What lies around vertices.
pub(super) struct Around<'a> {
    rings: &'a Rings,
    /// Neighbours of each vertex, where the rings have its facets.
    neighbours: Vec<u32>,
    /// Least and largest area of the flat parts around each vertex, where it is plain.
    areas: Vec<Option<[f64; 2]>>,
}

impl<'a> Around<'a> {
    /// What lies around all vertices of `facets`.
    pub(super) fn new(
        facets: &Facets,
        (rings, features): (&'a Rings, &[[bool; 3]]),
        flats: &Flats,
    ) -> Self {
        let areas = |vertex: usize| {
            let ring = rings.of(vertex);
            is_plain(facets, (vertex as u32, ring), features).then(|| {
                let areas = ring.iter().map(|&facet| flats.area_of(facet as usize));
                areas.fold([f64::INFINITY, 0.0], |[least, most], area| {
                    [least.min(area), most.max(area)]
                })
            })
        };
        Self {
            rings,
            neighbours: rings.behind(&facets.corners),
            areas: parallel::map(rings.vertices(), 1, &areas),
        }
    }

    /// Whether the facets around a vertex are one closed ring without a feature.
    pub(super) fn is_plain(&self, vertex: u32) -> bool {
        self.areas[vertex as usize].is_some()
    }

    /// The vertices of two rings around a vertex, ascending, without itself, where all in the inner
    /// ring are plain and all facets at them are like those of areas in `range`.
    pub(super) fn two_rings(&self, vertex: u32, range: [f64; 2]) -> Option<Vec<u32>> {
        self.areas[vertex as usize]?;
        let mut all = Vec::with_capacity(2 * MOST_AROUND);
        for &near in self.neighbours(vertex) {
            let [least, most] = self.areas[near as usize]?;
            if !is_like(range, least) || !is_like(range, most) {
                return None;
            }
            all.extend_from_slice(self.neighbours(near));
        }
        // A search that is cut short finds others.
        if all.len() > MOST {
            return None;
        }
        all.sort_unstable();
        all.dedup();
        all.retain(|&one| one != vertex);
        Some(all)
    }

    fn neighbours(&self, vertex: u32) -> &[u32] {
        &self.neighbours[self.rings.range(vertex as usize)]
    }
}

/// Whether one walk around a vertex, over no feature, meets all its facets.
fn is_plain(facets: &Facets, (vertex, ring): (u32, &[u32]), features: &[[bool; 3]]) -> bool {
    let Some(&first) = ring.first() else {
        return false;
    };
    let mut at = first as usize;
    for seen in 1..=ring.len().min(MOST_AROUND) {
        let Some(corner) = facets.corner_of(at, vertex) else {
            return false;
        };
        // The edge from the vertex to the next but one corner leads anticlockwise.
        let opposite = (corner + 1) % 3;
        if features[at][opposite] {
            return false;
        }
        at = facets.across[at][opposite] as usize;
        if at == first as usize {
            return seen == ring.len();
        }
    }
    false
}
