//! Where the copies of each node lie in the results of all blocks, and their
//! sums in block order.

use crate::assembly::simd;
use crate::assembly::transpose::Row;
use crate::linalg::Scalar;
use crate::parallel::{self, Pieces};

/// Copies between asking for one and reading it.
const AHEAD: usize = 24;
/// Nodes per parallel piece.
const PIECE: usize = 2048;
/// Pieces that are not worth a second thread.
const ALONE: usize = 3;

/// Positions of the copies of each node.
#[derive(Clone, Debug, Default)]
pub(in crate::assembly) struct Copies {
    offsets: Vec<u32>,
    positions: Vec<u32>,
}

impl Copies {
    /// `blocks`: first position and nodes of each block.
    pub(super) fn new<'a>(
        nodes: usize,
        blocks: impl Iterator<Item = (usize, &'a [u32])> + Clone,
    ) -> Self {
        let mut offsets = vec![0_u32; nodes + 1];
        for node in blocks.clone().flat_map(|(_, nodes)| nodes) {
            offsets[*node as usize + 1] += 1;
        }
        for node in 0..nodes {
            offsets[node + 1] += offsets[node];
        }
        let mut next = offsets.clone();
        let mut positions = vec![0; offsets[nodes] as usize];
        for (first, block) in blocks {
            for (index, &node) in block.iter().enumerate() {
                let slot = &mut next[node as usize];
                positions[*slot as usize] = (first + index) as u32;
                *slot += 1;
            }
        }
        Self { offsets, positions }
    }

    pub(super) fn bytes(&self) -> usize {
        4 * (self.offsets.len() + self.positions.len())
    }

    /// Hands the sum of each node's rows to `take`, together with the node's
    /// `C` numbers of `y`; `y` may end before the last node.
    pub(in crate::assembly) fn sum<const C: usize, R: Scalar>(
        &self,
        local: &[Row<R>],
        y: &mut [R],
        take: impl Fn(&mut [R; C], Row<R>) + Sync,
    ) {
        let of_piece = |piece: usize, part: &mut [R]| {
            let (nodes, _) = part.as_chunks_mut::<C>();
            let offsets = &self.offsets[piece * PIECE..];
            for (target, range) in nodes.iter_mut().zip(offsets.windows(2)) {
                let copies = &self.positions[range[0] as usize..range[1] as usize];
                let ahead = range[1] as usize + AHEAD;
                let later = &self.positions[ahead.min(self.positions.len())..];
                for &position in later.iter().take(copies.len()) {
                    simd::prefetch_at(local, position as usize);
                }
                take(target, sum_of(local, copies));
            }
        };
        if y.len() < ALONE * PIECE * C {
            let pieces = y.chunks_mut(PIECE * C).enumerate();
            pieces.for_each(|(piece, part)| of_piece(piece, part));
        } else {
            parallel::each(Pieces::of(y, PIECE * C), 1, &of_piece);
        }
    }
}

#[inline(always)]
fn sum_of<R: Scalar>(local: &[Row<R>], copies: &[u32]) -> Row<R> {
    let mut sum = [R::default(); 4];
    for &position in copies {
        let row = &local[position as usize];
        let before = sum;
        sum = std::array::from_fn(|i| before[i] + row[i]);
    }
    sum
}
