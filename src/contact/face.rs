//! One face of a contact surface: a triangle, or a segment in the plane.
//!
//! Corners are in the order that turns the normal out of the body; displacement nodes are
//! the corners, then the midpoints of the edges (0,1), (0,2), (1,2). Functions of the
//! pressure belong to the first nodes: the corners for hats, all nodes for quadratic ones. Areas and
//! points are those of the undeformed, scaled body, and of the flat facet; where edges
//! have offsets the true surface stands beside it.

use crate::mesh::CurvedFacet;

/// One candidate face.
#[derive(Clone, Debug)]
pub struct ContactFace {
    /// Mesh vertices of the face: 3 in space, 2 in the plane, in the order that turns
    /// the normal outwards.
    pub corners: Vec<u32>,
    /// Number of each function of the basis among those of the surface.
    pub functions: Vec<u32>,
    /// Displacement nodes of the face: its corners, then the midpoints of its edges.
    pub nodes: Vec<u32>,
    /// Area (length in 2D, the area of its full turn about an axis), undeformed,
    /// non-dimensional.
    pub area: f64,
    /// Radii of the ends of a segment that is turned about the axis x = 0.
    pub radii: Option<[f64; 2]>,
    /// Area (length in 2D) of the face itself, without any turn.
    pub flat_area: f64,
    /// A point of the undeformed face, non-dimensional `[3]`.
    pub point: [f64; 3],
    /// Unit normal of the undeformed face, to the side that the order of its corners
    /// gives `[3]`.
    pub normal: [f64; 3],
    /// The true surface over the facet; none where all its edges are lines.
    pub curve: Option<Box<CurvedFacet>>,
}

impl ContactFace {
    /// Area per weight of a rule at the barycentric coordinates `l` `[corners]`.
    pub fn area_at(&self, l: &[f64]) -> f64 {
        if let Some(curve) = &self.curve {
            return curve.area_at(l, self.radii.is_some());
        }
        match self.radii {
            None => self.area,
            Some([a, b]) => self.area * (l[0] * a + l[1] * b) / (0.5 * (a + b)),
        }
    }
}
