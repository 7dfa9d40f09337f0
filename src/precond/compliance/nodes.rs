//! The part of nodes that move alone: C D^-1 C^T, D their blocks.

use super::ComplianceParts;
use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, SparseRows, SparseRowsBuilder};
use crate::parallel::{self, Scratch};

/// What each row does at one node that moves alone, in the Lagrange basis: rows ascending.
pub(super) type AtNode = Vec<(usize, [f64; 3])>;

/// What the rows do at the nodes that move alone.
#[derive(Default)]
struct AtNodes {
    /// Place of each node in `list`, plus one; zero where no row touches it.
    places: Vec<u32>,
    /// Nodes with what the rows do there.
    list: Vec<(u32, AtNode)>,
}

impl AtNodes {
    fn add(&mut self, (node, row): (u32, usize), component: usize, value: f64) {
        if self.places.len() <= node as usize {
            self.places.resize(node as usize + 1, 0);
        }
        let place = &mut self.places[node as usize];
        if *place == 0 {
            self.list.push((node, Vec::new()));
            *place = self.list.len() as u32;
        }
        let rows = &mut self.list[*place as usize - 1].1;
        if rows.last().is_none_or(|last| last.0 != row) {
            rows.push((row, [0.0; 3]));
        }
        if let Some(last) = rows.last_mut() {
            last.1[component] += value;
        }
    }

    /// All of them, nodes ascending.
    fn sorted(mut self) -> Vec<(u32, AtNode)> {
        self.list.sort_unstable_by_key(|(node, _)| *node);
        self.list
    }
}

/// The rows at the edges.
pub(super) fn at_edges(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> Vec<(u32, AtNode)> {
    let c = parts.node_blocks.components();
    let mut touching = AtNodes::default();
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        for (&unknown, &value) in columns.iter().zip(values) {
            let (node, i) = (unknown / c as u32, unknown as usize % c);
            if (node as usize) >= parts.vertex_count {
                touching.add((node, row), i, value);
            }
        }
    }
    touching.sorted()
}

/// The rows at the edges, and at the vertices less half of those at their edges: a
/// vertex that moves alone leaves the midpoints where they are.
pub(super) fn at_all_nodes(
    parts: &ComplianceParts<'_>,
    coupling: &SparseRows,
    ends: &[[u32; 2]],
) -> Vec<(u32, AtNode)> {
    let c = parts.node_blocks.components();
    let mut touching = AtNodes::default();
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        for (&unknown, &value) in columns.iter().zip(values) {
            let (node, i) = (unknown / c as u32, unknown as usize % c);
            touching.add((node, row), i, value);
            if let Some(edge) = (node as usize).checked_sub(parts.vertex_count) {
                for &end in &ends[edge] {
                    if !parts.is_held[end as usize * c + i] {
                        touching.add((end, row), i, -0.5 * value);
                    }
                }
            }
        }
    }
    touching.sorted()
}

/// C D^-1 C^T of the nodes that move alone `[size, size]`; each row on its own.
pub(super) fn of_nodes(
    parts: &ComplianceParts<'_>,
    touching: &[(u32, AtNode)],
    size: usize,
) -> SparseRows {
    let c = parts.node_blocks.components();
    let mut touched_by: Vec<Vec<(usize, [f64; 3])>> = vec![Vec::new(); size];
    for (place, (_, touched)) in touching.iter().enumerate() {
        for &(row, a) in touched {
            touched_by[row].push((place, a));
        }
    }
    let moved: Vec<AtNode> = parallel::map(touching.len(), 1, &|place| {
        let (node, touched) = &touching[place];
        let own = parts.node_blocks.block(*node as usize);
        let mut moved: AtNode = Vec::new();
        let mut add = |block: &[f64; 9], touched: &AtNode| {
            moved.extend(touched.iter().map(|(row, b)| (*row, motion(block, b, c))));
        };
        add(&own, touched);
        for ([_, other], block) in parts.node_blocks.pairs_of(*node) {
            if let Ok(place) = touching.binary_search_by_key(other, |(node, _)| *node) {
                add(block, &touching[place].1);
            }
        }
        moved
    });
    let fresh = || vec![None; size];
    let scratch = Scratch::new(&fresh);
    let entries: Vec<Vec<(u32, f64)>> = parallel::map(size, 1, &|row| {
        scratch.lend(|sums| row_of_nodes(sums, (&touched_by[row], &moved), c))
    });
    let mut builder = SparseRowsBuilder::new(size);
    for mut row in entries {
        builder.push_row(&mut row);
    }
    builder.finish()
}

/// `block` times `b`.
fn motion(block: &[f64; 9], b: &[f64; 3], c: usize) -> [f64; 3] {
    let mut motion = [0.0; 3];
    for (i, value) in motion.iter_mut().take(c).enumerate() {
        *value = dot(&block[i * c..(i + 1) * c], &b[..c]);
    }
    motion
}

/// One row of C D^-1 C^T from what it does at its nodes, and how these move with each row;
/// `sums` is empty before and after it `[size]`.
fn row_of_nodes(
    sums: &mut [Option<f64>],
    (own, moved): (&[(usize, [f64; 3])], &[AtNode]),
    c: usize,
) -> Vec<(u32, f64)> {
    let mut columns = Vec::new();
    for (place, a) in own {
        for (column, motion) in &moved[*place] {
            let product: f64 = (0..c).map(|i| a[i] * motion[i]).sum();
            match &mut sums[*column] {
                Some(sum) => *sum += product,
                empty => {
                    *empty = Some(0.0 + product);
                    columns.push(*column as u32);
                }
            }
        }
    }
    columns.sort_unstable();
    let taken = columns.into_iter().map(|column| {
        let sum = sums[column as usize].take();
        (column, sum.unwrap_or_default())
    });
    taken.collect()
}
