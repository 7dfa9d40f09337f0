//! Displacements of several bodies to twice the digits, while an increment is solved:
//!
//! ```text
//! u + r,   r: what rounding has taken off u,   |r| <= eps |u| / 2 after a step
//! w_a = (u_a - u_b) + (r_a - r_b),   b: the first vertex of the body of a
//! ```
//!
//! A body that is carried far has its strains in the last digits of u: by eps |u| E of its moduli E
//! its forces are rounded, beside which those of its contact with a softer one may be nothing. The
//! differences w, of which forces are made, keep all digits of what a translation does not
//! bear. About an axis that holds along it alone. Edges have none to lose: their part of u is that
//! beyond the mean of their ends. Shapes `[displacement]`, non-dimensional. Cost: a pass over the vertices an evaluation.

use std::sync::Arc;

use super::Model;
use crate::linalg::vector::add_scaled;
use crate::plan::pairs::ALIKE;
use crate::scene::SceneKind;
use crate::scene::validate::parts;

/// What rounding has taken off the displacements of vertices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Remainder {
    /// r `[vertices * components]`.
    rounded_off: Vec<f64>,
    /// First vertex of the body of each vertex.
    first: Arc<[u32]>,
    /// Components.
    components: usize,
    /// The first component along which translations cost nothing.
    translates_from: usize,
}

impl Remainder {
    /// Zero, at the begin of an increment; none of linear bodies, without contact between bodies, and where no
    /// material is more than `ALIKE` times as stiff as another.
    pub(crate) fn of(model: &Model<'_>) -> Option<Self> {
        let resolved = &model.plan.problem.resolved;
        let moduli = resolved.materials.iter().map(|one| one.law.shear_modulus);
        let [least, most] = moduli.fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], own| {
            [least.min(own), most.max(own)]
        });
        if !model.is_rubber() || resolved.pairs.is_empty() || most <= ALIKE * least {
            return None;
        }
        let body_of = parts(model.mesh);
        let mut first = vec![u32::MAX; body_of.len()];
        for (vertex, &body) in (0..).zip(&body_of) {
            let own = &mut first[body as usize];
            *own = vertex.min(*own);
        }
        let components = model.prepared.space.components;
        Some(Self {
            rounded_off: vec![0.0; components * body_of.len()],
            first: body_of.iter().map(|&body| first[body as usize]).collect(),
            components,
            translates_from: usize::from(resolved.kind == SceneKind::Axisymmetric),
        })
    }

    /// Adds `length` times `step` to `displacement`, and keeps what that rounds off.
    pub(super) fn add(&mut self, displacement: &mut [f64], length: f64, step: &[f64]) {
        let vertices = self.rounded_off.len();
        let (own, edges) = displacement.split_at_mut(vertices);
        let (moved, at_edges) = step.split_at(vertices);
        for ((value, rest), step) in own.iter_mut().zip(&mut self.rounded_off).zip(moved) {
            let (moved, off) = sum(*value, length * step);
            (*value, *rest) = sum(moved, *rest + off);
        }
        add_scaled(edges, length, at_edges);
    }

    /// w.
    pub(super) fn relative(&self, displacement: &[f64]) -> Vec<f64> {
        let mut out = displacement.to_vec();
        let rows = out.chunks_exact_mut(self.components).zip(&*self.first);
        for (vertex, (own, &first)) in rows.enumerate() {
            for i in self.translates_from..self.components {
                let [here, there] = [vertex, first as usize].map(|one| self.components * one + i);
                let apart = displacement[here] - displacement[there];
                own[i] = apart + (self.rounded_off[here] - self.rounded_off[there]);
            }
        }
        out
    }

    /// Numbers held.
    pub(super) fn len(&self) -> usize {
        self.rounded_off.len()
    }
}

/// a + b as the nearest number and the rest, exactly (Knuth, The Art of Computer Programming 2, 4.2.2).
fn sum(a: f64, b: f64) -> (f64, f64) {
    let nearest = a + b;
    let of_b = nearest - a;
    (nearest, (a - (nearest - of_b)) + (b - of_b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_far_below_the_digits_of_a_carried_body_add_up() {
        let mut remainder = Remainder {
            rounded_off: vec![0.0; 2],
            first: vec![0, 0].into(),
            components: 1,
            translates_from: 0,
        };
        let mut displacement = [0.1, 0.1, 0.0];
        for _ in 0..1000 {
            remainder.add(&mut displacement, 1.0, &[0.25, 0.25, 0.0]);
            remainder.add(&mut displacement, 0.5, &[0.0, 1e-21, 1e-21]);
        }
        let relative = remainder.relative(&displacement);
        for (found, exact) in relative.iter().zip([0.0, 5e-19, 5e-19]) {
            assert!((found - exact).abs() <= 1e-3 * exact, "{found} {exact}");
        }
    }
}
