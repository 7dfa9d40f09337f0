//! The nearest facet, by a tree of boxes of `parry3d`, which stays in this file.

use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TrianglePointLocation};

use super::TriangulatedSurface;

/// Facets in a tree of boxes.
#[derive(Clone)]
pub(super) struct FacetTree {
    mesh: Option<TriMesh>,
}

impl std::fmt::Debug for FacetTree {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("FacetTree")
    }
}

impl FacetTree {
    pub(super) fn new(surface: &TriangulatedSurface, scale: f64) -> Self {
        let vertex = |place: &[f64; 3]| {
            let [x, y, z] = place.map(|x| scale * x);
            Vector::new(x, y, z)
        };
        let vertices = surface.vertices.iter().map(vertex).collect();
        Self {
            // Refused without facets only, which a surface has.
            mesh: TriMesh::new(vertices, surface.facets.clone()).ok(),
        }
    }

    /// The facet nearest to a point, and the barycentric coordinates of its nearest point.
    pub(super) fn nearest(&self, [x, y, z]: [f64; 3]) -> (usize, [f64; 3]) {
        let none = (0, [1.0 / 3.0; 3]);
        let Some(mesh) = &self.mesh else {
            return none;
        };
        let point = Vector::new(x, y, z);
        let (_, (facet, location)) = mesh.project_local_point_and_get_location(point, false);
        (facet as usize, barycentric(location).unwrap_or(none.1))
    }
}

fn barycentric(location: TrianglePointLocation) -> Option<[f64; 3]> {
    location.barycentric_coordinates()
}
