//! The faces of the body that may touch one obstacle.

use crate::assembly::load::facet_measure;
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
    /// Area (length in 2D), undeformed, non-dimensional.
    pub area: f64,
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
                }
            })
            .collect();
        Self {
            vertices,
            faces,
            weights,
        }
    }

    /// Number of multipliers.
    pub fn multipliers(&self) -> usize {
        self.vertices.len()
    }
}
