//! Triangulated surfaces of tools: closed, oriented, and smoothed by default.
//!
//! ```text
//! X(l) = sum_i l_i x_i - sum_(i<j) l_i l_j c_ij,   n_i . dX = 0 along the edges at corner i
//! ```
//!
//! Facets are chords of the tool that they came from: between vertices a patch of Nagata (Comput.
//! Aided Geom. Design 22, 2005) is put over each, from normals that are fitted to two rings
//! of vertices and split where facets meet at more than the feature angle. The distance is that
//! of the nearest point of all patches: error h^4, of its normal h^3, where the raw facets have
//! h^2 and h. Across smooth edges patches share their edge curve, their normals differ by as
//! much as normals are wrong. Cost: a search in a tree of boxes and some Newton steps a point.

mod checks;
mod closest;
mod fit;
mod normals;
mod patch;
mod tool;
mod topology;
mod tree;

use std::sync::Arc;

pub use checks::SurfaceError;
pub use tool::Triangulated;

/// A closed triangulated surface, its facets seen from outside anticlockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangulatedSurface {
    vertices: Vec<[f64; 3]>,
    facets: Vec<[u32; 3]>,
    /// The facet across the edge opposite each corner `[facets][3]`.
    across: Vec<[u32; 3]>,
}

impl TriangulatedSurface {
    /// The surface of `facets` (three of `vertices` each, anticlockwise from outside).
    ///
    /// # Errors
    /// The first facet that keeps it from being closed, oriented and without folds.
    pub fn new(vertices: Vec<[f64; 3]>, facets: Vec<[u32; 3]>) -> Result<Self, SurfaceError> {
        checks::facets(&vertices, &facets)?;
        let across = topology::across(&facets)?;
        checks::orientation(&vertices, &facets)?;
        Ok(Self {
            vertices,
            facets,
            across,
        })
    }

    /// Vertices `[vertices][3]`, length.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// Corners of the facets.
    pub fn facets(&self) -> &[[u32; 3]] {
        &self.facets
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let facet = 2 * size_of::<[u32; 3]>();
        (self.vertices.len() * size_of::<[f64; 3]>() + self.facets.len() * facet) as u64
    }

    /// Corners of a facet in space.
    fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        self.facets[facet].map(|vertex| self.vertices[vertex as usize])
    }
}

/// How a surface is used as a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceShape {
    /// The triangulation, in its own lengths.
    pub surface: Arc<TriangulatedSurface>,
    /// Multiplies its coordinates, above zero.
    pub scale: f64,
    /// What lies between its vertices.
    pub between: Between,
}

/// What lies between the vertices of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Between {
    /// The facets themselves.
    Facets,
    /// Patches, split where facets meet at more than this angle, radians.
    Patches(f64),
}

#[cfg(test)]
mod tests;
