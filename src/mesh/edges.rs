//! The unique edges of all cells, and the edge behind each local edge.
//!
//! Pairs are found vertex by vertex from the cells around each; the edges of a
//! cell are then looked up among those of their lower ends. Cost: time
//! n log(valence); beside the results a few numbers, and four bytes per vertex
//! during the look-up.

use super::cell::CellKind;

/// Cells around a vertex up to which its neighbours are told apart one by one;
/// more are sorted.
const FEW_CELLS: usize = 64;
/// Edges of a lower end up to which all are compared; more are bisected.
const FEW_EDGES: usize = 16;

/// Collects the edges of one lower vertex after the other.
pub(super) struct EdgeCollector {
    /// Edges found so far, as ascending pairs of vertices in lexicographic order.
    pairs: Vec<[u32; 2]>,
    /// Higher ends of the edges of the present lower vertex, sorted before they are
    /// kept.
    higher: Vec<u32>,
}

impl EdgeCollector {
    /// Makes room for the edges of a mesh of one piece: by Euler's formula there
    /// are as many as vertices and cells, and half the facets of its boundary.
    pub(super) fn new(vertex_count: usize, cell_count: usize) -> Self {
        let inner = vertex_count + cell_count;
        Self {
            pairs: Vec::with_capacity(inner + inner / 16),
            higher: Vec::new(),
        }
    }

    /// Appends the edges from `vertex` to higher ones; `around` are the cells
    /// that have it.
    pub(super) fn add<'cells, const WIDTH: usize>(
        &mut self,
        vertex: u32,
        around: impl ExactSizeIterator<Item = &'cells [u32; WIDTH]>,
    ) {
        let higher = &mut self.higher;
        higher.clear();
        let is_few = around.len() <= FEW_CELLS;
        for &other in around.flatten() {
            if other > vertex && !(is_few && higher.contains(&other)) {
                higher.push(other);
            }
        }
        higher.sort_unstable();
        higher.dedup();
        self.pairs.extend(higher.iter().map(|&high| [vertex, high]));
    }

    /// (low, high) vertex pairs in lexicographic order.
    pub(super) fn finish(mut self) -> Vec<[u32; 2]> {
        self.pairs.shrink_to_fit();
        self.pairs
    }
}

/// Edge of each local edge, flat `[cells, 3 | 6]`; `pairs` are all edges of `cells`.
pub(super) fn edges_of_cells<const WIDTH: usize>(
    kind: CellKind,
    cells: &[[u32; WIDTH]],
    pairs: &[[u32; 2]],
    vertex_count: usize,
) -> Vec<u32> {
    let starts = starts(pairs, vertex_count);
    let mut edges = Vec::with_capacity(cells.len() * kind.edges().len());
    for cell in cells {
        edges.extend(kind.edges().iter().map(|&(first, second)| {
            let (low, high) = sorted_pair(cell[first], cell[second]);
            let start = starts[low as usize];
            let of_low = &pairs[start as usize..starts[low as usize + 1] as usize];
            start + place(of_low, high)
        }));
    }
    edges
}

/// First edge of each lower vertex `[vertices + 1]`.
fn starts(pairs: &[[u32; 2]], vertex_count: usize) -> Vec<u32> {
    let mut starts = vec![0; vertex_count + 1];
    for &[low, _] in pairs {
        starts[low as usize + 1] += 1;
    }
    for vertex in 0..vertex_count {
        starts[vertex + 1] += starts[vertex];
    }
    starts
}

/// Number of `pairs`, sorted, whose higher vertex is below `high`.
fn place(pairs: &[[u32; 2]], high: u32) -> u32 {
    if pairs.len() > FEW_EDGES {
        return pairs.partition_point(|pair| pair[1] < high) as u32;
    }
    pairs.iter().map(|pair| u32::from(pair[1] < high)).sum()
}

/// The two vertices in ascending order.
fn sorted_pair(first: u32, second: u32) -> (u32, u32) {
    (first.min(second), first.max(second))
}
