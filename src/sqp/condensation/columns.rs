//! Columns of the response on the surface, `G = R K^-1 R^T [surface, surface]`, by blocks of
//! neighbouring unknowns, each made when one of its columns is first asked for.
//!
//! A block is always solved for as a whole, so that a column has the same bits whichever was
//! asked for. Small bodies keep the columns whole, from which the fields of an update come
//! by one product. Cost: a block reads the factor twice.

use crate::parallel::{self, Pieces};
use std::sync::OnceLock;

use crate::inequality::BodyFactor;
use crate::linalg::Workspace;
use crate::plan::response::FieldsFrom;

constants! {
    /// Columns of a block.
    const BLOCK: usize = 48;
    /// Blocks between two looks at whether the increment is stopped.
    const AT_ONCE: usize = 4;
    /// Fewer columns are not worth a second thread.
    const FEW: usize = 128;
    /// Place of what has none.
    const NOWHERE: u32 = u32::MAX;
}

/// G as far as it is known.
#[derive(Debug)]
pub(super) struct Columns {
    /// Unknowns of the surface, neighbours near each other `[surface]`.
    pub(super) unknowns: Vec<u32>,
    /// Place of each displacement unknown on the surface `[displacement]`.
    places: Vec<u32>,
    /// Columns of each block, once they are known.
    blocks: Vec<OnceLock<Block>>,
    /// Whether blocks are kept whole.
    pub(super) fields: FieldsFrom,
}

/// Columns of neighbouring unknowns.
#[derive(Clone, Debug)]
struct Block {
    /// On the surface `[BLOCK, surface]`.
    surface: Vec<f64>,
    /// Whole `[BLOCK, unknowns]`; empty where they are not kept.
    whole: Vec<f64>,
}

impl Columns {
    /// None known, for those `unknowns` of the surface; `order` is the place of each unknown of
    /// the body in an elimination order, by which neighbours are near each other.
    pub(super) fn new(mut unknowns: Vec<u32>, order: &[u32], fields: FieldsFrom) -> Self {
        unknowns.sort_by_key(|&unknown| (order[unknown as usize], unknown));
        let mut places = vec![NOWHERE; order.len()];
        for (place, &unknown) in (0..).zip(&unknowns) {
            places[unknown as usize] = place;
        }
        Self {
            blocks: vec![OnceLock::new(); unknowns.len().div_ceil(BLOCK)],
            places,
            unknowns,
            fields,
        }
    }

    /// Whether they are those of that surface, kept like that; its unknowns in any order.
    pub(super) fn are_of(&self, unknowns: &[u32], fields: FieldsFrom) -> bool {
        let is_there = |&unknown: &u32| self.place(unknown).is_some();
        let is_all = self.unknowns.len() == unknowns.len() && unknowns.iter().all(is_there);
        is_all && self.fields == fields
    }

    /// Whether others are of the same surface, kept in the same way.
    pub(super) fn are_like(&self, others: &Self) -> bool {
        self.are_of(&others.unknowns, others.fields)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let known = self.blocks.iter().filter_map(OnceLock::get);
        let known = known.map(|block| block.surface.len() + block.whole.len());
        let known: usize = known.sum();
        (8 * known + 4 * (self.places.len() + self.unknowns.len())) as u64
    }

    /// Place of an unknown on the surface; none elsewhere.
    pub(super) fn place(&self, unknown: u32) -> Option<usize> {
        let place = *self.places.get(unknown as usize)?;
        (place != NOWHERE).then_some(place as usize)
    }

    /// Places where a load `[displacement]` presses.
    pub(super) fn pressed(&self, load: &[f64]) -> Vec<usize> {
        let places = self.unknowns.iter().enumerate();
        let places = places.filter(|(_, unknown)| load[**unknown as usize] != 0.0);
        places.map(|(place, _)| place).collect()
    }

    /// Values of a load `[displacement]` at `places`.
    pub(super) fn values(&self, places: &[usize], load: &[f64]) -> Vec<f64> {
        let values = places.iter();
        values
            .map(|&place| load[self.unknowns[place] as usize])
            .collect()
    }

    /// Makes the columns at `places` known; none where `stopped` says so on the way.
    pub(super) fn ask_for(
        &self,
        places: &[usize],
        factor: &BodyFactor,
        stopped: &dyn Fn() -> bool,
    ) -> Option<()> {
        let mut missing: Vec<usize> = places.iter().map(|place| place / BLOCK).collect();
        missing.sort_unstable();
        missing.dedup();
        missing.retain(|&block| self.blocks[block].get().is_none());
        for some in missing.chunks(AT_ONCE) {
            if stopped() {
                return None;
            }
            let made = parallel::map(some.len(), 1, &|k| self.make(some[k], factor));
            for (&block, columns) in some.iter().zip(made) {
                // Another session may have made the same ones.
                self.blocks[block].get_or_init(|| columns);
            }
        }
        Some(())
    }

