//! The metric of the contact pressure: the dense compliance
//! K = s (C1 A11^-1 C1^T + C2 D22^-1 C2^T) of the contact surface.
//!
//! C1, C2: the coupling's columns at vertices and edges; A11^-1 only on the
//! contact vertices and along the normals of the surfaces that meet there, which is
//! what a metric needs where the obstacle's normals are not far from them; D22: node blocks of
//! the edges (of all nodes for quadratic multipliers), in flat cells with the lines of nodes that
//! they move along ([`super::lines`]). The edge part keeps the metric regular where the rim of the surface
//! is held. The factor s keeps K above half of C A^-1 C^T: by a smaller one a projected step goes
//! further than its energy falls, and sides alternate. What a volume that hardly changes forbids is taken off
//! ([`super::volume_modes`]). Condition 2 to 4, independent of the mesh size. Only the inverse at the vertices is
//! dense; a part on the closed multipliers is factorised by its parts where it touches few
//! vertices for its size (`split`), else formed. Cost:
//! O(v^2) a product, O(n v + n^2) a part of n multipliers, for v contact vertices.

mod nodes;
mod part;
mod seen;
mod split;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nodes::{at_all_nodes, at_edges, of_nodes};
use part::Known;
use seen::seen_of;
use split::SplitFactor;

use super::NodeBlocks;
use super::p1::Traces;
use super::volume_modes::VolumeModes;
use crate::linalg::vector::{dot, scale};
use crate::linalg::{
    DenseCholesky, DenseMatrix, FactoriseError, LinearOperator, PartFactor, SparseRows,
    SparseRowsBuilder, SymmetricMatrix, Workspace,
};

/// s for a body with internal pressure, which halves C A^-1 C^T: 12 x 12 x 3 cells of a cube under a
/// lid take 33 applications by 0.7, 29 by this, 26 by 1.4; a ball of rubber 260, 272 and 347.
pub const OF_MIXED: f64 = 0.85;
/// s for a body of displacements alone: C A^-1 C^T is up to 2.5 times the sum of its parts in cubes,
/// 3.5 of 0.7 times it in tall cells. 20 x 20 x 2 cells of a cube under a lid, quadratic pressures,
/// take 33 applications, by 1.0 592, by 0.7 more than 600; 7^3 take 20, 19 and 21.
pub const OF_DISPLACEMENT: f64 = 1.4;
/// Compliance under an even pressure over the sum of its parts: 0.95 on a bonded cube of Poisson ratio
/// 0.3, 0.56 on an incompressible one. What the search for a pushed pose starts from lies between.
pub const EVENLY: f64 = 0.7;
/// Rows of the largest part that is formed, two gigabytes with its factor.
const MOST_FORMED: usize = 11_000;
/// Parts that are kept: pivots and faces come back to sides that they left a few steps ago.
const MOST_PARTS: usize = 4;
/// Bytes of all of them, but for the latest, which stays whatever it takes.
const MOST_KEPT: u64 = 1 << 28;
/// Keeps doubled or redundant constraints solvable.
const REGULARISATION: f64 = 1e-10;

/// What the compliance is made of.
pub struct ComplianceParts<'a> {
    /// A11^-1 between the traces `[traces, traces]`, non-dimensional.
    pub vertex_inverse: &'a Arc<DenseMatrix>,
    /// Contact vertices with the directions in which their compliance is known.
    pub traces: Traces<'a>,
    /// How each Lagrange node moves under a load on it, for the part of the edges.
    pub node_blocks: &'a NodeBlocks,
    /// Number of vertices: nodes below are vertices, the others edges.
    pub vertex_count: usize,
    /// Ends of each edge `[edges]`, where multipliers are quadratic: they see what
    /// single vertices do, too.
    pub edge_ends: Option<&'a [[u32; 2]]>,
    /// Which unknowns are prescribed `[displacement]`.
    pub is_held: &'a [bool],
    /// What volumes take off; none where none do.
    pub volumes: Option<&'a VolumeModes>,
    /// s: [`OF_MIXED`] or [`OF_DISPLACEMENT`].
    pub scale: f64,
}

