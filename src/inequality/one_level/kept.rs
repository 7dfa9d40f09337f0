//! Krylov directions kept between programs and faces: what they learned about A and B
//! stays of use while the constraints of contact change.
//!
//! ```text
//! product of a direction (u, p, l) = body's part + w (D^T m l, m C u) on the face - curvature u
//! ```
//!
//! Only the body's part is kept between two programs; contact is put on for the face at
//! work and taken off behind it. Directions of an augmented system belong to its face and
//! end with it. Cost: one product with each coupling a direction, no
//! product with A.

use super::slides::{expand, gather, unknowns};
use super::weights::weigh;
use super::{Faces, GAP_WEIGHT};
use crate::inequality::{BlockIterate, QpRun};
use crate::linalg::vector::{add_scaled, scale};
use crate::linalg::{LinearOperator, Workspace};

/// Directions that stay from face to face with friction: a face keeps many, and each costs
/// products and dot products with all others.
const KEPT_BETWEEN_FACES: usize = 12;

impl Faces<'_, '_> {
    /// Adds this program's contact on the face of `contact` to the products of kept
    /// directions.
    pub(super) fn attach(&self, run: &mut QpRun<'_, '_>, contact: &BlockIterate) {
        if self.problem.augmentation.is_some() {
            run.directions.clear(run.work);
        }
        let is_unknown = unknowns(&contact.status, &contact.slides);
        self.adapt((run, contact), 1.0, |multiplier, closing| {
            gather(&contact.slides, closing);
            let entries = multiplier.iter_mut().zip(closing.iter_mut());
            for ((l, g), &is_unknown) in entries.zip(&is_unknown) {
                if !is_unknown {
                    (*l, *g) = (0.0, 0.0);
                }
            }
            for slide in contact.slides.iter().filter(|slide| slide.width > 1) {
                let place = slide.first as usize;
                let weight = GAP_WEIGHT * self.blocks.contact.moduli.get(place).unwrap_or(&1.0);
                closing[place] -= slide.softness * weight * weight * multiplier[place];
            }
        });
    }

    /// Takes contact off again.
    pub(super) fn detach(&self, run: &mut QpRun<'_, '_>, contact: &BlockIterate) {
        if self.problem.augmentation.is_some() {
            run.directions.clear(run.work);
        }
        if self.is_rough() {
            run.directions.keep_last(KEPT_BETWEEN_FACES, run.work);
        }
        self.adapt((run, contact), -1.0, |_, closing| closing.fill(0.0));
    }

    /// Puts contact on the products of the kept directions (`sign` 1) or takes it off
    /// (-1): rows, columns and curvature of this program. Cost: two products with the
    /// coupling a direction.
    fn adapt(
        &self,
        (run, at): (&mut QpRun<'_, '_>, &BlockIterate),
        sign: f64,
        restrict: impl Fn(&mut [f64], &mut [f64]),
    ) {
        let contact = &self.blocks.contact;
        let unknowns = self.problem.stiffness.rows();
        let mut part = run.work.scratch(unknowns);
        let mut inner = Workspace::new();
        run.directions.adapt(run.work, |direction, product| {
            let others = direction.len() - contact.rows.rows();
            let (known, multiplier) = direction.split_at_mut(others);
            let (force, closing) = product.split_at_mut(others);
            let (force, u) = (&mut force[..unknowns], &known[..unknowns]);
            contact.rows.apply(u, closing, &mut inner);
            scale(closing, GAP_WEIGHT);
            weigh(contact.moduli, closing);
            restrict(multiplier, closing);
            let mut pushed = inner.copy(multiplier);
            weigh(contact.moduli, &mut pushed);
            expand(&at.slides, &mut pushed);
            let columns = contact.columns;
            columns.apply_transposed(&pushed, &mut part, &mut inner);
            inner.give(pushed);
            add_scaled(force, sign * GAP_WEIGHT, &part);
            if let Some(curvature) = self.problem.curvature {
                curvature.apply(u, &mut part, &mut inner);
                add_scaled(force, -sign, &part);
            }
        });
        run.work.give(part);
    }
}
