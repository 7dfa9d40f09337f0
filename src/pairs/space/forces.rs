//! Forces of a contact on both of its surfaces where these are of one body:
//!
//! ```text
//! f = sum_j Lam_j dG_j/dx   over the vectors of either side
//! ```
//!
//! Pieces know the side of their nodes, even where a node is of both; normals are of the carrier, and so
//! are the nodes that they turn with. Shapes: values `[functions]`. Cost: that of first derivatives.

use super::choice::Piece;
use super::normals::{FanAt, Vector};
use super::pair::Placed;
use super::patch::NODES;
use super::point::OTHER;
use super::sides::SpaceSides;
use crate::contact::Deformed;
use crate::geometry::vector3::{add, scale};
use crate::pairs::surface::PairForce;

/// Forces on nodes by their side, and what normals have.
struct Sided<'a> {
    body: &'a Deformed<'a>,
    force: PairForce,
    normals: Vec<[f64; 3]>,
}

impl Sided<'_> {
    fn add(&mut self, (vector, force): (Vector, [f64; 3]), is_other: bool) {
        match vector {
            Vector::Node(node) => self.force.add(self.body, (node, force), is_other),
            Vector::Normal(normal) => {
                let sum = &mut self.normals[normal as usize];
                *sum = add(*sum, force);
            }
        }
    }

    /// With the forces of normals on the nodes that turn them.
    fn summed(mut self, placed: &Placed<'_>) -> PairForce {
        let skin = &placed.pair.carrier;
        for (number, &force) in self.normals.iter().enumerate() {
            let fan = FanAt::new((skin, &placed.patches, &placed.normals), number);
            for (row, factor) in fan.rows().iter().zip(force) {
                for &(unknown, value) in row {
                    let mut own = [0.0; 3];
                    own[unknown as usize % 3] = factor * value;
                    self.force.add(self.body, (unknown / 3, own), false);
                }
            }
        }
        self.force
    }
}

impl SpaceSides {
    /// Of `pressures` `[functions]`.
    pub(in crate::pairs) fn forces(&self, body: &Deformed<'_>, pressures: &[f64]) -> PairForce {
        let placed = self.placed(body);
        let mut sided = sided(body, &placed);
        for (meeting, gradients) in placed.meetings.iter().zip(placed.gradients()) {
            let factors = self.factors(meeting.face, pressures);
            for (piece, own) in meeting.pieces.iter().zip(gradients) {
                let vectors = placed.vectors(meeting.face, piece).into_iter();
                for (k, vector) in vectors.enumerate() {
                    let force = weighted(factors, |function| own[function][k]);
                    sided.add((vector, force), k >= OTHER);
                }
                self.add_rims((&placed, meeting.face, piece), factors, &mut sided);
            }
        }
        sided.summed(&placed)
    }

    /// What lines beyond rims add.
    fn add_rims(
        &self,
        (placed, face, piece): (&Placed<'_>, usize, &Piece),
        factors: [f64; NODES],
        sided: &mut Sided<'_>,
    ) {
        for point in placed.rim_points(face, piece) {
            let swept = point.swept().into_iter().zip(factors);
            let factor: f64 = swept.map(|(swept, factor)| swept * factor).sum();
            for (k, &(vector, own)) in point.motion.iter().enumerate() {
                sided.add((vector, scale(factor, own)), k >= OTHER);
            }
        }
    }

    /// The same of a linear body, where its gaps were taken.
    pub(in crate::pairs) fn forces_at_rest(
        &self,
        [body, rest]: [&Deformed<'_>; 2],
        pressures: &[f64],
    ) -> PairForce {
        let placed = self.placed(rest);
        let mut sided = sided(body, &placed);
        for (meeting, (_, gradients)) in placed.meetings.iter().zip(placed.at_rest()) {
            let factors = self.factors(meeting.face, pressures);
            for (piece, own) in meeting.pieces.iter().zip(gradients) {
                let vectors = placed.vectors(meeting.face, piece).into_iter();
                for (k, vector) in vectors.enumerate() {
                    if matches!(vector, Vector::Node(_)) {
                        let force = weighted(factors, |function| own[function][k]);
                        sided.add((vector, force), k >= OTHER);
                    }
                }
            }
        }
        sided.force
    }

    fn factors(&self, face: usize, values: &[f64]) -> [f64; NODES] {
        self.functions_of(face).map(|k| values[k as usize])
    }
}

fn sided<'a>(body: &'a Deformed<'_>, placed: &Placed<'_>) -> Sided<'a> {
    Sided {
        body,
        force: PairForce::default(),
        normals: vec![[0.0; 3]; placed.pair.carrier.fans.len()],
    }
}

/// Sum of vectors of functions.
fn weighted(factors: [f64; NODES], of: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    let terms = factors.into_iter().enumerate();
    terms.fold([0.0; 3], |sum, (function, factor)| {
        add(sum, scale(factor, of(function)))
    })
}
