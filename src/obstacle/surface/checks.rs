//! What keeps a triangulation from being the surface of a solid, each fault with its facet.

use crate::parallel;
use thiserror::Error;

use super::rings::sorted_by_vertex;
use crate::geometry::vector3::{cross, dot, is_finite, norm, sub};

/// Height of a facet over its longest edge below which it is a line.
const FLAT: f64 = 1e-12;
/// Facets whose volumes a thread adds up.
const PART: usize = 8192;

/// Why a triangulation is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Nothing to press with.
    #[error("has no facets")]
    Empty,
    /// More facets or vertices than indices count.
    #[error("has more than {limit} facets or vertices")]
    TooLarge {
        /// The most.
        limit: u32,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A corner that is no vertex.
    #[error("facet {facet} names vertex {vertex}, there are {count}")]
    NoVertex {
        /// Index of the facet.
        facet: usize,
        /// Its corner.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// Corners on a line.
    #[error("facet {facet} at {at:?} has no area")]
    Degenerate {
        /// Index of the facet.
        facet: usize,
        /// Its first corner.
        at: [f64; 3],
    },
    /// A facet twice.
    #[error("facet {facet} is there twice")]
    Duplicate {
        /// Index of the second.
        facet: usize,
    },
    /// An edge of one facet only.
    #[error(
        "facet {facet} has an open edge from vertex {from} to {to}: the surface is not closed; where corners of a file differ by rounding, a larger `weld` of the shape makes them one vertex (1e-6 of the diagonal unless given)"
    )]
    Open {
        /// Index of the facet.
        facet: usize,
        /// First vertex of the edge.
        from: u32,
        /// Second vertex of the edge.
        to: u32,
    },
    /// An edge that two facets go along in one direction, or more than two facets share.
    #[error(
        "facet {facet} and others share the edge from vertex {from} to {to} in one direction: turn facets around, or part solids that touch there"
    )]
    Orientation {
        /// Index of the facet.
        facet: usize,
        /// First vertex of the edge.
        from: u32,
        /// Second vertex of the edge.
        to: u32,
    },
    /// The outside is within.
    #[error(
        "facet 0 and all others are clockwise from outside: turn them around, or use `inside = true` for a cavity"
    )]
    InsideOut,
    /// The same of a part that lies in no other, of which it could be a hole.
    #[error(
        "facet {facet} and those joined to it are clockwise from outside, and in no other part of which they could be a hole: turn them around"
    )]
    InsideOutPart {
        /// Index of the facet.
        facet: usize,
    },
}

/// Checks each facet for itself.
pub(super) fn facets(vertices: &[[f64; 3]], facets: &[[u32; 3]]) -> Result<(), SurfaceError> {
    let limit = u32::MAX / 3; // Corners are counted in 32 bits.
    if facets.is_empty() {
        return Err(SurfaceError::Empty);
    }
    if facets.len() >= limit as usize || vertices.len() >= limit as usize {
        return Err(SurfaceError::TooLarge { limit });
    }
    if let Some(vertex) = vertices.iter().position(|place| !is_finite(*place)) {
        return Err(SurfaceError::NotFinite { vertex });
    }
    let one = |(index, corners)| one_facet(vertices.len(), index, corners).err();
    match facets.iter().enumerate().find_map(one) {
        Some(fault) => Err(fault),
        None => Ok(()),
    }
}

/// Checks that no two facets have the same corners.
pub(super) fn none_twice(facets: &[[u32; 3]], vertices: usize) -> Result<(), SurfaceError> {
    match duplicate(facets, vertices) {
        Some(facet) => Err(SurfaceError::Duplicate { facet }),
        None => Ok(()),
    }
}

/// The first facet whose vertices are those of one before it.
fn duplicate(facets: &[[u32; 3]], vertices: usize) -> Option<usize> {
    let keyed = |(index, corners): (usize, &[u32; 3])| {
        let mut sorted = *corners;
        sorted.sort_unstable();
        (sorted, index as u32)
    };
    let keys = facets.iter().enumerate().map(keyed);
    let keys = sorted_by_vertex(keys, vertices, |(corners, _)| corners[0]);
    let twice = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    twice.map(|pair| pair[1].1 as usize).min()
}

fn one_facet(count: usize, facet: usize, corners: &[u32; 3]) -> Result<(), SurfaceError> {
    if let Some(&vertex) = corners.iter().find(|vertex| **vertex as usize >= count) {
        return Err(SurfaceError::NoVertex {
            facet,
            vertex,
            count,
        });
    }
    Ok(())
}

/// Whether corners lie on a line.
pub(super) fn is_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    let longest = [sub(b, a), sub(c, b), sub(a, c)].map(norm);
    let longest = longest.into_iter().fold(0.0, f64::max);
    let area = norm(cross(sub(b, a), sub(c, a)));
    // Not a number is no area either.
    !matches!(
        area.partial_cmp(&(FLAT * longest * longest)),
        Some(std::cmp::Ordering::Greater)
    )
}

/// Checks that the volume inside is above zero.
pub(super) fn orientation(vertices: &[[f64; 3]], facets: &[[u32; 3]]) -> Result<(), SurfaceError> {
    let origin = vertices[facets[0][0] as usize];
    let volume = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|vertex| sub(vertices[vertex as usize], origin));
        dot(a, cross(b, c))
    };
    // Parts of a size, so that the sum does not depend on the threads.
    let sums = parallel::map(facets.len().div_ceil(PART), 1, &|k| {
        let part = &facets[k * PART..facets.len().min((k + 1) * PART)];
        part.iter().map(volume).sum::<f64>()
    });
    if sums.iter().sum::<f64>() > 0.0 {
        Ok(())
    } else {
        Err(SurfaceError::InsideOut)
    }
}
