//! Which face follows from a solved one:
//!
//! ```text
//! closed where D_i (l_i - its least value) > gap_i,   D_i = sum_j C_ij^2 / A_jj
//! ```
//!
//! D stands for the diagonal of the compliance, so that both sides are gaps.

use super::super::blocks::ContactBlock;
use super::super::qp::{BlockIterate, QpStatus};
use super::system::{Matrices, softness};
use crate::saddle::Status;

/// The rule of one problem.
pub(super) struct Rule {
    /// D `[multipliers]`.
    softness: Vec<f64>,
    /// Least admissible multipliers `[multipliers]`.
    least: Vec<f64>,
}

impl Rule {
    /// Of contact on `matrices`.
    ///
    /// # Errors
    /// [`QpStatus::Unsupported`] for sets that are neither lines nor half lines.
    pub(super) fn new(block: &ContactBlock<'_>, matrices: &Matrices<'_>) -> Result<Self, QpStatus> {
        Ok(Self {
            softness: softness(matrices),
            least: block.set.lower_bounds().ok_or(QpStatus::Unsupported)?,
        })
    }

    /// By how much pressure outweighs the gap.
    fn weight(&self, contact: &BlockIterate, index: usize) -> f64 {
        let pressure = contact.multiplier[index] - self.least[index];
        self.softness[index] * pressure - contact.residual[index]
    }

    /// The next face. Lines are closed; what no displacement changes stays open.
    pub(super) fn next(&self, contact: &BlockIterate) -> Vec<Status> {
        let multipliers = 0..contact.multiplier.len();
        let is_closed = |i: usize| match self.least[i] == f64::NEG_INFINITY {
            true => true,
            false => self.softness[i] > 0.0 && self.weight(contact, i) > 0.0,
        };
        multipliers
            .map(|i| Status::of_contact(is_closed(i)))
            .collect()
    }

    /// The present face but for the first multiplier that is wrong.
    pub(super) fn change_one(&self, contact: &BlockIterate) -> Vec<Status> {
        let next = self.next(contact);
        let mut face = contact.status.clone();
        let wrong = (0..face.len()).find(|&i| face[i] != next[i]);
        if let Some(first) = wrong {
            face[first] = next[first];
        }
        face
    }

    /// Whether what speaks against the present face is below `bound`, a gap.
    pub(super) fn accepts(&self, contact: &BlockIterate, bound: f64) -> bool {
        let mut square = 0.0;
        for (i, &status) in contact.status.iter().enumerate() {
            let wrong = match status {
                Status::Open => contact.residual[i].min(0.0),
                Status::Stick | Status::Slip => {
                    let below = (contact.multiplier[i] - self.least[i]).min(0.0);
                    self.softness[i] * below
                }
            };
            square += wrong * wrong;
        }
        square.sqrt() <= bound
    }
}