/// K, kept as its parts: the inverse at the contact vertices, a sparse matrix, and one
/// rank a volume.
pub struct Compliance {
    /// A11^-1 between the traces `[traces, traces]`.
    vertex_inverse: Arc<DenseMatrix>,
    /// C1: each row on the traces `[multipliers]`.
    vertex_rows: Vec<Vec<(u32, f64)>>,
    /// C D^-1 C^T of nodes that move alone `[multipliers, multipliers]`.
    nodes: SparseRows,
    /// What the rows see of the volumes made orthonormal, L^-1 W `[volumes, multipliers]`.
    volumes: DenseMatrix,
    /// W, what the rows see of each, without next to nothing `[volumes, multipliers]`.
    seen: SparseRows,
    /// Added to the diagonal, so that redundant constraints have a solution.
    lift: f64,
    /// s.
    scale: f64,
    /// The diagonal, once it was asked for.
    diagonal: OnceLock<Vec<f64>>,
    /// The parts that were asked for last, the latest at the end.
    last: Mutex<Vec<Part>>,
    /// The inverse of what is known at the vertices that such a part last touched.
    stiffness: Mutex<Option<Stiffness>>,
    /// The largest part that was asked for by entries; empty without friction.
    known: Mutex<Known>,
}

/// A principal part with its factor.
struct Part {
    /// Rows of the part, ascending.
    selected: Vec<usize>,
    /// Its factor.
    factor: Arc<dyn PartFactor>,
}

/// The inverse of a principal part of the inverse at the vertices.
struct Stiffness {
    /// Traces of the part, ascending.
    traces: Vec<u32>,
    /// Its inverse.
    inverse: Arc<DenseMatrix>,
}

impl Compliance {
    /// K of `coupling` `[multipliers, unknowns]`.
    pub fn new(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> Self {
        let vertex_rows = vertex_rows(parts, coupling);
        let touching = match parts.edge_ends {
            Some(ends) => at_all_nodes(parts, coupling, ends),
            None => at_edges(parts, coupling),
        };
        let (volumes, seen) = match parts.volumes {
            Some(volumes) => seen_of(parts, (&vertex_rows, &touching), volumes),
            None => (
                DenseMatrix::zeros(0, coupling.rows()),
                SparseRowsBuilder::new(coupling.rows()).finish(),
            ),
        };
        let mut out = Self {
            vertex_inverse: parts.vertex_inverse.clone(),
            nodes: of_nodes(parts, &touching, coupling.rows()),
            volumes,
            seen,
            vertex_rows,
            lift: 0.0,
            scale: parts.scale,
            diagonal: OnceLock::new(),
            last: Mutex::default(),
            stiffness: Mutex::new(None),
            known: Mutex::default(),
        };
        let size = coupling.rows();
        let trace: f64 = (0..size).map(|i| out.entry(i, i)).sum();
        out.lift = REGULARISATION * trace / size.max(1) as f64;
        out
    }

    /// What the rows see of each volume, without next to nothing `[volumes, multipliers]`.
    pub fn seen(&self) -> &SparseRows {
        &self.seen
    }

    /// The inverse of what is known at some traces; none where it is not positive definite.
    fn stiffness_at(&self, traces: &[u32]) -> Option<Arc<DenseMatrix>> {
        let mut kept = self
            .stiffness
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = kept.as_ref().filter(|kept| kept.traces == traces) {
            return Some(kept.inverse.clone());
        }
        let places: Vec<usize> = traces.iter().map(|&trace| trace as usize).collect();
        let factor = DenseCholesky::new(&self.vertex_inverse.principal(&places)).ok()?;
        let inverse = Arc::new(factor.inverse());
        *kept = Some(Stiffness {
            traces: traces.to_vec(),
            inverse: inverse.clone(),
        });
        Some(inverse)
    }

    /// What the inverse at the vertices gives between two rows.
    fn through_vertices(&self, row: usize, flexibility: &[f64]) -> f64 {
        let entries = self.vertex_rows[row].iter();
        entries
            .map(|&(trace, value)| value * flexibility[trace as usize])
            .sum()
    }

    /// What the volumes take off between two rows.
    fn through_volumes(&self, row: usize, column: usize) -> f64 {
        dot(self.volumes.column(row), self.volumes.column(column))
    }

    /// One entry, A11^-1 through the traces of both rows alone.
    fn entry_of(&self, row: usize, column: usize) -> f64 {
        let flexibility = |trace: u32| {
            let own = self.vertex_rows[column].iter();
            own.fold(0.0, |sum, &(other, value)| {
                sum + value * self.vertex_inverse.at(trace as usize, other as usize)
            })
        };
        let traces = self.vertex_rows[row].iter();
        let smooth: f64 = traces.map(|&(t, value)| value * flexibility(t)).sum();
        let mut entry = smooth - self.through_volumes(row, column);
        let (rows, values) = self.nodes.row(column);
        if let Ok(at) = rows.binary_search(&(row as u32)) {
            entry += values[at];
        }
        if row == column {
            entry += self.lift;
        }
        entry * self.scale
    }
}

impl SymmetricMatrix for Compliance {
    fn size(&self) -> usize {
        self.vertex_rows.len()
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        self.entry_of(row.max(column), row.min(column))
    }

