//! A facet whose edges are curved:
//!
//! ```text
//! X(l) = sum L_v X_v + sum 4 L_a L_b o_e,   dS = |X_s x X_t| / 2,   in the plane |X_s|
//! ```
//!
//! Lengths are those of the scaled body. Cost: some 50 flops a point.

use std::f64::consts::TAU;

use super::Mesh;
use crate::geometry::vector3::{add, cross, norm, scale, sub};

/// The offsets of a facet.
#[derive(Clone, Copy, Debug)]
pub struct CurvedFacet {
    /// Positions of the undeformed corners `[3][3]`; the third of a segment is zero.
    pub corners: [[f64; 3]; 3],
    /// Offsets of the middles of the edges (0,1), (0,2), (1,2) `[3][3]`; of a segment the first.
    pub offsets: [[f64; 3]; 3],
}

impl CurvedFacet {
    /// The facet with these vertices of `mesh`, lengths times `factor`; none where all its edges
    /// are lines.
    pub fn of(mesh: &Mesh, factor: f64, vertices: &[u32]) -> Option<Self> {
        if mesh.edge_offsets().is_empty() {
            return None;
        }
        let offset = |a: usize, b: usize| {
            let found = mesh.offset_between(*vertices.get(a)?, *vertices.get(b)?);
            found.map(|offset| scale(factor, offset))
        };
        let found = [offset(0, 1), offset(0, 2), offset(1, 2)];
        let corner = |v: &u32| scale(factor, mesh.coordinates()[*v as usize]);
        found.iter().any(Option::is_some).then(|| Self {
            corners: [0, 1, 2].map(|v| vertices.get(v).map_or([0.0; 3], corner)),
            offsets: found.map(Option::unwrap_or_default),
        })
    }

    /// Undeformed position at the barycentric coordinates `l` `[corners]`.
    pub fn position(&self, l: &[f64]) -> [f64; 3] {
        let mut position = [0.0; 3];
        for (corner, l) in self.corners.iter().zip(l) {
            position = add(position, scale(*l, *corner));
        }
        for (offset, value) in self.offsets.iter().zip(edge_values(l)) {
            position = add(position, scale(value, *offset));
        }
        position
    }

    /// Area (length in 2D) per weight of a rule at `l` times the unit normal, which the order of
    /// the corners gives as that of a flat facet.
    pub fn area_vector(&self, l: &[f64]) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let mut along = [sub(b, a), sub(c, a)];
        for (tangent, slopes) in along.iter_mut().zip(edge_slopes(l)) {
            for (offset, slope) in self.offsets.iter().zip(slopes) {
                *tangent = add(*tangent, scale(slope, *offset));
            }
        }
        match l.len() {
            2 => [along[0][1], -along[0][0], 0.0],
            _ => scale(0.5, cross(along[0], along[1])),
        }
    }

    /// Area per weight of a rule at `l`; `is_turned` about the axis x = 0.
    pub fn area_at(&self, l: &[f64], is_turned: bool) -> f64 {
        let flat = norm(self.area_vector(l));
        if is_turned {
            flat * TAU * self.position(l)[0]
        } else {
            flat
        }
    }
}

/// 4 L_a L_b of the edges (0,1), (0,2), (1,2).
fn edge_values(l: &[f64]) -> [f64; 3] {
    match *l {
        [a, b, c] => [4.0 * a * b, 4.0 * a * c, 4.0 * b * c],
        [a, b] => [4.0 * a * b, 0.0, 0.0],
        _ => [0.0; 3],
    }
}

/// Derivatives of [`edge_values`] along l_1 and l_2.
fn edge_slopes(l: &[f64]) -> [[f64; 3]; 2] {
    match *l {
        [a, b, c] => [
            [4.0 * (a - b), -4.0 * c, 4.0 * c],
            [-4.0 * b, 4.0 * (a - c), 4.0 * b],
        ],
        [a, b] => [[4.0 * (a - b), 0.0, 0.0], [0.0; 3]],
        _ => [[0.0; 3]; 2],
    }
}
