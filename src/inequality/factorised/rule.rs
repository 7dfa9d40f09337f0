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
use crate::linalg::vector::norm;
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

    /// Whether what speaks against the present face is below the targets: gaps below
    /// `bound`, multipliers outside of their sets below `share` of all.
    pub(super) fn accepts(&self, contact: &BlockIterate, bound: f64, share: f64) -> bool {
        let (mut square, mut outside) = (0.0, 0.0);
        for (i, &status) in contact.status.iter().enumerate() {
            let wrong = match status {
                Status::Open => contact.residual[i].min(0.0),
                Status::Stick | Status::Slip => {
                    let below = (contact.multiplier[i] - self.least[i]).min(0.0);
                    outside += below * below;
                    self.softness[i] * below
                }
            };
            square += wrong * wrong;
        }
        square.sqrt() <= bound && outside.sqrt() <= share * norm(&contact.multiplier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_that_pulls_is_not_accepted_however_soft_the_body_is_to_it() {
        let rule = Rule {
            softness: vec![1e-9; 2],
            least: vec![0.0; 2],
        };
        let mut contact = BlockIterate {
            status: vec![Status::Stick; 2],
            ..BlockIterate::of_equality(vec![0.0; 2])
        };
        for (pull, is_accepted) in [(-1e-7, false), (-1e-9, true), (0.0, true)] {
            contact.multiplier = vec![1.0, pull];
            assert_eq!(rule.accepts(&contact, 1e-8, 1e-8), is_accepted, "{pull}");
        }
    }
}