    fn diagonal(&self) -> Vec<f64> {
        let entries = || (0..self.size()).map(|i| self.entry(i, i)).collect();
        self.diagonal.get_or_init(entries).clone()
    }

    fn product(&self, x: &[f64], y: &mut [f64]) {
        let mut work = Workspace::new();
        let mut on_traces = vec![0.0; self.vertex_inverse.rows()];
        for (row, &factor) in self.vertex_rows.iter().zip(x) {
            for &(trace, value) in row {
                on_traces[trace as usize] += factor * value;
            }
        }
        let mut flexibility = vec![0.0; on_traces.len()];
        self.vertex_inverse.multiply(&on_traces, &mut flexibility);
        self.nodes.apply(x, y, &mut work);
        for (row, sum) in y.iter_mut().enumerate() {
            *sum += self.through_vertices(row, &flexibility) + self.lift * x[row];
        }
        if self.volumes.rows() > 0 {
            let mut shares = vec![0.0; self.volumes.rows()];
            self.volumes.multiply(x, &mut shares);
            for (row, sum) in y.iter_mut().enumerate() {
                *sum -= dot(self.volumes.column(row), &shares);
            }
        }
        scale(y, self.scale);
    }

    fn principal_part(&self, selected: &[usize]) -> DenseMatrix {
        self.part_beside(selected, &Known::default())
    }

    fn part_again(&self, selected: &[usize]) -> DenseMatrix {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let is_known = |row: &usize| known.selected.binary_search(row).is_ok();
        if !selected.iter().all(is_known) {
            let mut all: Vec<usize> = known.selected.iter().chain(selected).copied().collect();
            all.sort_unstable();
            all.dedup();
            let matrix = self.part_beside(&all, &known);
            *known = Known {
                selected: all,
                matrix,
            };
        }
        let place = |row: &usize| known.selected.partition_point(|other| other < row);
        let places: Vec<usize> = selected.iter().map(place).collect();
        known.matrix.principal(&places)
    }

    fn factor_of_part(&self, selected: &[usize]) -> Result<Arc<dyn PartFactor>, FactoriseError> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = last.iter().position(|part| part.selected == selected) {
            last[place..].rotate_left(1);
            return Ok(last[last.len() - 1].factor.clone());
        }
        let factor: Arc<dyn PartFactor> = match SplitFactor::new(self, selected) {
            Some(split) => Arc::new(split),
            None if selected.len() > MOST_FORMED => return Err(FactoriseError::OutOfMemory),
            None => Arc::new(DenseCholesky::new(&self.principal_part(selected))?),
        };
        last.push(Part {
            selected: selected.to_vec(),
            factor: factor.clone(),
        });
        let bytes = |last: &[Part]| last.iter().map(|part| part.factor.bytes()).sum::<u64>();
        while last.len() > 1 && (last.len() > MOST_PARTS || bytes(&last[..]) > MOST_KEPT) {
            last.remove(0);
        }
        Ok(factor)
    }
}

/// Rows of the coupling on the traces: trace and what of the row lies along it. The
/// directions of a vertex are orthogonal where it has several.
fn vertex_rows(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> Vec<TraceRow> {
    let c = parts.node_blocks.components() as u32;
    let mut traces_of: HashMap<u32, Range<u32>> = HashMap::new();
    for (trace, &vertex) in (0..).zip(parts.traces.vertices) {
        let own = traces_of.entry(vertex).or_insert(trace..trace);
        own.end = trace + 1;
    }
    let row = |row: usize| {
        let (columns, values) = coupling.row(row);
        let mut entries: Vec<(u32, f64)> = Vec::new();
        let mut last = u32::MAX;
        for (&unknown, &value) in columns.iter().zip(values) {
            let Some(own) = traces_of.get(&(unknown / c)) else {
                continue;
            };
            if unknown / c != last {
                entries.extend(own.clone().map(|trace| (trace, 0.0)));
                last = unknown / c;
            }
            let first = entries.len() - own.len();
            for (trace, sum) in &mut entries[first..] {
                let direction = parts.traces.directions[*trace as usize];
                *sum += value * direction[unknown as usize % c as usize];
            }
        }
        entries
    };
    (0..coupling.rows()).map(row).collect()
}

/// What one row sees of the traces at the vertices: their numbers and its entries there.
type TraceRow = Vec<(u32, f64)>;

#[cfg(test)]
mod tests;
