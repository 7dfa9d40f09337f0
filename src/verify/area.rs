//! The deformed area at a point of a face, from its tangents:
//!
//! ```text
//! a = |x_s x x_t| / 2 in space, |x_s| in the plane, 2 pi x_1 |x_s| about the axis
//! da = f_s . dx_s + f_t . dx_t + f . dx,   f_s = x_t x e, f_t = e x x_s, f along the radius
//! ```
//!
//! e the unit normal; in the caller's units. A linear body has the undeformed area, which does
//! not change.

use std::f64::consts::TAU;

use super::contact::Faces;
use super::shapes;
use crate::contact::ContactFace;
use crate::geometry::vector3::{add, cross, norm, scale};
use crate::scene::SceneKind;

/// a and the forces by which it changes.
#[derive(Default)]
pub(super) struct Area {
    /// a.
    pub(super) size: f64,
    /// f_s, f_t.
    along: [[f64; 3]; 2],
    /// f.
    radial: [f64; 3],
}

/// Slopes of the hats along s and t.
const HATS: [[[f64; 3]; 3]; 2] = [
    [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]],
    [[-1.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
];

impl Faces<'_, '_> {
    /// The deformed area at the point `l` of a face, whose radius is that of the point there.
    pub(super) fn area(&self, face: &ContactFace, l: &[f64], radius: f64) -> Area {
        let tangents = self.tangents(face, l);
        let (first, second, factor) = match l.len() {
            2 => (tangents[0], [0.0, 0.0, 1.0], 1.0),
            _ => (tangents[0], tangents[1], 0.5),
        };
        let turn = match self.model.plan.problem.resolved.kind {
            SceneKind::Axisymmetric => TAU,
            SceneKind::Solid | SceneKind::PlaneStrain | SceneKind::PlaneStress => 0.0,
        };
        let way = if turn > 0.0 { turn * radius } else { 1.0 };
        let vector = cross(first, second);
        let length = norm(vector);
        let unit = scale(1.0 / length, vector);
        Area {
            size: factor * way * length,
            along: [
                scale(factor * way, cross(second, unit)),
                scale(factor * way, cross(unit, first)),
            ],
            radial: [turn * length, 0.0, 0.0],
        }
    }

    /// Adds `factor` da/dx to the forces on the nodes of a face.
    pub(super) fn add_change(
        &self,
        face: &ContactFace,
        (l, area, factor): (&[f64], &Area, f64),
        force: &mut [[f64; 3]],
    ) {
        let (values, slopes) = shapes(l, slopes_of_hats(l), self.pairs);
        let [along, across] = area.along.map(|own| scale(factor, own));
        let radial = scale(factor, area.radial);
        for (&node, (value, slope)) in face.nodes.iter().zip(values.iter().zip(&slopes)) {
            let own = &mut force[node as usize];
            *own = add(*own, scale(slope[0], along));
            *own = add(*own, add(scale(slope[1], across), scale(*value, radial)));
        }
    }

    /// x_s and x_t at a point of a deformed face.
    fn tangents(&self, face: &ContactFace, l: &[f64]) -> [[f64; 3]; 2] {
        let units = &self.model.plan.problem.units;
        let unit = units.coordinate_scale * units.length;
        let (_, slopes) = shapes(l, slopes_of_hats(l), self.pairs);
        let edges = &slopes[face.corners.len()..];
        [0, 1].map(|axis| {
            let mut tangent = [0.0; 3];
            for (&vertex, hat) in face.corners.iter().zip(slopes_of_hats(l)) {
                let corner = self.model.mesh.coordinates()[vertex as usize];
                tangent = add(tangent, scale(hat[axis] * unit, corner));
            }
            for (&node, slope) in face.nodes.iter().zip(&slopes) {
                tangent = add(tangent, scale(slope[axis], self.nodal[node as usize]));
            }
            let offsets = face.curve.iter().flat_map(|curve| curve.offsets);
            let bent = edges.iter().zip(offsets);
            bent.fold(tangent, |sum, (slope, offset)| {
                add(sum, scale(slope[axis] * units.length, offset))
            })
        })
    }
}

fn slopes_of_hats(l: &[f64]) -> &'static [[f64; 3]] {
    &HATS[usize::from(l.len() > 2)][..l.len()]
}
