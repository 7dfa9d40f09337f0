//! Weighted gaps, their first derivative (the coupling C = -dg/du) and the
//! curvature term of the Lagrangian, by one rule on the undeformed faces.
//!
//! Cost: (rule points) * (faces) distance evaluations.

use super::surface::{ContactFace, ContactSurface};
use crate::assembly::load::{position, shape_values};
use crate::element::quadrature::Rule;
use crate::linalg::{SparseRows, SparseRowsBuilder};
use crate::mesh::Mesh;
use crate::obstacle::Obstacle;
use crate::space::TaylorHood;

/// What every contact integral reads.
#[derive(Clone, Copy)]
pub struct Deformed<'a> {
    /// Mesh.
    pub mesh: &'a Mesh,
    /// Multiplies the coordinates.
    pub scale: f64,
    /// Numbering.
    pub space: &'a TaylorHood,
    /// Hierarchical displacement.
    pub displacement: &'a [f64],
    /// Rule on a face.
    pub rule: &'a Rule,
}

/// One point of the rule on a deformed face.
pub struct SurfacePoint {
    /// Weight times area.
    pub weight: f64,
    /// P1 values at the corners.
    pub hats: Vec<f64>,
    /// P2 hierarchical values at the face's nodes.
    pub shapes: Vec<f64>,
    /// x + u.
    pub deformed: [f64; 3],
}

impl Deformed<'_> {
    /// The rule's points on `face`.
    pub fn points<'b>(&'b self, face: &'b ContactFace) -> impl Iterator<Item = SurfacePoint> + 'b {
        self.rule
            .points
            .iter()
            .zip(&self.rule.weights)
            .map(move |(point, weight)| {
                let hats = point[..face.corners.len()].to_vec();
                let shapes = shape_values(&hats);
                let mut deformed = position(self.mesh, self.scale, &face.corners, &hats);
                let c = self.space.components;
                for (&node, shape) in face.nodes.iter().zip(&shapes) {
                    for i in 0..c {
                        deformed[i] += shape * self.displacement[node as usize * c + i];
                    }
                }
                SurfacePoint {
                    weight: weight * face.area_at(&hats),
                    hats,
                    shapes,
                    deformed,
                }
            })
    }
}

/// Gap and coupling of one surface.
#[derive(Clone, Debug, Default)]
pub struct Linearisation {
    /// Weighted gap `[multipliers]`.
    pub gap: Vec<f64>,
    /// Rows of C = -dg/du, held columns left out `[multipliers]`, unsorted.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// Deepest penetration at a point of the rule.
    pub max_penetration: f64,
}

/// Weighted gaps only; also the deepest penetration.
pub fn evaluate_gaps(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    obstacle: &dyn Obstacle,
) -> (Vec<f64>, f64) {
    let mut gap = vec![0.0; surface.multipliers()];
    let mut deepest: f64 = 0.0;
    for face in &surface.faces {
        for point in body.points(face) {
            let distance = obstacle.distance(point.deformed).distance;
            deepest = deepest.max(-distance);
            for (&multiplier, hat) in face.multipliers.iter().zip(&point.hats) {
                gap[multiplier as usize] += point.weight * hat * distance;
            }
        }
    }
    (gap, deepest)
}

/// Gaps and coupling; `held[k]` says that unknown k is prescribed.
pub fn linearise(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    obstacle: &dyn Obstacle,
    held: &[bool],
) -> Linearisation {
    let c = body.space.components;
    let mut out = Linearisation {
        gap: vec![0.0; surface.multipliers()],
        rows: vec![Vec::new(); surface.multipliers()],
        max_penetration: 0.0,
    };
    for face in &surface.faces {
        let mut couplings = vec![[0.0; 3]; face.corners.len() * face.nodes.len()];
        for point in body.points(face) {
            let contact = obstacle.distance(point.deformed);
            out.max_penetration = out.max_penetration.max(-contact.distance);
            for (corner, hat) in point.hats.iter().enumerate() {
                let weight = point.weight * hat;
                out.gap[face.multipliers[corner] as usize] += weight * contact.distance;
                for (node, shape) in point.shapes.iter().enumerate() {
                    let entry = &mut couplings[corner * face.nodes.len() + node];
                    for i in 0..c {
                        entry[i] -= weight * shape * contact.normal[i];
                    }
                }
            }
        }
        for (corner, &multiplier) in face.multipliers.iter().enumerate() {
            let row = &mut out.rows[multiplier as usize];
            for (slot, &node) in face.nodes.iter().enumerate() {
                for i in 0..c {
                    let unknown = node as usize * c + i;
                    if !held[unknown] {
                        let value = couplings[corner * face.nodes.len() + slot][i];
                        row.push((unknown as u32, value));
                    }
                }
            }
        }
    }
    out
}

/// int lambda (Hessian of d) psi_k psi_l: what the contact pressure takes off
/// the stiffness `[unknowns, unknowns]`, held rows and columns left out.
pub fn curvature(
    body: &Deformed<'_>,
    surfaces: &[(&ContactSurface, &dyn Obstacle, &[f64])],
    held: &[bool],
) -> SparseRows {
    let unknowns = body.space.displacement_unknowns();
    let mut rows: std::collections::BTreeMap<u32, Vec<(u32, f64)>> = Default::default();
    for &(surface, obstacle, pressure) in surfaces {
        for face in &surface.faces {
            let under_pressure = face
                .multipliers
                .iter()
                .any(|&m| pressure[m as usize] != 0.0);
            if under_pressure {
                add_face_curvature(body, face, obstacle, pressure, held, &mut rows);
            }
        }
    }
    let mut builder = SparseRowsBuilder::new(unknowns);
    for unknown in 0..unknowns as u32 {
        match rows.get_mut(&unknown) {
            Some(entries) => builder.push_row(entries),
            None => builder.push_row(&mut []),
        }
    }
    builder.finish()
}

fn add_face_curvature(
    body: &Deformed<'_>,
    face: &ContactFace,
    obstacle: &dyn Obstacle,
    pressure: &[f64],
    held: &[bool],
    rows: &mut std::collections::BTreeMap<u32, Vec<(u32, f64)>>,
) {
    let c = body.space.components;
    let n = face.nodes.len();
    let mut blocks = vec![[[0.0; 3]; 3]; n * n];
    for point in body.points(face) {
        let hessian = obstacle.distance(point.deformed).curvature;
        let at_corners = face.multipliers.iter().zip(&point.hats);
        let local: f64 = at_corners.map(|(&m, hat)| hat * pressure[m as usize]).sum();
        for (k, a) in point.shapes.iter().enumerate() {
            for (l, b) in point.shapes.iter().enumerate() {
                let factor = point.weight * local * a * b;
                for i in 0..c {
                    for j in 0..c {
                        blocks[k * n + l][i][j] += factor * hessian[i][j];
                    }
                }
            }
        }
    }
    for (k, &row_node) in face.nodes.iter().enumerate() {
        for (l, &column_node) in face.nodes.iter().enumerate() {
            for i in 0..c {
                for j in 0..c {
                    let (row, column) = (row_node as usize * c + i, column_node as usize * c + j);
                    if !held[row] && !held[column] {
                        let entries = rows.entry(row as u32).or_default();
                        entries.push((column as u32, blocks[k * n + l][i][j]));
                    }
                }
            }
        }
    }
}
