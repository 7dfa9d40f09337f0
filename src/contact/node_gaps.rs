//! Gaps at the nodes of the faces, and the function of them that is linear beside contact:
//!
//! ```text
//! p ~ s^(1/2) inside,   g ~ s^(3/2) outside,   psi = g^(2/3) linear in the distance s from the edge
//! ```
//!
//! where smooth bodies part. Reference: K. L. Johnson, Contact Mechanics (1985), chapter 4. Lengths
//! are those of the scaled body. Cost: one probe a node of each face.

use super::counterpart::Counterpart;
use super::deformed::{Deformed, Table};
use super::surface::ContactSurface;
use crate::element::quadrature::Rule;
use crate::obstacle::Derivatives;

/// Of a node: its distance from the obstacle, then its deformed position `[3]`.
const NUMBERS: usize = 4;

/// Nodes of a face as points of a rule: corners, then middles of edges.
fn nodes_of_a_face(corners: usize) -> Rule {
    let unit =
        |own: usize| -> [f64; 4] { std::array::from_fn(|i| if i == own { 1.0 } else { 0.0 }) };
    let mut points: Vec<[f64; 4]> = (0..corners).map(unit).collect();
    for a in 0..corners {
        let ends = (a + 1..corners).map(|b| (unit(a), unit(b)));
        points.extend(ends.map(|(a, b)| std::array::from_fn(|i| 0.5 * (a[i] + b[i]))));
    }
    let weights = vec![1.0 / points.len() as f64; points.len()];
    Rule { points, weights }
}

/// Gaps and places of the nodes of all faces.
pub(super) struct NodeGaps<'a> {
    /// The surface with the faces.
    pub(super) surface: &'a ContactSurface,
    /// Corners of a face.
    pub(super) corners: usize,
    /// `[faces, nodes, NUMBERS]`.
    numbers: Vec<f64>,
}

impl<'a> NodeGaps<'a> {
    /// Of the faces of `surface` beside what they meet.
    pub(super) fn new<C: Counterpart + ?Sized>(
        body: &Deformed<'_>,
        surface: &'a ContactSurface,
        counterpart: &C,
    ) -> Self {
        let corners = body.space.components;
        let rule = nodes_of_a_face(corners);
        let body = Deformed {
            rule: &rule,
            ..*body
        };
        let table = Table::new(&body, surface.basis);
        let size = NUMBERS * table.points();
        let numbers = body.on_faces(&table, &surface.faces, size, |points, face, numbers| {
            points.probe(counterpart, face, Derivatives::Gap);
            let nodes = points.contacts.iter().zip(&points.deformed);
            for (own, (contact, place)) in numbers.chunks_exact_mut(NUMBERS).zip(nodes) {
                own[0] = contact.distance;
                own[1..].copy_from_slice(place);
            }
        });
        Self {
            surface,
            corners,
            numbers,
        }
    }

    /// Gap and place of a node of a face.
    pub(super) fn node(&self, face: usize, node: usize) -> (f64, [f64; 3]) {
        let nodes = self.corners * (self.corners + 1) / 2;
        let own = &self.numbers[NUMBERS * (face * nodes + node)..][..NUMBERS];
        (own[0], [own[1], own[2], own[3]])
    }

    /// psi of a node of a face.
    pub(super) fn psi(&self, face: usize, node: usize) -> f64 {
        self.node(face, node).0.max(0.0).cbrt().powi(2)
    }
}
