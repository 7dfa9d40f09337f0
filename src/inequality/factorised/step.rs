//! The block step by a factor of the body, contact by its compliance:
//!
//! ```text
//! y = K^-1 r,   dl = W^-1 (C y - r_c),   z = K^-1 (r - D^T dl)
//! ```
//!
//! K the saddle point of the body, W about C K^-1 D^T. Where K is that of the operator and W its
//! compliance, this is the inverse on a face; what differs in some columns costs as many
//! iterations. Cost: two solutions with the factor, one where no contact is.

use std::sync::atomic::{AtomicU32, Ordering};

use super::BodyFactor;
use crate::linalg::vector::scale;
use crate::linalg::{LinearOperator, Preconditioner, Workspace};
use crate::saddle::{BlockStep, EqualityBlock};

/// The step by a factor.
pub struct FactorStep<'f> {
    /// K.
    pub body: &'f BodyFactor,
    /// Counts solutions with it.
    pub solutions: &'f AtomicU32,
}

impl BlockStep for FactorStep<'_> {
    fn preconditioner<'a>(
        &'a self,
        _stiffness: &'a dyn LinearOperator,
        _displacement: &'a dyn Preconditioner,
        blocks: &'a [EqualityBlock<'a>],
    ) -> Box<dyn Preconditioner + 'a> {
        Box::new(OnBlocks { step: self, blocks })
    }
}

/// The step on blocks: the internal pressure, and contact where there is any.
struct OnBlocks<'a> {
    step: &'a FactorStep<'a>,
    blocks: &'a [EqualityBlock<'a>],
}

impl OnBlocks<'_> {
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        z.copy_from_slice(r);
        self.step.body.solve(z, work);
        self.step.solutions.fetch_add(1, Ordering::Relaxed);
    }
}

impl Preconditioner for OnBlocks<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64], work: &mut Workspace) {
        let (r, r_contact) = r.split_at(self.step.body.size());
        let (z, z_contact) = z.split_at_mut(r.len());
        self.solve(r, z, work);
        let Some(contact) = self.blocks.last().filter(|_| !r_contact.is_empty()) else {
            return;
        };
        let unknowns = contact.rows.columns();
        let mut gap = work.copy(r_contact);
        let rows = contact.rows;
        rows.subtract_product(&z[..unknowns], &mut gap, work);
        contact.metric.apply(&gap, z_contact, work);
        scale(z_contact, -1.0);
        let mut rest = work.copy(r);
        let columns = contact.columns;
        columns.add_transposed(-1.0, z_contact, &mut rest[..unknowns], work);
        self.solve(&rest, z, work);
        work.give(gap);
        work.give(rest);
    }
}
