//! What volume takes off the compliance of a body's contact surface:
//!
//! ```text
//! K~ = C Y C^T - W^T G^-1 W,   Y = P A11^-1 P^T + D^-1,   w_k = C Y b_k
//! ```
//!
//! b_k = B^T z_k: the change of the volume that the pressures z_k weigh `[displacement]`:
//! that of a connected part (z = 1), and where a body is thin those of its stretches;
//! G_jk = b_j.Y b_k + z_j.S z_k `[modes, modes]`. S is the volume over the bulk
//! modulus, zero where the body is incompressible. Without these terms a closed body seems
//! to give way under an even pressure and a thin bonded one to let its volume pass below
//! the contact, and the condition of K grows like the bulk over the shear modulus, or like
//! the square of length over thickness. It is positive definite where S is above zero;
//! `FLOOR` keeps it so. The stretches are local, and stay so: z, b and D^-1 b are sparse, and
//! of A11^-1 P^T b only what contact sees is kept. Cost: one P1 solve a mode, some at a time,
//! and m^3 / 3 flops for m modes.

use super::NodeBlocks;
use super::p1::Traces;
use crate::linalg::vector::dot;
use crate::linalg::{
    DenseMatrix, GramFactor, LinearOperator, Preconditioner, SparseRows, SparseRowsBuilder,
    Workspace,
};
use crate::parallel::{self, Scratch};

/// Least s over b^T Y b: a P1 factor in single precision knows the difference no better.
const FLOOR: f64 = 1e-5;
/// Rows with more than one entry in so many columns are summed entry by entry and not sorted.
const DENSE: usize = 8;
/// P1 solves at a time.
const PANEL: usize = 16;

/// Y b of all modes with their numbers.
#[derive(Clone, Debug, Default)]
pub struct VolumeModes {
    /// z: of a part one at its own `[modes, pressures]`.
    pub pressures: SparseRows,
    /// A11^-1 P^T b along each trace `[modes][traces]`.
    pub p1_part: Vec<Vec<f64>>,
    /// D^-1 b in the Lagrange basis `[modes, displacement]`: nodes that move alone.
    pub nodal_part: SparseRows,
    /// G `[modes, modes]`, volumes over a modulus.
    pub work: DenseMatrix,
    /// Its factor.
    pub factor: GramFactor,
}

/// What Y is made of.
pub struct Flexibility<'a> {
    /// A11^-1 `[vertex unknowns]`.
    pub p1: &'a dyn Preconditioner,
    /// Where contact sees A11^-1.
    pub traces: Traces<'a>,
    /// Inverted Lagrange node blocks of all nodes.
    pub node_blocks: &'a NodeBlocks,
    /// Number of vertices: nodes below are vertices, the others edges.
    pub vertex_count: usize,
    /// Ends of each edge `[edges]`, where vertices that move alone count, too; see
    /// [`super::compliance`].
    pub edge_ends: Option<&'a [[u32; 2]]>,
    /// Which unknowns are prescribed `[displacement]`.
    pub is_held: &'a [bool],
}

/// What the modes do to the body, in its parts.
struct Loads<'a> {
    /// B^T z in the hierarchical basis `[modes, displacement]`.
    changes: &'a SparseRows,
    /// The same on nodes that move alone.
    forces: SparseRows,
    /// S z `[modes, pressures]`; none where the body is incompressible.
    slacks: Option<&'a SparseRows>,
}

/// One column of G, and what contact sees of the mode.
struct Column {
    work: Vec<f64>,
    p1_part: Vec<f64>,
}

impl VolumeModes {
    /// Of these `pressures` `[modes, pressures]`, that change volumes by `changes` in the
    /// hierarchical basis `[modes, displacement]` and take `slacks`, their products with S
    /// `[modes, pressures]`.
    pub fn new(
        flexibility: &Flexibility<'_>,
        pressures: SparseRows,
        (changes, slacks): (&SparseRows, Option<&SparseRows>),
    ) -> Self {
        let forces = flexibility.on_nodes(changes);
        let nodal_part = flexibility.nodal_part(&forces);
        let loads = Loads {
            changes,
            forces,
            slacks,
        };
        let modes: Vec<usize> = (0..pressures.rows()).collect();
        let scratch = Scratch::new(&Workspace::new);
        let panels: Vec<Vec<Column>> = parallel::map(modes.len().div_ceil(PANEL), 1, &|k| {
            let panel = &modes[k * PANEL..modes.len().min((k + 1) * PANEL)];
            scratch.lend(|work| flexibility.columns(panel, (&loads, &nodal_part, &pressures), work))
        });
        let mut work = DenseMatrix::zeros(modes.len(), modes.len());
        let mut p1_part = Vec::with_capacity(modes.len());
        for (mode, column) in panels.into_iter().flatten().enumerate() {
            work.column_mut(mode).copy_from_slice(&column.work);
            p1_part.push(column.p1_part);
        }
        Self {
            factor: GramFactor::new(&work),
            pressures,
            p1_part,
            nodal_part,
            work,
        }
    }

    /// Number of modes.
    pub fn count(&self) -> usize {
        self.p1_part.len()
    }
}

