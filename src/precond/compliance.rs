//! The metric of the contact pressure: the dense compliance
//! K = 0.7 (C1 A11^-1 C1^T + C2 D22^-1 C2^T) of the contact surface.
//!
//! C1, C2: the coupling's columns at vertices and edges; A11^-1 only on the
//! contact vertices and along the normals of the surfaces that meet there, which is
//! what a metric needs where the obstacle's normals are not far from them; D22: node blocks of
//! the edges (of all nodes for quadratic multipliers). The edge part keeps the metric regular where the rim of the surface
//! is held. The factor brings the largest eigenvalue against the incompressible
//! body near one. Condition 2 to 3, independent of the mesh size. Cost O(m^2) for
//! m multipliers.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use rayon::prelude::*;

use super::NodeBlocks;
use super::p1::Traces;
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows};

/// Factor on the whole compliance, which brings its largest eigenvalue against the
/// incompressible body near one.
const SCALE: f64 = 0.7;
/// Keeps doubled or redundant constraints solvable.
const REGULARISATION: f64 = 1e-10;

/// What the compliance is made of.
pub struct ComplianceParts<'a> {
    /// A11^-1 between the traces `[traces, traces]`, non-dimensional.
    pub vertex_inverse: &'a DenseMatrix,
    /// Contact vertices with the directions in which their compliance is known.
    pub traces: Traces<'a>,
    /// Inverted Lagrange node blocks of all nodes, for the part of the edges.
    pub node_blocks: &'a NodeBlocks,
    /// Number of vertices: nodes below are vertices, the others edges.
    pub vertex_count: usize,
    /// Ends of each edge `[edges]`, where multipliers are quadratic: they see what
    /// single vertices do, too.
    pub edge_ends: Option<&'a [[u32; 2]]>,
}

/// K of `coupling` `[multipliers, unknowns]`.
pub fn compliance(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> DenseMatrix {
    let size = coupling.rows();
    let vertex_rows = vertex_rows(parts, coupling);
    let mut matrix = DenseMatrix::zeros(size, size);
    let columns: Vec<Vec<f64>> = (0..size)
        .into_par_iter()
        .map(|j| {
            let mut flexibility = vec![0.0; parts.vertex_inverse.rows()];
            for &(unknown, value) in &vertex_rows[j] {
                let column = parts.vertex_inverse.column(unknown as usize);
                for (sum, entry) in flexibility.iter_mut().zip(column) {
                    *sum += value * entry;
                }
            }
            let product = |row: &Vec<(u32, f64)>| -> f64 {
                row.iter()
                    .map(|&(k, value)| value * flexibility[k as usize])
                    .sum()
            };
            vertex_rows.iter().map(product).collect()
        })
        .collect();
    for (j, column) in columns.iter().enumerate() {
        matrix.column_mut(j).copy_from_slice(column);
    }
    let touching = match parts.edge_ends {
        Some(ends) => at_all_nodes(parts, coupling, ends),
        None => at_edges(parts, coupling),
    };
    add_nodes(parts, &touching, &mut matrix);
    finish(&mut matrix);
    matrix
}

/// Rows of the coupling on the traces: trace and what of the row lies along it. The
/// directions of a vertex are orthogonal where it has several.
fn vertex_rows(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> Vec<Vec<(u32, f64)>> {
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

/// What each row does at the nodes that move alone, in the Lagrange basis: rows
/// ascending, by node.
type AtNodes = BTreeMap<u32, Vec<(usize, [f64; 3])>>;

/// The rows at the edges.
fn at_edges(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> AtNodes {
    let c = parts.node_blocks.components();
    let mut touching = AtNodes::new();
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        for (&unknown, &value) in columns.iter().zip(values) {
            let (node, i) = (unknown / c as u32, unknown as usize % c);
            if (node as usize) >= parts.vertex_count {
                add_at(&mut touching, (node, row), i, value);
            }
        }
    }
    touching
}

/// The rows at the edges, and at the vertices less half of those at their edges: a
/// vertex that moves alone leaves the midpoints where they are.
fn at_all_nodes(parts: &ComplianceParts<'_>, coupling: &SparseRows, ends: &[[u32; 2]]) -> AtNodes {
    let c = parts.node_blocks.components();
    let mut touching = AtNodes::new();
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        for (&unknown, &value) in columns.iter().zip(values) {
            let (node, i) = (unknown / c as u32, unknown as usize % c);
            add_at(&mut touching, (node, row), i, value);
            if let Some(edge) = (node as usize).checked_sub(parts.vertex_count) {
                for &end in &ends[edge] {
                    add_at(&mut touching, (end, row), i, -0.5 * value);
                }
            }
        }
    }
    touching
}

fn add_at(touching: &mut AtNodes, (node, row): (u32, usize), component: usize, value: f64) {
    let rows = touching.entry(node).or_default();
    if rows.last().is_none_or(|last| last.0 != row) {
        rows.push((row, [0.0; 3]));
    }
    if let Some(last) = rows.last_mut() {
        last.1[component] += value;
    }
}

/// Adds C D^-1 C^T of the nodes that move alone.
fn add_nodes(parts: &ComplianceParts<'_>, touching: &AtNodes, matrix: &mut DenseMatrix) {
    let c = parts.node_blocks.components();
    for (node, rows) in touching {
        let block = parts.node_blocks.block(*node as usize);
        for (row, a) in rows {
            for (column, b) in rows {
                let mut sum = 0.0;
                for i in 0..c {
                    for j in 0..c {
                        sum += a[i] * block[i * c + j] * b[j];
                    }
                }
                *matrix.at_mut(*row, *column) += sum;
            }
        }
    }
}

/// Scales, makes exactly symmetric, regularises.
fn finish(matrix: &mut DenseMatrix) {
    let size = matrix.rows();
    let trace: f64 = (0..size).map(|i| matrix.at(i, i)).sum();
    let lift = REGULARISATION * SCALE * trace / size.max(1) as f64;
    for j in 0..size {
        for i in 0..j {
            let mean = 0.5 * SCALE * (matrix.at(i, j) + matrix.at(j, i));
            *matrix.at_mut(i, j) = mean;
            *matrix.at_mut(j, i) = mean;
        }
        let diagonal = SCALE * matrix.at(j, j) + lift;
        *matrix.at_mut(j, j) = diagonal;
    }
}
