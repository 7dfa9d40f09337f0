//! Modes that contact shares with the first block ([`crate::saddle::SharedModes`]), on one face.

use super::GAP_WEIGHT;
use super::weights::weigh;
use crate::inequality::blocks::ContactBlock;
use crate::linalg::vector::dot;
use crate::linalg::{SparseRows, SymmetricMatrix};
use crate::saddle::{JointModes, Status};

/// Share of the multipliers up to which the energy of a pattern is that of its part.
const LOCAL: usize = 4;

/// The modes that contact on the face shares, in its weights; none where it shares none.
pub(super) fn shared_on_the_face(
    contact: &ContactBlock<'_>,
    status: &[Status],
) -> Option<JointModes> {
    let modes = contact.shared?;
    let matrix = contact.matrix;
    let encloses = |&mode: &usize| {
        let alike = on_the_face(&modes.alike, mode, status);
        let seen: f64 = (alike.iter().zip(values_at(&modes.own, mode, &alike)))
            .map(|(&(_, value), own)| value * own)
            .sum();
        let work = modes.work.at(mode, mode);
        let taken = seen * seen / work;
        taken > modes.least_share * (taken + energy(matrix, &alike))
    };
    let selected: Vec<usize> = (0..modes.work.rows()).filter(encloses).collect();
    let mut weights: Vec<f64> = (status.iter())
        .map(|status| match status {
            Status::Stick => GAP_WEIGHT,
            Status::Open | Status::Slip => 0.0,
        })
        .collect();
    weigh(contact.moduli, &mut weights);
    (!selected.is_empty()).then(|| modes.on_face(&selected, &weights))
}

/// A row of patterns where contact sticks: multipliers, ascending, with their values.
fn on_the_face(patterns: &SparseRows, row: usize, status: &[Status]) -> Vec<(usize, f64)> {
    let (places, values) = patterns.row(row);
    let entries = places.iter().map(|&place| place as usize).zip(values);
    let entries = entries.filter(|&(place, _)| status[place] == Status::Stick);
    entries.map(|(place, &value)| (place, value)).collect()
}

/// Entries of a row at these places.
fn values_at<'a>(
    rows: &'a SparseRows,
    row: usize,
    places: &'a [(usize, f64)],
) -> impl Iterator<Item = f64> + 'a {
    let (columns, values) = rows.row(row);
    let found = |place: usize| columns.binary_search(&(place as u32)).ok();
    (places.iter()).map(move |&(place, _)| found(place).map_or(0.0, |at| values[at]))
}

/// x.H x of a sparse x.
fn energy(matrix: &dyn SymmetricMatrix, x: &[(usize, f64)]) -> f64 {
    let values: Vec<f64> = x.iter().map(|&(_, value)| value).collect();
    if LOCAL * x.len() <= matrix.size() {
        let places: Vec<usize> = x.iter().map(|&(place, _)| place).collect();
        let mut product = vec![0.0; values.len()];
        matrix
            .principal_part(&places)
            .multiply(&values, &mut product);
        return dot(&values, &product);
    }
    let mut all = vec![0.0; matrix.size()];
    x.iter().for_each(|&(place, value)| all[place] = value);
    let mut product = vec![0.0; all.len()];
    matrix.product(&all, &mut product);
    dot(&all, &product)
}
