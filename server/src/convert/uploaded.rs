//! Surfaces of tools that have been uploaded, whatever they are given by.

use std::collections::HashMap;
use std::sync::Arc;

use signorini::obstacle::grid::{DistanceGrid, HeightField};
use signorini::obstacle::surface::TriangulatedSurface;

use super::wide;

/// Surfaces that a scene names, by their names.
pub(crate) type SurfacesByName = HashMap<String, Surface>;

/// A surface of a tool.
#[derive(Clone)]
pub(crate) enum Surface {
    Triangulated(Arc<TriangulatedSurface>),
    Heights(Arc<HeightField>),
    Distances(Arc<DistanceGrid>),
}

impl Surface {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        let of_numbers = |numbers: &[f64]| size_of_val(numbers) as u64;
        match self {
            Self::Triangulated(surface) => surface.bytes(),
            Self::Heights(grid) => of_numbers(grid.coefficients()),
            Self::Distances(grid) => of_numbers(grid.coefficients()),
        }
    }

    /// Whether another holds it too.
    pub(crate) fn is_shared(&self) -> bool {
        let holders = match self {
            Self::Triangulated(surface) => Arc::strong_count(surface),
            Self::Heights(grid) => Arc::strong_count(grid),
            Self::Distances(grid) => Arc::strong_count(grid),
        };
        holders > 1
    }

    /// Vertices and facets.
    pub(super) fn counts(&self) -> (usize, usize) {
        match self {
            Self::Triangulated(surface) => (surface.vertices().len(), surface.facets().len()),
            Self::Heights(_) | Self::Distances(_) => (0, 0),
        }
    }

    /// Nodes along the axes of a grid.
    pub(super) fn grid_counts(&self) -> Vec<i64> {
        let counts = match self {
            Self::Triangulated(_) => &[][..],
            Self::Heights(grid) => &grid.lattice().counts[..],
            Self::Distances(grid) => &grid.lattice().counts[..],
        };
        counts.iter().map(|count| wide(*count as u64)).collect()
    }
}
