//! The metric of the contact pressure: the dense compliance
//! K = 0.7 (C1 A11^-1 C1^T + C2 D22^-1 C2^T) of the contact surface.
//!
//! C1, C2: the coupling's columns at vertices and edges; A11^-1 only on the
//! contact vertices and along the surface's normals, which is what a metric
//! needs where the obstacle's normals are not far from them; D22: node blocks of
//! the edges. The edge part keeps the metric regular where the rim of the surface
//! is held. The factor brings the largest eigenvalue against the incompressible
//! body near one. Condition 2 to 3, independent of the mesh size. Cost O(m^2) for
//! m multipliers.

use rayon::prelude::*;

use super::NodeBlocks;
use super::p1::Traces;
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows};

const SCALE: f64 = 0.7;
/// Keeps doubled or redundant constraints solvable.
const REGULARISATION: f64 = 1e-10;

/// What the compliance is made of.
pub struct ComplianceParts<'a> {
    /// A11^-1 on `traces`.
    pub vertex_inverse: &'a DenseMatrix,
    /// Contact vertices with their normals.
    pub traces: Traces<'a>,
    /// Inverted Lagrange node blocks of all nodes.
    pub node_blocks: &'a NodeBlocks,
    /// Nodes below are vertices, the others edges.
    pub vertex_count: usize,
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
    add_edges(parts, coupling, &mut matrix);
    finish(&mut matrix);
    matrix
}

/// Rows of the coupling on the traces: trace and sum over its direction.
fn vertex_rows(parts: &ComplianceParts<'_>, coupling: &SparseRows) -> Vec<Vec<(u32, f64)>> {
    let c = parts.node_blocks.components() as u32;
    let mut trace_of = std::collections::HashMap::new();
    for (trace, &vertex) in parts.traces.vertices.iter().enumerate() {
        trace_of.insert(vertex, trace as u32);
    }
    (0..coupling.rows())
        .map(|row| {
            let (columns, values) = coupling.row(row);
            let mut entries: Vec<(u32, f64)> = Vec::new();
            for (&unknown, &value) in columns.iter().zip(values) {
                let Some(&trace) = trace_of.get(&(unknown / c)) else {
                    continue;
                };
                let direction = parts.traces.directions[trace as usize];
                let along = value * direction[unknown as usize % c as usize];
                match entries.last_mut() {
                    Some(last) if last.0 == trace => last.1 += along,
                    _ => entries.push((trace, along)),
                }
            }
            entries
        })
        .collect()
}

fn add_edges(parts: &ComplianceParts<'_>, coupling: &SparseRows, matrix: &mut DenseMatrix) {
    let c = parts.node_blocks.components();
    let mut touching: std::collections::BTreeMap<u32, Vec<(usize, [f64; 3])>> = Default::default();
    for row in 0..coupling.rows() {
        let (columns, values) = coupling.row(row);
        for (&unknown, &value) in columns.iter().zip(values) {
            let (node, i) = (unknown / c as u32, unknown as usize % c);
            if (node as usize) < parts.vertex_count {
                continue;
            }
            let rows = touching.entry(node).or_default();
            if rows.last().is_none_or(|last| last.0 != row) {
                rows.push((row, [0.0; 3]));
            }
            if let Some(last) = rows.last_mut() {
                last.1[i] += value;
            }
        }
    }
    for (node, rows) in &touching {
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
