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
//! much as normals are wrong. Parts that cross, nest or touch are one solid (`parts`); facets
//! that bound nothing are left out (`mend`). Cost: a search in a tree of discs and some Newton steps a point.

mod around;
mod bending;
mod bounding_disc;
mod checks;
mod closest;
mod fit;
mod flats;
mod geometry;
mod mend;
mod normals;
mod parts;
mod patch;
mod rings;
mod tool;
mod topology;
mod tree;
mod triangle;
mod walk;

use std::sync::{Arc, Mutex, PoisonError};

use geometry::Geometry;
use topology::Facets;

use crate::geometry::vector3::{norm, sub};

pub use checks::SurfaceError;
pub use mend::LeftOut;
pub use tool::Triangulated;

/// A closed triangulated surface, its facets seen from outside anticlockwise.
#[derive(Debug)]
pub struct TriangulatedSurface {
    vertices: Vec<[f64; 3]>,
    linked: Facets,
    /// Facets of the solids that lie apart, layer by layer; empty where they are one.
    layers: Vec<Vec<u32>>,
    /// Facets that were given and bound nothing.
    left_out: Option<LeftOut>,
    /// The patches that a tool of it used last, and what is between their vertices: sessions and
    /// plans of one tool make them once.
    made: Mutex<Option<(Interpolation, Arc<Geometry>)>>,
}

impl PartialEq for TriangulatedSurface {
    fn eq(&self, other: &Self) -> bool {
        self.vertices == other.vertices && self.linked == other.linked
    }
}

impl TriangulatedSurface {
    /// The surface of `facets` (three of `vertices` each, anticlockwise from outside).
    ///
    /// Facets that bound nothing are left out ([`Self::left_out`]).
    ///
    /// # Errors
    /// The first facet that keeps it from being closed, oriented and without folds.
    pub fn new(vertices: Vec<[f64; 3]>, facets: Vec<[u32; 3]>) -> Result<Self, SurfaceError> {
        checks::facets(&vertices, &facets)?;
        let (facets, left_out) = mend::with_area(&vertices, facets);
        mend::areas(&vertices, (&facets, left_out))?;
        let (linked, left_out) = match topology::linked(facets.clone(), vertices.len()) {
            Err(SurfaceError::Duplicate { .. }) => {
                let (once, twice) = mend::without_twice(&facets);
                let all = twice.and_then(|twice| LeftOut::and(left_out, twice));
                (topology::linked(once, vertices.len())?, all)
            }
            linked => (linked?, left_out),
        };
        if linked.corners.is_empty() {
            return Err(SurfaceError::Empty);
        }
        checks::orientation(&vertices, &linked.corners)?;
        let layers = parts::layers(&vertices, &linked)?;
        Ok(Self {
            vertices,
            linked,
            layers: if layers.len() > 1 { layers } else { Vec::new() },
            left_out,
            made: Mutex::new(None),
        })
    }

    /// Facets that were given and bound nothing, being without area or there twice.
    pub fn left_out(&self) -> Option<LeftOut> {
        self.left_out
    }

    /// The surfaces of the layers, each with its vertices alone; none where there is one layer.
    fn layers(&self) -> Vec<Self> {
        self.layers.iter().map(|layer| self.part(layer)).collect()
    }

    /// The surface of some facets, which are closed.
    fn part(&self, facets: &[u32]) -> Self {
        let all = facets
            .iter()
            .flat_map(|&facet| self.linked.corners[facet as usize]);
        let mut vertices: Vec<u32> = all.collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |list: &[u32], one: u32| list.partition_point(|other| *other < one) as u32;
        let corners = facets
            .iter()
            .map(|&facet| self.linked.corners[facet as usize]);
        let across = facets
            .iter()
            .map(|&facet| self.linked.across[facet as usize]);
        Self {
            linked: Facets {
                corners: corners
                    .map(|own| own.map(|one| place(&vertices, one)))
                    .collect(),
                across: across
                    .map(|own| own.map(|one| place(facets, one)))
                    .collect(),
            },
            vertices: vertices
                .iter()
                .map(|&one| self.vertices[one as usize])
                .collect(),
            layers: Vec::new(),
            left_out: None,
            made: Mutex::new(None),
        }
    }

    /// Vertices `[vertices][3]`, length.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// Corners of the facets.
    pub fn facets(&self) -> &[[u32; 3]] {
        &self.linked.corners
    }

    /// Bytes held, with the patches of a tool.
    pub fn bytes(&self) -> u64 {
        let facets = self.facets().len();
        let links = 2 * facets * size_of::<[u32; 3]>();
        (self.vertices.len() * size_of::<[f64; 3]>() + links + Geometry::bytes(facets)) as u64
    }

    /// Corners of a facet in space.
    fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        self.linked.corners[facet].map(|vertex| self.vertices[vertex as usize])
    }

    /// Diagonal of the box around it.
    fn diagonal(&self) -> f64 {
        let (low, high) = bounds(self.vertices.iter().copied());
        norm(sub(high, low))
    }

    /// The patches with this between the vertices, made where they are not those made last.
    fn geometry(&self, between: Interpolation) -> Arc<Geometry> {
        let last = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, geometry)) = last().as_ref()
            && *made == between
        {
            return Arc::clone(geometry);
        }
        // Not under the lock: threads that wait for one of the pool's would stop it.
        let geometry = Arc::new(Geometry::new(self, between));
        *last() = Some((between, Arc::clone(&geometry)));
        geometry
    }
}

/// Corners of the box around points.
fn bounds(points: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    points.fold(start, |(low, high), point| {
        (
            std::array::from_fn(|i| low[i].min(point[i])),
            std::array::from_fn(|i| high[i].max(point[i])),
        )
    })
}

/// How a surface is used as a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceShape {
    /// The triangulation, in its own lengths.
    pub surface: Arc<TriangulatedSurface>,
    /// Multiplies its coordinates, above zero.
    pub scale: f64,
    /// What lies between its vertices.
    pub between: Interpolation,
}

/// What lies between the vertices of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interpolation {
    /// The facets themselves.
    Facets,
    /// Patches, split where facets meet at more than this angle, radians.
    Patches(f64),
}

#[cfg(test)]
mod tests;
