//! G at the places that contact sees, kept from problem to problem: a tool that moves a little
//! sees the same ones.
//!
//! Entries are those of the columns, so that no bit depends on which places are kept. Cost: one
//! copy of these entries where a place is new.

use super::columns::Columns;

constants! {
    /// Place of what has none.
    const NOWHERE: u32 = u32::MAX;
}

/// Rows and columns of G at some places.
#[derive(Debug, Default)]
pub(super) struct Near {
    /// Where each place of the surface is among them `[surface]`.
    among: Vec<u32>,
    /// Column by column `[places][places]`.
    columns: Vec<Vec<f64>>,
}

impl Near {
    /// Keeps G at all of `places`, ascending, whose columns are known.
    pub(super) fn cover(&mut self, places: &[usize], columns: &Columns) {
        self.among.resize(columns.unknowns.len(), NOWHERE);
        if places.iter().all(|&place| self.among[place] != NOWHERE) {
            return;
        }
        self.among.fill(NOWHERE);
        for (index, &place) in (0..).zip(places) {
            self.among[place] = index;
        }
        self.columns = columns.part(places);
    }

    /// Where a place that is covered is among those that are.
    pub(super) fn index(&self, place: usize) -> usize {
        self.among[place] as usize
    }

    /// The column of one of them `[places]`.
    pub(super) fn column(&self, index: usize) -> &[f64] {
        &self.columns[index]
    }

    /// Places covered.
    pub(super) fn size(&self) -> usize {
        self.columns.len()
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        (8 * self.size() * self.size() + 4 * self.among.len()) as u64
    }
}
