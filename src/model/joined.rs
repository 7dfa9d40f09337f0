//! Gaps and coupling of all multipliers from those of the interfaces: the sums where
//! surfaces have common multipliers, one after the other elsewhere. Cost: one pass over
//! the entries.

use super::friction::{Friction, Slips};
use super::interfaces::Interface;
use crate::contact::gap::Linearisation;
use crate::contact::shares::add_equal_columns;
use crate::linalg::{SparseRows, SparseRowsBuilder};

/// Gaps and rows of all multipliers, added up where surfaces have common ones.
pub(crate) struct Joined {
    /// Weighted gaps `[multipliers]`.
    gap: Vec<f64>,
    /// Rows of the coupling `[multipliers]`.
    rows: Vec<Vec<(u32, f64)>>,
}

impl Joined {
    /// Of that many multipliers, all zero.
    pub(crate) fn new(multipliers: usize) -> Self {
        Self {
            gap: vec![0.0; multipliers],
            rows: vec![Vec::new(); multipliers],
        }
    }

    /// Adds what one interface contributes.
    pub(crate) fn add(&mut self, interface: &Interface, part: Linearisation) {
        interface.add_own(&part.gap, &mut self.gap);
        for (place, mut row) in interface.places().zip(part.rows) {
            match &mut self.rows[place] {
                empty if empty.is_empty() => *empty = row,
                others => {
                    others.append(&mut row);
                    add_equal_columns(others);
                }
            }
        }
    }

    /// Puts the slips of friction and their rows after the pressures.
    pub(crate) fn add_friction(&mut self, friction: &Friction, slips: Slips) {
        let own = friction.first..friction.first + friction.size();
        self.gap[own.clone()].copy_from_slice(&slips.slip);
        for (row, slip) in self.rows[own].iter_mut().zip(slips.rows) {
            *row = slip;
        }
    }

    /// Gaps, and the coupling to that many unknowns.
    pub(crate) fn finish(mut self, unknowns: usize) -> (Vec<f64>, SparseRows) {
        let mut builder = SparseRowsBuilder::new(unknowns);
        self.rows.iter_mut().for_each(|row| builder.push_row(row));
        (self.gap, builder.finish())
    }
}
