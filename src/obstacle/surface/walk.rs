//! The nearest point of all patches near the nearest facet: from patch to patch across the edge
//! over which Newton's method leaves each; where that does not end inside one, through all
//! patches that meet at the nearest point of the boundary so far.

use super::closest::{Foot, Part, Search};
use super::patch::Patch;
use super::topology::Facets;
use super::tree::{FacetTree, Found, Region};

/// Facets that a search goes through at most.
const WALK: usize = 24;
/// Facets around a vertex that are looked at, at most.
const MOST_AROUND: usize = 64;
/// Patches that Newton's method is led through at most.
const CROSSED: usize = 3;

/// Facets on the way to one nearby at most.
const DOWNHILL: usize = 16;

/// A point of the surface: the facet and its place on the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) facet: usize,
    pub(super) foot: Foot,
}

/// Patches in the order of a tree over their facets, with their neighbours.
#[derive(Debug)]
pub(super) struct Searched {
    pub(super) facets: Facets,
    pub(super) patches: Vec<Patch>,
    pub(super) tree: FacetTree,
}

impl Searched {
    /// The facet nearest to `x`.
    pub(super) fn nearest_facet(&self, x: [f64; 3]) -> Found {
        self.tree.nearest(x, |facet| self.patches[facet].corners)
    }

    /// The same from a facet that is near, for a point of a region.
    pub(super) fn nearest_facet_from(&self, x: [f64; 3], near: usize, region: &Region) -> Found {
        let corners = |facet: usize| self.patches[facet].corners;
        let near = self.downhill(x, near);
        self.tree.nearest_from((x, corners), near, region)
    }

    /// A facet near `x`: from one across the edges at its nearest point, as long as they lead nearer.
    fn downhill(&self, x: [f64; 3], from: usize) -> Found {
        let corners = |facet: usize| self.patches[facet].corners;
        let mut best = Found::new(from, x, &corners);
        for _ in 0..DOWNHILL {
            let on = (0..3).filter(|&opposite| best.place.l[opposite] <= 0.0);
            let across = on.map(|opposite| self.facets.across[best.facet][opposite] as usize);
            let mut nearer = across.map(|facet| Found::new(facet, x, &corners));
            match nearer.find(|found| found.place.square < best.place.square) {
                Some(found) => best = found,
                None => break,
            }
        }
        best
    }

    /// The nearest point to `x`, to which this facet is the nearest.
    pub(super) fn nearest(&self, x: [f64; 3], found: &Found) -> Nearest {
        let (first, start) = (found.facet, found.place.l);
        let crossed = self.crossing(x, (first, start));
        crossed.unwrap_or_else(|| self.through_boundaries(x, (first, start)))
    }

    /// Newton's method through some patches.
    fn crossing(&self, x: [f64; 3], (mut facet, mut l): (usize, [f64; 3])) -> Option<Nearest> {
        for _ in 0..CROSSED {
            match self.patches[facet].search(x, l) {
                Search::Inside(foot) => return Some(Nearest { facet, foot }),
                Search::Lost => return None,
                Search::Beyond(beyond) => {
                    let opposite = least(beyond);
                    let place = beyond.map(|l| l.max(0.0));
                    let whole: f64 = place.iter().sum();
                    let at = place.map(|l| l / whole);
                    (facet, l) = self.across(facet, opposite, at);
                }
            }
        }
        None
    }

    /// The facet across an edge, and the same point of the edge there.
    fn across(&self, facet: usize, opposite: usize, l: [f64; 3]) -> (usize, [f64; 3]) {
        let other = self.facets.across[facet][opposite] as usize;
        let mut there = [0.0; 3];
        for corner in [(opposite + 1) % 3, (opposite + 2) % 3] {
            let vertex = self.facets.corners[facet][corner];
            if let Some(place) = self.facets.corner_of(other, vertex) {
                there[place] = l[corner];
            }
        }
        (other, there)
    }

    /// The facet beyond the edge that a point is on, and its place there.
    pub(super) fn beyond(&self, at: Nearest, opposite: usize) -> (usize, [f64; 3]) {
        self.across(at.facet, opposite, at.foot.l)
    }

    /// The nearest point of the patches that meet, as long as there is a nearer one.
    fn through_boundaries(&self, x: [f64; 3], (first, start): (usize, [f64; 3])) -> Nearest {
        let mut best = Nearest {
            facet: first,
            foot: self.patches[first].closest(x, start),
        };
        let mut seen = vec![first];
        while seen.len() < WALK {
            let before = best;
            let mut look = |facet: usize| {
                if seen.contains(&facet) {
                    return;
                }
                seen.push(facet);
                let foot = self.patches[facet].closest(x, [1.0 / 3.0; 3]);
                // Facets that share the point tell the same distance but for rounding.
                let is_nearer = foot.distance < best.foot.distance * (1.0 - 1e-14);
                let is_better = foot.part == Part::Inside && foot.distance <= best.foot.distance;
                if is_nearer || is_better {
                    best = Nearest { facet, foot };
                }
            };
            match before.foot.part {
                Part::Inside => (),
                Part::Edge(opposite) => look(self.facets.across[before.facet][opposite] as usize),
                Part::Corner(corner) => {
                    let around = self.facets.around(before.facet, corner);
                    around.skip(1).take(MOST_AROUND).for_each(look);
                }
            }
            if best.foot.distance >= before.foot.distance {
                break;
            }
        }
        best
    }
}

/// Place of the least number.
fn least(l: [f64; 3]) -> usize {
    let by_size = |a: &usize, b: &usize| l[*a].total_cmp(&l[*b]);
    (0..3).min_by(by_size).unwrap_or_default()
}
