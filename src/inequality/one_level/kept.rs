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

use super::weights::weigh;
use super::{Faces, GAP_WEIGHT};
use crate::inequality::QpRun;
use crate::linalg::vector::{add_scaled, scale};
use crate::linalg::{LinearOperator, Workspace};
use crate::saddle::Status;

impl Faces<'_, '_> {
    /// Adds this program's contact on the face `status` to the products of kept
    /// directions.
    pub(super) fn attach(&self, run: &mut QpRun<'_, '_>, status: &[Status]) {
        if self.problem.augmentation.is_some() {
            run.directions.clear(run.work);
        }
        self.adapt(run, 1.0, |multiplier, closing| {
            for ((l, g), &status) in multiplier.iter_mut().zip(closing).zip(status) {
                if status != Status::Stick {
                    (*l, *g) = (0.0, 0.0);
                }
            }
        });
    }

    /// Takes contact off again.
    pub(super) fn detach(&self, run: &mut QpRun<'_, '_>) {
        if self.problem.augmentation.is_some() {
            run.directions.clear(run.work);
        }
        self.adapt(run, -1.0, |_, closing| closing.fill(0.0));
    }

    /// Puts contact on the products of the kept directions (`sign` 1) or takes it off
    /// (-1): rows, columns and curvature of this program. Cost: two products with the
    /// coupling a direction.
    fn adapt(&self, run: &mut QpRun<'_, '_>, sign: f64, restrict: impl Fn(&mut [f64], &mut [f64])) {
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