impl Flexibility<'_> {
    /// The columns of G of the modes in `panel`.
    fn columns(
        &self,
        panel: &[usize],
        (loads, nodal_part, pressures): (&Loads<'_>, &SparseRows, &SparseRows),
        work: &mut Workspace,
    ) -> Vec<Column> {
        let p1_size = self.vertex_count * self.node_blocks.components();
        let size = loads.changes.columns();
        let mut changes = work.zeros(p1_size * panel.len());
        let mut whole = work.zeros(size);
        for (change, &mode) in changes.chunks_exact_mut(p1_size).zip(panel) {
            whole.fill(0.0);
            loads.changes.add_row(mode, 1.0, &mut whole);
            change.copy_from_slice(&whole[..p1_size]);
        }
        let mut p1_part = work.zeros(changes.len());
        self.p1
            .apply_to_all(&changes, &mut p1_part, panel.len(), work);
        work.give(changes);
        let mut moved = work.zeros(size);
        let mut slack = work.zeros(pressures.columns());
        let mut columns = Vec::with_capacity(panel.len());
        for (p1_part, &mode) in p1_part.chunks_exact(p1_size).zip(panel) {
            whole.fill(0.0);
            whole[..p1_size].copy_from_slice(p1_part);
            moved.fill(0.0);
            nodal_part.add_row(mode, 1.0, &mut moved);
            slack.fill(0.0);
            if let Some(slacks) = loads.slacks {
                slacks.add_row(mode, 1.0, &mut slack);
            }
            let own = |other: usize| {
                loads.changes.row_product(other, &whole) + loads.forces.row_product(other, &moved)
            };
            let mut column: Vec<f64> = (0..pressures.rows())
                .map(|other| own(other) + pressures.row_product(other, &slack))
                .collect();
            let by_itself = own(mode);
            column[mode] = by_itself + pressures.row_product(mode, &slack).max(FLOOR * by_itself);
            columns.push(Column {
                work: column,
                p1_part: self.along_traces(p1_part),
            });
        }
        [p1_part, moved, slack, whole]
            .into_iter()
            .for_each(|vector| work.give(vector));
        columns
    }

    /// A motion of the vertices along each trace.
    fn along_traces(&self, p1_part: &[f64]) -> Vec<f64> {
        let c = self.node_blocks.components();
        let pairs = self.traces.vertices.iter().zip(self.traces.directions);
        let along = |(&vertex, direction): (&u32, &[f64; 3])| {
            let first = vertex as usize * c;
            dot(&direction[..c], &p1_part[first..first + c])
        };
        pairs.map(along).collect()
    }

    /// The loads on nodes that move alone: at a vertex less half of those at its edges.
    fn on_nodes(&self, loads: &SparseRows) -> SparseRows {
        let c = self.node_blocks.components();
        let first_edge = self.vertex_count * c;
        let mut builder = SparseRowsBuilder::new(loads.columns());
        let (mut entries, mut whole) = (Vec::new(), Vec::new());
        for mode in 0..loads.rows() {
            entries.clear();
            let (unknowns, values) = loads.row(mode);
            for (&unknown, &value) in unknowns.iter().zip(values) {
                let edge = (unknown as usize).checked_sub(first_edge);
                match (edge, self.edge_ends) {
                    (None, None) => {}
                    (None, Some(_)) | (Some(_), None) => entries.push((unknown, value)),
                    (Some(edge), Some(ends)) => {
                        entries.push((unknown, value));
                        let (edge, i) = (edge / c, (edge % c) as u32);
                        entries.extend(ends[edge].map(|end| (end * c as u32 + i, -0.5 * value)));
                    }
                }
            }
            entries.retain(|&(unknown, _)| !self.is_held[unknown as usize]);
            if entries.len() < loads.columns() / DENSE {
                builder.push_row(&mut entries)
            } else {
                whole.resize(loads.columns(), 0.0);
                whole.fill(0.0);
                (entries.iter()).for_each(|&(unknown, value)| whole[unknown as usize] += value);
                builder.push_dense(&whole, 0.0);
            }
        }
        builder.finish()
    }

    /// D^-1 `forces`, node by node, nodes of a line with those that they move.
    fn nodal_part(&self, forces: &SparseRows) -> SparseRows {
        let c = self.node_blocks.components();
        let mut builder = SparseRowsBuilder::new(forces.columns());
        let mut entries = Vec::new();
        for mode in 0..forces.rows() {
            entries.clear();
            let (unknowns, values) = forces.row(mode);
            let mut last = None;
            for (&unknown, &value) in unknowns.iter().zip(values) {
                let (node, j) = (unknown as usize / c, unknown as usize % c);
                if last.replace(node) != Some(node) {
                    entries.extend((0..c).map(|i| ((node * c + i) as u32, 0.0)));
                }
                let block = self.node_blocks.block(node);
                let first = entries.len() - c;
                for (i, entry) in entries[first..].iter_mut().enumerate() {
                    entry.1 += block[i * c + j] * value;
                }
            }
            for (&unknown, &value) in unknowns.iter().zip(values) {
                let (node, j) = (unknown as usize / c, unknown as usize % c);
                for ([_, other], block) in self.node_blocks.pairs_of(node as u32) {
                    let moved = (0..c).map(|i| (other * c as u32 + i as u32, block[j * c + i]));
                    entries.extend(moved.map(|(unknown, share)| (unknown, share * value)));
                }
            }
            builder.push_row(&mut entries);
        }
        builder.finish()
    }
}
