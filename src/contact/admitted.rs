//! An obstacle that lets a body in by a given depth,
//!
//! ```text
//! d + delta,   delta = sum_j delta_j psi_j
//! ```
//!
//! with the functions psi_j of the multipliers: a body that starts inside its obstacle is pushed
//! out by depths that decrease to zero. The gap is measured from where the body is let in to, so
//! that its weight by the deformed area stays one of a gap that nearly closes. delta_j: lengths of
//! the scaled body `[multipliers]`. Cost: some flops a point more than the obstacle.

use super::counterpart::{Counterpart, Places};
use super::face::ContactFace;
use super::surface::ContactSurface;
use crate::element::quadrature::Rule;
use crate::obstacle::{Contact, Derivatives};

/// Depths at the points of a rule.
#[derive(Clone, Debug)]
pub struct AdmittedDepth {
    /// Depth of each function `[functions]`.
    depths: Vec<f64>,
    /// Values of the functions of a face at the points of the rule `[points][functions]`.
    values: Vec<Vec<f64>>,
}

impl AdmittedDepth {
    /// Of the multipliers of `surface` with those `depths`, at the points of `rule`.
    pub fn new(surface: &ContactSurface, rule: &Rule, depths: &[f64]) -> Self {
        let corners = surface.faces.first().map_or(0, |face| face.corners.len());
        let at = |point: &[f64; 4]| {
            let mut values = vec![0.0; surface.basis.functions(corners)];
            surface.basis.values(&point[..corners], &mut values);
            values
        };
        Self {
            depths: surface.shares.spread(depths).into_owned(),
            values: rule.points.iter().map(at).collect(),
        }
    }

    /// Probes `inner` and adds the depths at the points of `face`.
    pub fn probe<C: Counterpart + ?Sized>(
        &self,
        inner: &C,
        (face, points): (&ContactFace, Places<'_>),
        what: Derivatives,
        out: &mut [Contact],
    ) {
        inner.probe_on(face, points, what, out);
        for (contact, values) in out.iter_mut().zip(&self.values) {
            let functions = face.functions.iter().zip(values);
            let depth: f64 = functions
                .map(|(&k, value)| value * self.depths[k as usize])
                .sum();
            contact.distance += depth;
        }
    }
}
