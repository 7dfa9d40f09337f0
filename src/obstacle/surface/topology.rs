//! Which facets meet where.

use super::SurfaceError;
use super::checks;
use super::rings::{self, Rings, sorted_by_vertex};
use crate::parallel;

/// Ends of the edge opposite a corner, in the facet's direction.
pub(super) fn edge(corners: [u32; 3], opposite: usize) -> (u32, u32) {
    (corners[(opposite + 1) % 3], corners[(opposite + 2) % 3])
}

/// Facets by their corners, with their neighbours.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facets {
    /// Vertices of each facet.
    pub(super) corners: Vec<[u32; 3]>,
    /// The facet across the edge opposite each corner.
    pub(super) across: Vec<[u32; 3]>,
}

/// An edge of a facet: its vertices in ascending order, and where it is from.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    ends: (u32, u32),
    /// Whether the facet goes from the greater vertex to the less.
    falls: bool,
    facet: u32,
    opposite: u8,
}

/// A facet that keeps a surface from being closed, less where it is found first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    /// It goes along an edge in the direction of another.
    Orientation(u32, u8),
    /// Nothing lies across an edge.
    Open(u32, u8),
}

/// The facets with their neighbours.
///
/// # Errors
/// A facet that is there twice, else one that keeps the surface from being closed and oriented.
pub(super) fn linked(corners: Vec<[u32; 3]>, vertices: usize) -> Result<Facets, SurfaceError> {
    let found = rings::across(&corners, &Rings::new(&corners, vertices));
    // Two facets with the same corners have each other across every edge.
    let is_twice = |across: &[u32; 3]| across[0] == across[1] && across[1] == across[2];
    match found.filter(|across| !across.iter().any(is_twice)) {
        Some(across) => Ok(Facets { corners, across }),
        None => by_sorting(corners, vertices),
    }
}

/// As [`linked`], whatever is wrong and however many facets meet at a vertex: all edges are
/// sorted, so that the two sides of each lie side by side.
pub(super) fn by_sorting(corners: Vec<[u32; 3]>, vertices: usize) -> Result<Facets, SurfaceError> {
    checks::none_twice(&corners, vertices)?;
    let all = corners.iter().enumerate().flat_map(sides);
    let sides = sorted_by_vertex(all, vertices, |side| side.ends.0);
    let groups = || sides.chunk_by(|a, b| a.ends == b.ends);
    if let Some(fault) = groups().filter_map(fault).min() {
        return Err(named(fault, &corners));
    }
    let mut across = vec![[0; 3]; corners.len()];
    for pair in sides.as_chunks::<2>().0 {
        let [a, b] = pair;
        across[a.facet as usize][usize::from(a.opposite)] = b.facet;
        across[b.facet as usize][usize::from(b.opposite)] = a.facet;
    }
    Ok(Facets { corners, across })
}

fn sides((facet, &corners): (usize, &[u32; 3])) -> impl Iterator<Item = Side> + Clone {
    (0..3_u8).map(move |opposite| {
        let (from, to) = edge(corners, usize::from(opposite));
        Side {
            ends: (from.min(to), from.max(to)),
            facet: facet as u32,
            opposite,
            falls: from > to,
        }
    })
}

/// What is wrong with the facets that share an edge: those in one direction lie side by side.
fn fault(group: &[Side]) -> Option<Fault> {
    let pairs = group
        .windows(2)
        .filter(|pair| pair[0].falls == pair[1].falls);
    let again = pairs.map(|pair| Fault::Orientation(pair[1].facet, pair[1].opposite));
    again.min().or(match group {
        [side] => Some(Fault::Open(side.facet, side.opposite)),
        _ => None,
    })
}

fn named(fault: Fault, corners: &[[u32; 3]]) -> SurfaceError {
    let place = |facet: u32, opposite: u8| {
        let (from, to) = edge(corners[facet as usize], usize::from(opposite));
        (facet as usize, from, to)
    };
    match fault {
        Fault::Orientation(facet, opposite) => {
            let (facet, from, to) = place(facet, opposite);
            SurfaceError::Orientation { facet, from, to }
        }
        Fault::Open(facet, opposite) => {
            let (facet, from, to) = place(facet, opposite);
            SurfaceError::Open { facet, from, to }
        }
    }
}

impl Facets {
    /// Place of `vertex` among the corners of `facet`.
    pub(super) fn corner_of(&self, facet: usize, vertex: u32) -> Option<usize> {
        self.corners[facet]
            .iter()
            .position(|&corner| corner == vertex)
    }

    /// The facets around corner `corner` of `facet`, anticlockwise from it; those that meet
    /// it there only by other facets.
    pub(super) fn around(&self, facet: usize, corner: usize) -> impl Iterator<Item = usize> {
        let vertex = self.corners[facet][corner];
        let after = move |&(at, corner): &(usize, usize)| {
            // The edge from the vertex to the next but one corner leads anticlockwise.
            let next = self.across[at][(corner + 1) % 3] as usize;
            match self.corner_of(next, vertex) {
                Some(corner) if next != facet => Some((next, corner)),
                _ => None,
            }
        };
        let all = std::iter::successors(Some((facet, corner)), after);
        all.take(self.corners.len()).map(|(facet, _)| facet)
    }

    /// The same facets in another order: `order[k]` comes to place k.
    pub(super) fn ordered(&self, order: &[u32]) -> Self {
        let mut places = vec![0; order.len()];
        for (place, &facet) in order.iter().enumerate() {
            places[facet as usize] = place as u32;
        }
        let of = |place: usize| order[place] as usize;
        Self {
            corners: parallel::map(order.len(), 1, &|place| self.corners[of(place)]),
            across: parallel::map(order.len(), 1, &|place| {
                self.across[of(place)].map(|other| places[other as usize])
            }),
        }
    }
}
