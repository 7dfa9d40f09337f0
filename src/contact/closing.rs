//! What the edge of contact makes of a goal, where it runs through faces:
//!
//! ```text
//! t = int over d < 0 of (l n . r + m d) da        on a face with closed and open functions
//! ```
//!
//! Contact ends where functions end, not where it does: under a tool's edge, or where a smooth one
//! lifts off, a face penetrates (d < 0) that would be in contact whole, and its answer r to the
//! goal goes on where contact would hold it (n . r = 0). l and m are the pressures of state and
//! dual solution, there the means of those that hold. The rest of both products is zero: closed
//! functions see neither d nor n . r in the mean. With friction l n is the traction as a whole: where
//! points slip its work is what is zero in the mean. Non-dimensional. Cost: one probe a point of the
//! rule.

use super::area_change::WHOLE;
use super::counterpart::Counterpart;
use super::deformed::{Deformed, FacePoints, Table};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::geometry::vector3::{add, dot, scale};
use crate::obstacle::Derivatives;

/// A state and a dual solution on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Closing<'a> {
    /// Share of each function that is closed `[functions]`.
    pub closed: &'a [f64],
    /// Coefficients of l `[functions]`.
    pub pressure: &'a [f64],
    /// Coefficients of the tractions of friction `[functions]`; empty without.
    pub traction: &'a [[f64; 3]],
    /// Coefficients of m `[functions]`.
    pub dual: &'a [f64],
    /// Hierarchical r `[displacement]`.
    pub motion: &'a [f64],
}

/// t of each face, zero where contact does not end inside it `[faces]`.
pub fn closing<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    at: Closing<'_>,
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    let components = body.space.components;
    body.on_faces(&table, &surface.faces, 1, |points, face, sum| {
        let means = at.means(face);
        if let Some([pressure, dual]) = means {
            let traction = at.mean_traction(face);
            points.probe(counterpart, face, Derivatives::Normal);
            for (point, contact) in points.contacts.iter().enumerate() {
                if contact.distance < 0.0 {
                    let motion = at.motion_at(points, face, (point, components));
                    let work = pressure * dot(contact.normal, motion) + dot(traction, motion);
                    sum[0] += points.weights[point] * (work + dual * contact.distance);
                }
            }
        }
    })
}

impl Closing<'_> {
    /// Means of l and m over the closed functions of a face; none where all are, or none is.
    fn means(&self, face: &ContactFace) -> Option<[f64; 2]> {
        let own = face.functions.iter().map(|&k| k as usize);
        let closed = own.filter(|&k| self.closed[k] > WHOLE);
        let (mut sums, mut count) = ([0.0; 2], 0);
        for k in closed {
            sums[0] += self.pressure[k];
            sums[1] += self.dual[k];
            count += 1;
        }
        let is_edge = count > 0 && count < face.functions.len();
        is_edge.then(|| sums.map(|sum| sum / count as f64))
    }

    /// Mean of the tractions over the closed functions of a face, of which there are some.
    fn mean_traction(&self, face: &ContactFace) -> [f64; 3] {
        if self.traction.is_empty() {
            return [0.0; 3];
        }
        let own = face.functions.iter().map(|&k| k as usize);
        let closed = own.filter(|&k| self.closed[k] > WHOLE);
        let (sum, count) = closed.fold(([0.0; 3], 0), |(sum, count), k| {
            (add(sum, self.traction[k]), count + 1)
        });
        scale(1.0 / f64::from(count.max(1)), sum)
    }

    /// r at a point of a face.
    fn motion_at(
        &self,
        points: &FacePoints<'_>,
        face: &ContactFace,
        (point, components): (usize, usize),
    ) -> [f64; 3] {
        let mut motion = [0.0; 3];
        let shapes = points.table.shapes(point);
        for (&node, shape) in face.nodes.iter().zip(shapes) {
            let own = self.motion[node as usize * components..].iter();
            for (sum, value) in motion.iter_mut().zip(own.take(components)) {
                *sum += shape * value;
            }
        }
        motion
    }
}
