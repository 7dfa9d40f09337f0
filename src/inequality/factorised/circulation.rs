//! What loads without a potential make of motions that lower the energy. Pressure on a part
//! of a surface pushes along its free edge in directions that turn with the body:
//!
//! ```text
//! K = H + W,   H = H^T,   W = -W^T in the rows E of the edge
//! K_t = H + t W is singular on the face where  det(I + t W_EE G) = 0,   G = E^T H^-1 E
//! ```
//!
//! As t grows to one each such t takes a real eigenvalue of K_t through zero. A motion that
//! lowers the energy is no way out for the body where one of them takes its eigenvalue above
//! zero: it leads back, round a circle (V. Bolotin, Nonconservative Problems of the Theory
//! of Elastic Stability, 1963, divergence). Oscillations that grow are not looked for. Cost:
//! one solve with the factor of H for each row of E.

use super::system::System;
use crate::linalg::eigen::eigenvalues;
use crate::linalg::indefinite::SparseIndefinite;
use crate::linalg::{DenseMatrix, LinearOperator, SparseRows, Workspace};

/// Rows that are tried at most: those of some edge points in the plane, of an edge of a
/// coarse mesh in space.
const MOST_ROWS: usize = 200;
/// Imaginary part over the real one that is rounding.
const ROUNDING: f64 = 1e-8;

/// Number of real eigenvalues that W, `skew`, takes through zero, `factor` being that of H
/// on a face; none where W has too many rows.
pub(super) fn crossings(
    (system, factor): (&System, &SparseIndefinite),
    skew: &SparseRows,
    work: &mut Workspace,
) -> Option<usize> {
    let rows = (0..skew.rows()).filter(|&row| !skew.row(row).0.is_empty());
    let rows: Vec<usize> = rows.collect();
    if rows.len() > MOST_ROWS {
        return None;
    }
    let mut product = DenseMatrix::zeros(rows.len(), rows.len());
    let mut x = vec![0.0; system.scale.len()];
    for (column, &unit) in rows.iter().enumerate() {
        x.fill(0.0);
        x[unit] = system.scale[unit];
        factor.solve(&mut x, work);
        x.iter_mut().zip(&system.scale).for_each(|(x, d)| *x *= d);
        for (place, &row) in rows.iter().enumerate() {
            let (columns, values) = skew.row(row);
            let terms = columns.iter().zip(values);
            *product.at_mut(place, column) = terms.map(|(&c, value)| value * x[c as usize]).sum();
        }
    }
    let crosses = |&&[re, im]: &&[f64; 2]| re <= -1.0 && im.abs() <= -ROUNDING * re;
    Some(eigenvalues(&product)?.iter().filter(crosses).count())
}
