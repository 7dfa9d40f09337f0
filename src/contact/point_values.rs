//! What fields make at the points of a contact surface: m d + l n . v, with the distance d, the
//! normal n, pressures l, dual pressures m and a motion v, `[faces, points]`. Non-dimensional. Cost:
//! one probe a point of the rule.

use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::geometry::vector3::dot;
use crate::obstacle::Derivatives;

/// Fields on a surface.
#[derive(Clone, Copy, Debug)]
pub struct FaceFields<'a> {
    /// Coefficients of l `[functions]`.
    pub pressure: &'a [f64],
    /// Coefficients of m `[functions]`.
    pub dual: &'a [f64],
    /// Hierarchical v `[displacement]`.
    pub motion: &'a [f64],
}

/// m d + l n . v at all points of the rule `[faces, points]`.
pub fn values_at_points<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    at: FaceFields<'_>,
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    let components = body.space.components;
    body.on_faces(
        &table,
        &surface.faces,
        table.points(),
        |points, face, values| {
            points.probe(counterpart, face, Derivatives::Normal);
            for (point, value) in values.iter_mut().enumerate() {
                let contact = &points.contacts[point];
                let motion = points.field_at(face, (point, components), at.motion);
                let pressure = points.pressure(face, point, at.pressure);
                let dual = points.pressure(face, point, at.dual);
                *value = dual * contact.distance + pressure * dot(contact.normal, motion);
            }
        },
    )
}

impl FacePoints<'_> {
    /// A hierarchical field `[displacement]` at a point of a face.
    pub(super) fn field_at(
        &self,
        face: &ContactFace,
        (point, components): (usize, usize),
        field: &[f64],
    ) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let shapes = self.table.shapes(point);
        for (&node, shape) in face.nodes.iter().zip(shapes) {
            let own = field[node as usize * components..].iter();
            for (sum, value) in sum.iter_mut().zip(own.take(components)) {
                *sum += shape * value;
            }
        }
        sum
    }
}
