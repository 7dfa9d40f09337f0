//! Modes that contact shares with the first block ([`SharedMode`]), on one face.

use super::GAP_WEIGHT;
use super::weights::weigh;
use crate::inequality::blocks::ContactBlock;
use crate::linalg::vector::dot;
use crate::saddle::{SharedMode, Status};

/// Share of a mode that contact on the face has to take up for both to be solved together:
/// that of a volume with other free surfaces is left to the metrics, which counts say is
/// better.
const ENCLOSED: f64 = 0.9;

/// The modes that contact on the face shares, in its weights.
pub(super) fn shared_on_the_face(contact: &ContactBlock<'_>, status: &[Status]) -> Vec<SharedMode> {
    let sticks = |&status: &Status| f64::from(u8::from(status == Status::Stick));
    let even: Vec<f64> = status.iter().map(sticks).collect();
    let mut seen = vec![0.0; even.len()];
    if !contact.shared.is_empty() {
        contact
            .sprung
            .unwrap_or(contact.matrix)
            .product(&even, &mut seen);
    }
    let rest = dot(&even, &seen);
    let encloses = |mode: &&SharedMode| {
        let taken = dot(&even, &mode.own).powi(2) / mode.work;
        taken > ENCLOSED * (taken + rest)
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
