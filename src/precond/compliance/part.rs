//! Principal parts of the compliance, made entry by entry, and what is kept of them.

use super::Compliance;
use crate::linalg::DenseMatrix;
use crate::parallel;

/// A principal part that contains those of earlier questions.
#[derive(Default)]
pub(super) struct Known {
    /// Rows of the part, ascending.
    pub(super) selected: Vec<usize>,
    /// The part.
    pub(super) matrix: DenseMatrix,
}

impl Compliance {
    /// The principal part on `selected`, ascending, of which `known` is kept.
    pub(super) fn part_beside(&self, selected: &[usize], known: &Known) -> DenseMatrix {
        let part = PartBeside::new(self, selected, known);
        let size = selected.len();
        let columns: Vec<Vec<f64>> = parallel::map(size, 1, &|place| part.column(place));
        let mut part = DenseMatrix::zeros(size, size);
        for (j, column) in columns.iter().enumerate() {
            part.column_mut(j)[j..].copy_from_slice(column);
        }
        part.mirror();
        part
    }
}

/// What a principal part touches at the vertices.
pub(super) struct Touched {
    /// Traces, ascending.
    pub(super) traces: Vec<u32>,
    /// C1 on the part: each row on these traces `[selected]`.
    pub(super) rows: Vec<Vec<(u32, f64)>>,
}

impl Touched {
    /// By the rows `selected`.
    pub(super) fn new(of: &Compliance, selected: &[usize]) -> Self {
        let touched = selected.iter().flat_map(|&row| &of.vertex_rows[row]);
        let mut traces: Vec<u32> = touched.map(|&(trace, _)| trace).collect();
        traces.sort_unstable();
        traces.dedup();
        let within = |&(trace, value): &(u32, f64)| {
            let place = traces.partition_point(|&other| other < trace);
            (place as u32, value)
        };
        let rows = selected.iter().map(|&row| {
            let entries = of.vertex_rows[row].iter();
            entries.map(within).collect()
        });
        Self {
            rows: rows.collect(),
            traces,
        }
    }
}

/// A principal part to be made, next to what is known of it.
struct PartBeside<'c> {
    of: &'c Compliance,
    /// Rows of the part, ascending.
    selected: &'c [usize],
    /// What is known.
    known: &'c Known,
    /// Place of each row of the part in what is known; none where it is new.
    places: Vec<Option<usize>>,
    /// What the part touches at the vertices.
    touched: Touched,
}

impl<'c> PartBeside<'c> {
    fn new(of: &'c Compliance, selected: &'c [usize], known: &'c Known) -> Self {
        let place = |row: &usize| known.selected.binary_search(row).ok();
        Self {
            touched: Touched::new(of, selected),
            places: selected.iter().map(place).collect(),
            of,
            selected,
            known,
        }
    }

    /// Lower triangle of a column, from its own place on.
    fn column(&self, place: usize) -> Vec<f64> {
        let column = self.selected[place];
        let inverse = &self.of.vertex_inverse;
        let mut flexibility = vec![0.0; self.touched.traces.len()];
        for &(trace, value) in &self.of.vertex_rows[column] {
            let entries = inverse.column(trace as usize);
            for (sum, &trace) in flexibility.iter_mut().zip(&self.touched.traces) {
                *sum += value * entries[trace as usize];
            }
        }
        let below = &self.selected[place..];
        let mut entries = vec![0.0; below.len()];
        let mut is_known = vec![false; below.len()];
        for (at, &row) in below.iter().enumerate() {
            if let (Some(i), Some(j)) = (self.places[place + at], self.places[place]) {
                entries[at] = self.known.matrix.at(i, j);
                is_known[at] = true;
                continue;
            }
            let own = self.touched.rows[place + at].iter();
            let smooth: f64 = own.map(|&(t, value)| value * flexibility[t as usize]).sum();
            entries[at] = smooth - self.of.through_volumes(row, column);
        }
        let (rows, values) = self.of.nodes.row(column);
        for (&row, value) in rows.iter().zip(values) {
            if let Ok(at) = below.binary_search(&(row as usize)) {
                entries[at] += if is_known[at] { 0.0 } else { *value };
            }
        }
        if !is_known[0] {
            entries[0] += self.of.lift;
        }
        for (entry, is_known) in entries.iter_mut().zip(is_known) {
            *entry *= if is_known { 1.0 } else { self.of.scale };
        }
        entries
    }
}
