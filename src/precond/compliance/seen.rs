//! What the rows of a coupling see of the volumes of a body: W `[volumes, multipliers]`, and
//! L^-1 W for the factor L of their Gram matrix.

use super::nodes::AtNode;
use super::{ComplianceParts, TraceRow};
use crate::linalg::vector::dot;
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, SparseRowsBuilder};
use crate::parallel::{self, Scratch};
use crate::precond::volume_modes::VolumeModes;

/// Share of the largest entry of a volume below which it is next to nothing.
const NOTHING: f64 = 1e-4;

/// L^-1 W, and W without what is next to nothing.
pub(super) fn seen_of(
    parts: &ComplianceParts<'_>,
    rows: (&[TraceRow], &[(u32, AtNode)]),
    volumes: &VolumeModes,
) -> (DenseMatrix, SparseRows) {
    let (size, modes) = (rows.0.len(), volumes.count());
    let unknowns = volumes.nodal_part.columns();
    let fresh = || vec![0.0; unknowns];
    let scratch = Scratch::new(&fresh);
    let seen: Vec<Vec<f64>> = parallel::map(modes, 1, &|mode| {
        scratch.lend(|alone| {
            alone.fill(0.0);
            volumes.nodal_part.add_row(mode, 1.0, alone);
            seen_by(parts, rows, (&volumes.p1_part[mode], alone))
        })
    });
    let mut kept = SparseRowsBuilder::new(size);
    seen.iter().for_each(|seen| kept.push_dense(seen, NOTHING));
    let columns: Vec<Vec<f64>> = parallel::map(size, 1, &|row| {
        let mut column: Vec<f64> = seen.iter().map(|seen| seen[row]).collect();
        volumes.factor.forward(&mut column);
        column
    });
    let mut orthonormal = DenseMatrix::zeros(modes, size);
    for (row, column) in columns.iter().enumerate() {
        orthonormal.column_mut(row).copy_from_slice(column);
    }
    (orthonormal, kept.finish())
}

/// w: what each row sees of a motion, `smooth` along the traces and `alone` at the nodes.
fn seen_by(
    parts: &ComplianceParts<'_>,
    (vertex_rows, touching): (&[TraceRow], &[(u32, AtNode)]),
    (smooth, alone): (&[f64], &[f64]),
) -> Vec<f64> {
    let c = parts.node_blocks.components();
    let along = |&(trace, value): &(u32, f64)| value * smooth[trace as usize];
    let rows = vertex_rows.iter();
    let mut seen: Vec<f64> = rows.map(|row| row.iter().map(along).sum()).collect();
    for (node, rows) in touching {
        let first = *node as usize * c;
        for (row, load) in rows {
            seen[*row] += dot(&load[..c], &alone[first..first + c]);
        }
    }
    seen
}
