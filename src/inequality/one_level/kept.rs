//! Krylov directions kept between programs and faces: what they learned about A and B
//! stays of use while the constraints of contact change.
//!
//! ```text
//! product of a direction (u, p, l) = body's part + w (D^T m l, m C u) on the face - curvature u
//! ```
//!
//! Only the body's part is kept between two programs; contact is put on for the face at
//! work and taken off after it. Directions of an augmented system belong to its face and
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
        let mut work = Workspace::new();
        run.directions.adapt(run.work, |direction, product| {
            self.put_on(
                (&mut *direction, &mut *product),
                (contact, &is_unknown),
                &mut work,
            );
            self.curve(-1.0, (direction, product), &mut work);
        });
    }

    /// Takes contact off again.
    pub(super) fn detach(&self, run: &mut QpRun<'_, '_>, contact: &BlockIterate) {
        self.forget_the_face(run);
        let mut work = Workspace::new();
        run.directions.adapt(run.work, |direction, product| {
            self.take_off((&mut *direction, &mut *product), contact, &mut work);
            self.curve(1.0, (direction, product), &mut work);
        });
    }

    /// Takes the contact of one face off and puts that of another on.
    pub(super) fn exchange(
        &self,
        run: &mut QpRun<'_, '_>,
        (last, next): (&BlockIterate, &BlockIterate),
    ) {
        self.forget_the_face(run);
        let is_unknown = unknowns(&next.status, &next.slides);
        let mut work = Workspace::new();
        run.directions.adapt(run.work, |direction, product| {
            self.take_off((&mut *direction, &mut *product), last, &mut work);
            self.put_on((direction, product), (next, &is_unknown), &mut work);
        });
    }

    /// Drops directions that have no use beyond the face they were found on.
    fn forget_the_face(&self, run: &mut QpRun<'_, '_>) {
        if self.problem.augmentation.is_some() {
            run.directions.clear(run.work);
        }
        if self.is_frictional() {
            run.directions.keep_last(KEPT_BETWEEN_FACES, run.work);
        }
    }

    /// Puts contact on the product of a direction: rows and columns of this program, on the
    /// face alone.
    fn put_on(
        &self,
        (direction, product): (&mut [f64], &mut [f64]),
        (contact, is_unknown): (&BlockIterate, &[bool]),
        work: &mut Workspace,
    ) {
        let block = &self.blocks.contact;
        let others = direction.len() - block.rows.rows();
        let (known, multiplier) = direction.split_at_mut(others);
        let closing = &mut product[others..];
        block
            .rows
            .apply(&known[..self.problem.stiffness.rows()], closing, work);
        scale(closing, GAP_WEIGHT);
        weigh(block.moduli, closing);
        gather(&contact.slides, closing);
        let entries = multiplier.iter_mut().zip(closing.iter_mut());
        for ((l, g), &is_unknown) in entries.zip(is_unknown) {
            if !is_unknown {
                (*l, *g) = (0.0, 0.0);
            }
        }
        for slide in contact.slides.iter().filter(|slide| slide.width > 1) {
            let place = slide.first as usize;
            let weight = GAP_WEIGHT * block.moduli.get(place).unwrap_or(&1.0);
            closing[place] -= slide.softness * weight * weight * multiplier[place];
        }
        self.push(1.0, (direction, product), contact, work);
    }

    /// Takes contact off the product of a direction that it was put on.
    fn take_off(
        &self,
        (direction, product): (&mut [f64], &mut [f64]),
        contact: &BlockIterate,
        work: &mut Workspace,
    ) {
        let others = direction.len() - self.blocks.contact.rows.rows();
        product[others..].fill(0.0);
        self.push(-1.0, (direction, product), contact, work);
    }

    /// Adds `sign` times what the multipliers push.
    fn push(
        &self,
        sign: f64,
        (direction, product): (&[f64], &mut [f64]),
        contact: &BlockIterate,
        work: &mut Workspace,
    ) {
        let block = &self.blocks.contact;
        let multiplier = &direction[direction.len() - block.rows.rows()..];
        let force = &mut product[..self.problem.stiffness.rows()];
        let mut pushed = work.copy(multiplier);
        weigh(block.moduli, &mut pushed);
        expand(&contact.slides, &mut pushed);
        let columns = block.columns;
        columns.add_transposed(sign * GAP_WEIGHT, &pushed, force, work);
        work.give(pushed);
    }

    /// Adds `sign` times the curvature of contact, which is the same on every face of a
    /// program.
    fn curve(&self, sign: f64, (direction, product): (&[f64], &mut [f64]), work: &mut Workspace) {
        if let Some(curvature) = self.problem.curvature {
            let unknowns = self.problem.stiffness.rows();
            let mut part = work.scratch(unknowns);
            curvature.apply(&direction[..unknowns], &mut part, work);
            add_scaled(&mut product[..unknowns], sign, &part);
            work.give(part);
        }
    }
}
