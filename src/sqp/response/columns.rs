//! Columns of the response on the surface, `G = R K^-1 R^T [surface, surface]`, by blocks of
//! neighbouring unknowns, each made when one of its columns is first asked for.
//!
//! A block is always solved for as a whole, so that a column has the same bits whichever was
//! asked for. Cost: a block reads the factor twice.

use rayon::prelude::*;

use crate::inequality::BodyFactor;
use crate::linalg::Workspace;

/// Columns of a block.
const BLOCK: usize = 48;
/// Blocks between two looks at whether the increment is stopped.
const AT_ONCE: usize = 4;
/// Fewer columns are not worth a second thread.
const FEW: usize = 128;
/// No place.
const NOWHERE: u32 = u32::MAX;

/// G as far as it is known.
#[derive(Debug)]
pub(super) struct Columns {
    /// Unknowns of the surface, neighbours near each other `[surface]`.
    pub(super) unknowns: Vec<u32>,
    /// Place of each displacement unknown on the surface `[displacement]`.
    places: Vec<u32>,
    /// Columns of each block `[BLOCK, surface]`; none where not known yet.
    blocks: Vec<Option<Vec<f64>>>,
}

impl Columns {
    /// None known, for those `unknowns` of the surface; `order` is the place of each unknown of
    /// the body in an elimination order, by which neighbours are near each other.
    pub(super) fn new(mut unknowns: Vec<u32>, order: &[u32]) -> Self {
        unknowns.sort_by_key(|&unknown| (order[unknown as usize], unknown));
        let mut places = vec![NOWHERE; order.len()];
        for (place, &unknown) in (0..).zip(&unknowns) {
            places[unknown as usize] = place;
        }
        Self {
            blocks: vec![None; unknowns.len().div_ceil(BLOCK)],
            places,
            unknowns,
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let known = self.blocks.iter().flatten().map(Vec::len).sum::<usize>();
        (8 * known + 4 * (self.places.len() + self.unknowns.len())) as u64
    }

    /// Place of an unknown on the surface; none elsewhere.
    pub(super) fn place(&self, unknown: u32) -> Option<usize> {
        let place = *self.places.get(unknown as usize)?;
        (place != NOWHERE).then_some(place as usize)
    }

    /// Makes the columns at `places` known; none where `stopped` says so on the way.
    pub(super) fn ask_for(
        &mut self,
        places: &[usize],
        factor: &BodyFactor,
        stopped: &dyn Fn() -> bool,
    ) -> Option<()> {
        let mut missing: Vec<usize> = places.iter().map(|place| place / BLOCK).collect();
        missing.sort_unstable();
        missing.dedup();
        missing.retain(|&block| self.blocks[block].is_none());
        for some in missing.chunks(AT_ONCE) {
            if stopped() {
                return None;
            }
            let made = some.par_iter().map(|&block| self.make(block, factor));
            let made: Vec<Vec<f64>> = made.collect();
            for (&block, columns) in some.iter().zip(made) {
                self.blocks[block] = Some(columns);
            }
        }
        Some(())
    }

    fn make(&self, block: usize, factor: &BodyFactor) -> Vec<f64> {
        let size = factor.size();
        let first = block * BLOCK;
        let own = &self.unknowns[first..self.unknowns.len().min(first + BLOCK)];
        let mut loads = vec![0.0; size * own.len()];
        for (load, &unknown) in loads.chunks_exact_mut(size).zip(own) {
            load[unknown as usize] = 1.0;
        }
        factor.solve(&mut loads, &mut Workspace::new());
        let columns = loads.chunks_exact(size);
        columns
            .flat_map(|column| self.unknowns.iter().map(|&row| column[row as usize]))
            .collect()
    }

    /// The known column at `place` `[surface]`; empty where it is not known.
    fn column(&self, place: usize) -> &[f64] {
        let Some(block) = &self.blocks[place / BLOCK] else {
            return &[];
        };
        let rows = self.unknowns.len();
        &block[place % BLOCK * rows..(place % BLOCK + 1) * rows]
    }

    /// Subtracts G x from `y` `[surface]`, x being zero but at `places`, whose columns are
    /// known.
    pub(super) fn subtract_product(&self, (places, x): (&[usize], &[f64]), y: &mut [f64]) {
        let rows = y.len().div_ceil(rayon::current_num_threads()).max(FEW);
        y.par_chunks_mut(rows).enumerate().for_each(|(chunk, y)| {
            for (&place, value) in places.iter().zip(x) {
                let column = &self.column(place)[chunk * rows..][..y.len()];
                y.iter_mut().zip(column).for_each(|(y, g)| *y -= value * g);
            }
        });
    }

    /// G at rows and columns `places`, whose columns are known, column by column.
    pub(super) fn part(&self, places: &[usize]) -> Vec<Vec<f64>> {
        let column = |&place: &usize| {
            let column = self.column(place);
            places.iter().map(|&row| column[row]).collect()
        };
        places.par_iter().with_min_len(FEW).map(column).collect()
    }
}