    fn make(&self, block: usize, factor: &BodyFactor) -> Block {
        let size = factor.size();
        let first = block * BLOCK;
        let own = &self.unknowns[first..self.unknowns.len().min(first + BLOCK)];
        let mut loads = vec![0.0; size * own.len()];
        for (load, &unknown) in loads.chunks_exact_mut(size).zip(own) {
            load[unknown as usize] = 1.0;
        }
        factor.solve(&mut loads, &mut Workspace::new());
        let columns = loads.chunks_exact(size);
        let surface = columns
            .flat_map(|column| self.unknowns.iter().map(|&row| column[row as usize]))
            .collect();
        let whole = match self.fields {
            FieldsFrom::Columns => loads,
            FieldsFrom::Factor => Vec::new(),
        };
        Block { surface, whole }
    }

    /// The known column at `place` `[surface]`; empty where it is not known.
    fn column(&self, place: usize) -> &[f64] {
        let Some(block) = self.blocks[place / BLOCK].get() else {
            return &[];
        };
        let rows = self.unknowns.len();
        &block.surface[place % BLOCK * rows..(place % BLOCK + 1) * rows]
    }

    /// `K^-1 x` `[size]` of a load on the surface `[size]` by columns that are kept whole.
    pub(super) fn whole_product(&self, load: &[f64], factor: &BodyFactor) -> Vec<f64> {
        let size = factor.size();
        let places = self.pressed(load);
        // Those that pressed on the way are known, but not to a response that is made anew.
        self.ask_for(&places, factor, &|| false).unwrap_or_default();
        let columns = places.iter().filter_map(|&place| {
            let block = self.blocks[place / BLOCK].get()?;
            let column = block.whole.chunks_exact(size).nth(place % BLOCK)?;
            Some((column, load[self.unknowns[place] as usize]))
        });
        let columns: Vec<(&[f64], f64)> = columns.collect();
        let mut y = vec![0.0; size];
        let rows = size.div_ceil(rayon::current_num_threads()).max(FEW);
        parallel::each(Pieces::of(&mut y, rows), 1, &|chunk, y| {
            for (column, value) in &columns {
                let column = &column[chunk * rows..][..y.len()];
                y.iter_mut().zip(column).for_each(|(y, g)| *y += value * g);
            }
        });
        y
    }

    /// Subtracts G x from `y` `[surface]`, x being zero but at `places`, whose columns are
    /// known.
    pub(super) fn subtract_product(&self, (places, x): (&[usize], &[f64]), y: &mut [f64]) {
        let rows = y.len().div_ceil(rayon::current_num_threads()).max(FEW);
        parallel::each(Pieces::of(y, rows), 1, &|chunk, y| {
            for (&place, value) in places.iter().zip(x) {
                let column = &self.column(place)[chunk * rows..][..y.len()];
                y.iter_mut().zip(column).for_each(|(y, g)| *y -= value * g);
            }
        });
    }

    /// G at rows and columns `places`, whose columns are known, column by column.
    pub(super) fn part(&self, places: &[usize]) -> Vec<Vec<f64>> {
        parallel::map(places.len(), FEW, &|k| {
            let column = self.column(places[k]);
            places.iter().map(|&row| column[row]).collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inequality::Matrices;
    use crate::linalg::SparseRowsBuilder;
    use crate::linalg::samples::rows;

    /// Springs between 200 points in a line, the ends held.
    fn line() -> BodyFactor {
        let size = 200;
        let row = |i: usize| -> Vec<f64> {
            let entry = |j: usize| match i.abs_diff(j) {
                0 => 2.0 + 0.01 * i as f64,
                1 => -1.0,
                _ => 0.0,
            };
            (0..size).map(entry).collect()
        };
        let stiffness: Vec<Vec<f64>> = (0..size).map(row).collect();
        BodyFactor::new(&Matrices {
            stiffness: rows(&stiffness),
            coupling: None,
            stabilisation: None,
            contact: &SparseRowsBuilder::new(size).finish(),
            places: (0..size as u32).collect(),
            has_rigid_modes: false,
            most_flops: f64::INFINITY,
        })
        .expect("a positive definite matrix")
    }

    #[test]
    fn whole_columns_give_the_solution_of_the_factor_whatever_was_asked_for() {
        let factor = line();
        let order: Vec<u32> = (0..200).collect();
        let surface: Vec<u32> = (0..200).step_by(2).collect();
        let mut load = vec![0.0; factor.size()];
        for unknown in [4, 100, 198] {
            load[unknown] = 1.0 + unknown as f64;
        }
        let mut expected = load.clone();
        factor.solve(&mut expected, &mut Workspace::new());
        let columns = Columns::new(surface, &order, FieldsFrom::Columns);
        let found = columns.whole_product(&load, &factor);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() <= 1e-12 * expected.abs());
        }
        columns.ask_for(&[0], &factor, &|| false);
        assert_eq!(found, columns.whole_product(&load, &factor));
    }
}
