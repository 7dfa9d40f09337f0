//! Splits the cells into blocks by recursive bisection of their centroids.
//!
//! A block reads and writes its own copy of the nodes it touches; a second pass
//! sums the copies of each node in block order. Blocks run on any thread, and
//! the order of every sum depends on the mesh only.

use crate::mesh::Mesh;

/// Largest number of cells in a block: its vectors stay in the second-level
/// cache, and two threads have enough blocks to share.
const BLOCK_CELLS: usize = 1536;

/// Cells of each block, ascending inside a block, those with curved edges last.
pub fn blocks_of_cells(mesh: &Mesh) -> Vec<Vec<u32>> {
    let vertices = mesh.cell_kind().vertices();
    let centroids: Vec<[f64; 3]> = mesh
        .cells()
        .chunks_exact(vertices)
        .map(|cell| {
            let mut sum = [0.0; 3];
            for &vertex in cell {
                let point = mesh.coordinates()[vertex as usize];
                for axis in 0..3 {
                    sum[axis] += point[axis];
                }
            }
            sum
        })
        .collect();
    let mut all: Vec<u32> = (0..centroids.len() as u32).collect();
    let mut blocks = Vec::new();
    bisect(&centroids, &mut all, &mut blocks);
    if !mesh.edge_offsets().is_empty() {
        let is_curved = |cell: &u32| mesh.offsets_of_cell(*cell as usize).is_some();
        for block in &mut blocks {
            block.sort_by_cached_key(|cell| (is_curved(cell), *cell));
        }
    }
    blocks
}

fn bisect(centroids: &[[f64; 3]], cells: &mut [u32], blocks: &mut Vec<Vec<u32>>) {
    if cells.len() <= BLOCK_CELLS {
        let mut block = cells.to_vec();
        block.sort_unstable();
        blocks.push(block);
        return;
    }
    let axis = longest_axis(centroids, cells);
    let middle = cells.len() / 2;
    cells.select_nth_unstable_by(middle, |&a, &b| {
        centroids[a as usize][axis]
            .total_cmp(&centroids[b as usize][axis])
            .then(a.cmp(&b))
    });
    let (lower, upper) = cells.split_at_mut(middle);
    bisect(centroids, lower, blocks);
    bisect(centroids, upper, blocks);
}

fn longest_axis(centroids: &[[f64; 3]], cells: &[u32]) -> usize {
    let extent = |axis: usize| {
        let values = cells.iter().map(|&cell| centroids[cell as usize][axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        values.fold(f64::NEG_INFINITY, f64::max) - low
    };
    let extents = [extent(0), extent(1), extent(2)];
    // A later axis must be longer by more than rounding, so that a change of
    // units cannot turn the choice between equal extents.
    (1..3).fold(0, |best, axis| {
        if extents[axis] > extents[best] * (1.0 + 1e-9) {
            axis
        } else {
            best
        }
    })
}
