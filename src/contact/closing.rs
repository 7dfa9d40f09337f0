//! What the edge of contact makes of a goal:
//!
//! ```text
//! t = int over d < 0 of (l n . r + m d) da                    on a face that contact ends in
//!     int of sum over k of psi_k (l_k n . r + m_k d) da       on a closed face beside one
//! ```
//!
//! Contact ends where functions end, not where it does: under a tool's edge, or where a smooth one
//! lifts off, a face penetrates (d < 0) that would be in contact whole, and its answer r to the
//! goal goes on where contact would hold it (n . r = 0). l and m are the pressures of state and
//! dual solution, there the means of those that hold. Functions k that are closed and go on over a
//! face with open ones see d and n . r as the mean of both faces: of the closed face alone it is not
//! zero. The rest of both products is: closed functions see neither d nor n . r in the mean. With
//! friction l n is the traction as a whole: where points slip its work is what is zero in the mean.
//! Non-dimensional. Cost: one probe a point of the rule.

use super::area_change::WHOLE;
use super::counterpart::Counterpart;
use super::deformed::{Deformed, Table};
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

/// Pressure l, its traction of friction, and dual pressure m at a point.
type Pressures = (f64, [f64; 3], f64);

/// t of each face, zero where contact ends neither inside it nor beside it `[faces]`.
pub fn closing<C: Counterpart + ?Sized>(
    body: &Deformed<'_>,
    surface: &ContactSurface,
    counterpart: &C,
    at: Closing<'_>,
) -> Vec<f64> {
    let table = Table::new(body, surface.basis);
    let components = body.space.components;
    let last = at.last(surface);
    body.on_faces(&table, &surface.faces, 1, |points, face, sum| {
        if !face.functions.iter().any(|&k| last[k as usize]) {
            return;
        }
        let mean = at.mean(face);
        points.probe(counterpart, face, Derivatives::Normal);
        for (point, contact) in points.contacts.iter().enumerate() {
            let pressures = match mean {
                Some(_) if contact.distance >= 0.0 => continue,
                Some(mean) => mean,
                None => at.of_last(face, points.table.values(point), &last),
            };
            let motion = points.field_at(face, (point, components), at.motion);
            let (pressure, traction, dual) = pressures;
            let work = pressure * dot(contact.normal, motion) + dot(traction, motion);
            sum[0] += points.weights[point] * (work + dual * contact.distance);
        }
    })
}

impl Closing<'_> {
    /// Whether a function is closed and goes on over a face with open ones `[functions]`.
    fn last(&self, surface: &ContactSurface) -> Vec<bool> {
        let mut last = vec![false; self.closed.len()];
        for face in &surface.faces {
            let own = || face.functions.iter().map(|&k| k as usize);
            if own().any(|k| !self.is_closed(k)) {
                own().for_each(|k| last[k] = self.is_closed(k));
            }
        }
        last
    }

    fn is_closed(&self, function: usize) -> bool {
        self.closed[function] > WHOLE
    }

    /// Sums of pressures of functions, each with its factor.
    fn sum(&self, functions: impl Iterator<Item = (usize, f64)>) -> Pressures {
        let add_one = |(l, t, m): Pressures, (k, factor): (usize, f64)| {
            let traction = self.traction.get(k).copied().unwrap_or_default();
            let traction = add(t, scale(factor, traction));
            (
                l + factor * self.pressure[k],
                traction,
                m + factor * self.dual[k],
            )
        };
        functions.fold(Pressures::default(), add_one)
    }

    /// Means over the closed functions of a face with open ones; none of other faces.
    fn mean(&self, face: &ContactFace) -> Option<Pressures> {
        let own = face.functions.iter().map(|&k| k as usize);
        let closed: Vec<usize> = own.filter(|&k| self.is_closed(k)).collect();
        let share = 1.0 / closed.len().max(1) as f64;
        let is_open = closed.len() < face.functions.len();
        is_open.then(|| self.sum(closed.into_iter().map(|k| (k, share))))
    }

    /// Pressures of the functions that go on over a face with open ones, where functions have `values`.
    fn of_last(&self, face: &ContactFace, values: &[f64], last: &[bool]) -> Pressures {
        let own = face.functions.iter().map(|&k| k as usize);
        let own = own.zip(values.iter().copied());
        self.sum(own.filter(|(k, _)| last[*k]))
    }
}
