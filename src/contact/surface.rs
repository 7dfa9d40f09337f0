//! The faces of the body that may touch one obstacle.

use std::f64::consts::TAU;

use crate::assembly::load::facet_measure;
use crate::geometry::vector3::{add, cross, norm, normalised, sub};
use crate::mesh::Mesh;
use crate::space::TaylorHood;

/// One face (segment in 2D).
#[derive(Clone, Debug)]
pub struct ContactFace {
    /// Mesh vertices.
    pub corners: Vec<u32>,
    /// Multiplier of each corner, counted within the surface.
    pub multipliers: Vec<u32>,
    /// Displacement nodes: corners, then edges.
    pub nodes: Vec<u32>,
    /// Area (length in 2D, the area of its full turn about an axis), undeformed,
    /// non-dimensional.
    pub area: f64,
    /// Radii of the ends of a segment that is turned about the axis x = 0.
    pub radii: Option<[f64; 2]>,
}

impl ContactFace {
    /// Area per weight of a rule at `hats`.
    pub fn area_at(&self, hats: &[f64]) -> f64 {
        match self.radii {
            None => self.area,
            Some([a, b]) => self.area * (hats[0] * a + hats[1] * b) / (0.5 * (a + b)),
        }
    }
}

/// The candidate surface of one obstacle.
#[derive(Clone, Debug)]
pub struct ContactSurface {
    /// Mesh vertices that carry a multiplier, ascending.
    pub vertices: Vec<u32>,
    /// Faces.
    pub faces: Vec<ContactFace>,
    /// int phi_i dS `[vertices]`.
    pub weights: Vec<f64>,
}

impl ContactSurface {
    /// The surface made of `facets` (vertex lists).
    pub fn new(mesh: &Mesh, space: &TaylorHood, scale: f64, facets: &[Vec<u32>]) -> Self {
        let mut vertices: Vec<u32> = facets.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut weights = vec![0.0; vertices.len()];
        let faces = facets
            .iter()
            .map(|corners| {
                let (area, _) = facet_measure(mesh, corners, scale);
                let multipliers: Vec<u32> = corners
                    .iter()
                    .map(|&v| vertices.partition_point(|&other| other < v) as u32)
                    .collect();
                for &multiplier in &multipliers {
                    weights[multiplier as usize] += area / corners.len() as f64;
                }
                ContactFace {
                    nodes: space.facet_nodes(corners),
                    corners: corners.clone(),
                    multipliers,
                    area,
                    radii: None,
                }
            })
            .collect();
        Self {
            vertices,
            faces,
            weights,
        }
    }

    /// The surface that `facets` (segments) sweep about the axis x = 0.
    pub fn about_axis(mesh: &Mesh, space: &TaylorHood, scale: f64, facets: &[Vec<u32>]) -> Self {
        let mut surface = Self::new(mesh, space, scale, facets);
        surface.weights.fill(0.0);
        for face in &mut surface.faces {
            let radius = |end: usize| scale * mesh.coordinates()[face.corners[end] as usize][0];
            let [a, b] = [radius(0), radius(1)];
            let way = TAU * face.area;
            for (&multiplier, mean) in face.multipliers.iter().zip([2.0 * a + b, a + 2.0 * b]) {
                surface.weights[multiplier as usize] += way * mean / 6.0;
            }
            face.area = way * 0.5 * (a + b);
            face.radii = Some([a, b]);
        }
        surface
    }

    /// Number of multipliers.
    pub fn multipliers(&self) -> usize {
        self.vertices.len()
    }
}

/// Unit normals at `vertices` (ascending; others are left out) of the surface made
/// of `facets`, whose vertices are at `position`, coordinates near one: means by
/// area. Where both sides of a thin body are candidates, that of one facet.
pub fn vertex_normals<'a>(
    position: impl Fn(u32) -> [f64; 3],
    facets: impl Iterator<Item = &'a [u32]>,
    vertices: &[u32],
) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; vertices.len()];
    let mut anyone = sums.clone();
    for facet in facets {
        let point = |corner: usize| position(facet[corner]);
        let first = sub(point(1), point(0));
        let normal = match facet.len() {
            2 => [first[1], -first[0], 0.0],
            _ => cross(first, sub(point(2), point(0))),
        };
        for vertex in facet {
            if let Ok(index) = vertices.binary_search(vertex) {
                sums[index] = add(sums[index], normal);
                anyone[index] = normal;
            }
        }
    }
    let unit = |(sum, one): ([f64; 3], [f64; 3])| {
        let mean = normalised(sum).filter(|_| norm(sum) > 1e-3 * norm(one));
        mean.or_else(|| normalised(one)).unwrap_or_default()
    };
    sums.into_iter().zip(anyone).map(unit).collect()
}
