//! Integrals of the functions of the points of friction over the surface:
//!
//! ```text
//! T_ik = int phi_i N_k da,   w_i = int phi_i da,   X_i = int phi_i X da
//! ```
//!
//! over the undeformed surface of a linear body, where they are made once, and over the
//! deformed one of a body of finite strain, where they move with it. Shapes `[points, nodes]`,
//! `[points]`, `[points][3]`, non-dimensional. Cost: four passes over the faces.

use crate::contact::gap::{Deformed, evaluate_gaps, linearise};
use crate::contact::{ContactFace, ContactSurface, Counterpart, Measure, Places};
use crate::geometry::vector3::add;
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder, Workspace};
use crate::obstacle::{Contact, Derivatives};

/// T, w and X of all points.
#[derive(Debug)]
pub(crate) struct Traces {
    /// T `[points, nodes]`.
    pub(super) rows: SparseRows,
    /// w `[points]`, area of the scaled body.
    pub(crate) weights: Vec<f64>,
    /// X `[points][3]`, in units of the scaled body.
    pub(super) places: Vec<[f64; 3]>,
}

impl Traces {
    /// Of the surfaces of all frictional obstacles, in the order of their points.
    pub(super) fn new<'a>(
        body: &Deformed<'_>,
        surfaces: impl Iterator<Item = &'a ContactSurface>,
    ) -> Self {
        let c = body.space.components;
        let mut rows = SparseRowsBuilder::new(body.space.nodes());
        let (mut weights, mut places) = (Vec::new(), Vec::new());
        for surface in surfaces {
            for mut row in rows_of(body, surface) {
                rows.push_row(&mut row);
            }
            let along: Vec<Vec<f64>> = (0..c)
                .map(|axis| evaluate_gaps(body, surface, &Axis(axis)).0)
                .collect();
            let place = |own: usize| {
                std::array::from_fn(|i| along.get(i).map_or(0.0, |place: &Vec<f64>| place[own]))
            };
            places.extend((0..surface.multipliers()).map(place));
            weights.extend(match body.measure {
                Measure::Undeformed => surface.weights.clone(),
                Measure::Deformed => evaluate_gaps(body, surface, &One).0,
            });
        }
        let mut traces = Self {
            rows: rows.finish(),
            weights,
            places,
        };
        if body.measure == Measure::Deformed {
            traces.subtract_motion(c, body.displacement);
        }
        traces
    }

    /// The places of the deformed body are those of X + u.
    fn subtract_motion(&mut self, components: usize, displacement: &[f64]) {
        let moved = self.moved(components, displacement);
        for (place, moved) in self.places.iter_mut().zip(moved) {
            place.iter_mut().zip(moved).for_each(|(x, u)| *x -= u);
        }
    }

    /// int phi_i (X + u) da of all points `[points][3]`.
    pub(crate) fn moments(&self, components: usize, displacement: &[f64]) -> Vec<[f64; 3]> {
        let moved = self.moved(components, displacement).into_iter();
        let points = self.places.iter().zip(moved);
        points.map(|(place, moved)| add(*place, moved)).collect()
    }

    /// int phi_i u da of all points `[points][3]`.
    pub(super) fn moved(&self, components: usize, displacement: &[f64]) -> Vec<[f64; 3]> {
        let mut moved = vec![[0.0; 3]; self.weights.len()];
        let mut work = Workspace::new();
        let mut sums = vec![0.0; moved.len()];
        for i in 0..components {
            let along = displacement.iter().skip(i).step_by(components);
            let along: Vec<f64> = along.copied().collect();
            self.rows.apply(&along, &mut sums, &mut work);
            let points = moved.iter_mut().zip(&sums);
            points.for_each(|(moved, &sum)| moved[i] = sum);
        }
        moved
    }
}

/// int phi_i N_k da of one interface: rows by displacement nodes.
fn rows_of(body: &Deformed<'_>, surface: &ContactSurface) -> Vec<Vec<(u32, f64)>> {
    let c = body.space.components as u32;
    let free = vec![false; body.displacement.len()];
    let rows = linearise(body, surface, &AlongX, &free).rows;
    let nodes = |row: Vec<(u32, f64)>| {
        let along = row.into_iter().filter(|(unknown, _)| unknown % c == 0);
        along
            .map(|(unknown, value)| (unknown / c, -value))
            .collect()
    };
    rows.into_iter().map(nodes).collect()
}

/// A coordinate as a distance, by which integrals of places are those of gaps.
struct Axis(usize);

impl Counterpart for Axis {
    fn probe_on(&self, _: &ContactFace, points: Places<'_>, _: Derivatives, out: &mut [Contact]) {
        for (contact, point) in out.iter_mut().zip(points.deformed) {
            contact.distance = point[self.0];
        }
    }
}

/// One as a distance, by which areas are integrals of gaps.
struct One;

impl Counterpart for One {
    fn probe_on(&self, _: &ContactFace, _: Places<'_>, _: Derivatives, out: &mut [Contact]) {
        out.iter_mut().for_each(|contact| contact.distance = 1.0);
    }
}

/// No distance, so that rows hold no change of area, and the normal along x.
struct AlongX;

impl Counterpart for AlongX {
    fn probe_on(&self, _: &ContactFace, _: Places<'_>, _: Derivatives, out: &mut [Contact]) {
        for contact in out {
            (contact.distance, contact.normal) = (0.0, [1.0, 0.0, 0.0]);
        }
    }
}
