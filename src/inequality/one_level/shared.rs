//! Modes that contact shares with the first block ([`SharedMode`]), on one face.

use super::GAP_WEIGHT;
use super::weights::weigh;
use crate::inequality::blocks::ContactBlock;
use crate::linalg::vector::dot;
use crate::saddle::{SharedMode, Status};

/// The modes that contact on the face shares, in its weights.
pub(super) fn shared_on_the_face(contact: &ContactBlock<'_>, status: &[Status]) -> Vec<SharedMode> {
    let matrix = contact.sprung.unwrap_or(contact.matrix);
    let encloses = |mode: &&SharedMode| {
        let mut alike = mode.alike.clone();
        let off_face = alike.iter_mut().zip(status);
        off_face
            .filter(|(_, status)| **status != Status::Stick)
            .for_each(|(value, _)| *value = 0.0);
        let mut seen = vec![0.0; alike.len()];
        matrix.product(&alike, &mut seen);
        let taken = dot(&alike, &mode.own).powi(2) / mode.work;
        mode.excess > 0.0 || taken > mode.least_share * (taken + dot(&alike, &seen))
    };
    let modes = contact.shared.iter().filter(encloses);
    modes
        .map(|mode| on_the_face(mode, contact.moduli, status))
        .collect()
}

/// A mode that contact shares, with the weights of the face.
fn on_the_face(mode: &SharedMode, moduli: &[f64], status: &[Status]) -> SharedMode {
    let mut mode = mode.clone();
    for (own, &status) in mode.own.iter_mut().zip(status) {
        *own *= match status {
            Status::Stick => GAP_WEIGHT,
            Status::Open | Status::Slip => 0.0,
        };
    }
    weigh(moduli, &mut mode.own);
    mode
}
