//! Which facets meet where.

use std::collections::HashMap;

use super::{SurfaceError, TriangulatedSurface};

/// Ends of the edge opposite a corner, in the facet's direction.
pub(super) fn edge(corners: [u32; 3], opposite: usize) -> (u32, u32) {
    (corners[(opposite + 1) % 3], corners[(opposite + 2) % 3])
}

/// The facet across the edge opposite each corner.
pub(super) fn across(facets: &[[u32; 3]]) -> Result<Vec<[u32; 3]>, SurfaceError> {
    let mut owners = HashMap::with_capacity(3 * facets.len());
    for (facet, &corners) in facets.iter().enumerate() {
        for opposite in 0..3 {
            let (from, to) = edge(corners, opposite);
            if owners.insert((from, to), facet as u32).is_some() {
                return Err(SurfaceError::Orientation { facet, from, to });
            }
        }
    }
    let of_facet = |(facet, &corners): (usize, &[u32; 3])| {
        let mut neighbours = [0; 3];
        for (opposite, neighbour) in neighbours.iter_mut().enumerate() {
            let (from, to) = edge(corners, opposite);
            *neighbour = *owners
                .get(&(to, from))
                .ok_or(SurfaceError::Open { facet, from, to })?;
        }
        Ok(neighbours)
    };
    facets.iter().enumerate().map(of_facet).collect()
}

impl TriangulatedSurface {
    /// Place of `vertex` among the corners of `facet`.
    pub(super) fn corner_of(&self, facet: usize, vertex: u32) -> Option<usize> {
        self.facets[facet]
            .iter()
            .position(|&corner| corner == vertex)
    }

    /// The facets around corner `corner` of `facet`, anticlockwise from it; those that meet
    /// it there only by other facets.
    pub(super) fn around(&self, facet: usize, corner: usize) -> Vec<usize> {
        let vertex = self.facets[facet][corner];
        let mut all = vec![facet];
        let mut at = (facet, corner);
        // The edge from the vertex to the next but one corner leads anticlockwise.
        for _ in 0..self.facets.len() {
            let next = self.across[at.0][(at.1 + 1) % 3] as usize;
            match self.corner_of(next, vertex) {
                Some(corner) if next != facet => at = (next, corner),
                _ => break,
            }
            all.push(next);
        }
        all
    }
}
