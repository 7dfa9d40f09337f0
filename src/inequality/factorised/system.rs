//! The assembled saddle point of a problem, scaled and ordered for its factor:
//!
//! ```text
//! D [ A + e  B^T  C^T ] D     D^-2 = (A_jj, sum_j B_ij^2 / A_jj + S_ii, sum_j C_ij^2 / A_jj)
//!   [ B    -S - e     ]
//!   [ C          -e   ]
//! ```
//!
//! The shift e, relative to the scaled diagonal, keeps the factor where rows depend on
//! each other; iterations on the true operator take its error off. It leaves constraints a
//! stiffness of 1 / e only, which has to outweigh what couples them to the rest: under
//! pressures far above the shear modulus entries beside the diagonal of A are that much
//! larger than those on it. A constraint comes
//! after all displacements that it sees, so that its pivot is a Schur complement and no
//! zero. Rows of C that are no constraints on a face are identities: the pattern is found
//! once for all faces.

use super::super::qp::QpStatus;
use crate::linalg::cholesky::LowerColumns;
use crate::linalg::indefinite::{IndefinitePattern, SparseIndefinite};
use crate::linalg::{LinearOperator, SparseRows};
use crate::saddle::Status;

/// Largest shift of constraints over their scaled diagonal.
const SHIFT: f64 = 1e-9;
/// Largest softening of the rest by that shift.
const SOFTENING: f64 = 1e-3;
/// Shift of displacements where rigid modes are free.
const RIGID_MODE_SHIFT: f64 = 1e-6;

/// A problem, stored.
pub struct Matrices<'a> {
    /// A - G `[displacement, displacement]`, held rows the identity.
    pub stiffness: SparseRows,
    /// B `[equalities, displacement]`; none in displacement form.
    pub coupling: Option<SparseRows>,
    /// S `[equalities, equalities]`; none where it vanishes.
    pub stabilisation: Option<&'a SparseRows>,
    /// C `[multipliers, displacement]`.
    pub contact: &'a SparseRows,
    /// Place of each displacement unknown in the elimination order; those of one node
    /// may share one `[displacement]`.
    pub places: Vec<u32>,
    /// Whether rigid modes are held by contact alone.
    pub has_rigid_modes: bool,
    /// Floating-point operations of the largest factor that is made.
    pub most_flops: f64,
}

/// The matrix with all constraints at work, and the pattern of its factor.
pub(super) struct System {
    /// D `[displacement, equalities, multipliers]`.
    pub(super) scale: Vec<f64>,
    matrix: LowerColumns,
    pattern: IndefinitePattern,
    /// Number of displacement unknowns, which come first.
    pub(super) displacements: usize,
    /// Number of the first multiplier of contact among the unknowns.
    first_contact: usize,
}

impl System {
    /// Of stored matrices.
    ///
    /// # Errors
    /// [`QpStatus::TooLarge`] where the factor takes more than it may.
    pub(super) fn new(matrices: &Matrices<'_>) -> Result<Self, QpStatus> {
        let scale = scale(matrices);
        let matrix = lower_columns(matrices, &scale);
        let too_large = |_| QpStatus::TooLarge;
        let pattern = IndefinitePattern::new(&matrix, &order(matrices)).map_err(too_large)?;
        if pattern.flops <= matrices.most_flops {
            Ok(Self {
                displacements: matrices.stiffness.rows(),
                first_contact: scale.len() - matrices.contact.rows(),
                scale,
                matrix,
                pattern,
            })
        } else {
            Err(QpStatus::TooLarge)
        }
    }

    /// Number of negative eigenvalues of a factor beyond those of constraints.
    pub(super) fn unstable(&self, factor: &SparseIndefinite) -> usize {
        let constraints = self.scale.len() - self.displacements;
        factor.negative_eigenvalues().saturating_sub(constraints)
    }

    /// The factor on a face.
    ///
    /// # Errors
    /// [`QpStatus::TooLarge`] where memory is short, [`QpStatus::IndefiniteMetric`] for a
    /// singular matrix.
    pub(super) fn factor(&self, face: &[Status]) -> Result<SparseIndefinite, QpStatus> {
        self.shifted_factor(face, 0.0)
    }

    /// The factor on a face with `shift` added on the scaled diagonal of displacements.
    ///
    /// # Errors
    /// As those of [`Self::factor`].
    pub(super) fn shifted_factor(
        &self,
        face: &[Status],
        shift: f64,
    ) -> Result<SparseIndefinite, QpStatus> {
        let mut matrix = self.matrix.clone();
        for column in 0..self.displacements {
            // The diagonal is the first entry of its column.
            matrix.values[matrix.offsets[column] as usize] += shift;
        }
        for column in 0..matrix.size() {
            for k in matrix.offsets[column] as usize..matrix.offsets[column + 1] as usize {
                let row = matrix.rows[k] as usize;
                let is_open =
                    row >= self.first_contact && face[row - self.first_contact] != Status::Stick;
                if is_open {
                    matrix.values[k] = if row == column { -1.0 } else { 0.0 };
                }
            }
        }
        self.pattern.factorise(&matrix).map_err(QpStatus::from)
    }
}

/// D of all unknowns.
fn scale(matrices: &Matrices<'_>) -> Vec<f64> {
    let diagonal = matrices.stiffness.diagonal();
    let constraint = matrices.coupling.as_ref().map_or(Vec::new(), |coupling| {
        let own = matrices.stabilisation.map(SparseRows::diagonal);
        let of_row = |row: usize| {
            let (columns, values) = coupling.row(row);
            let terms = columns.iter().zip(values);
            let outer: f64 = terms
                .map(|(&column, value)| value * value / diagonal[column as usize].abs())
                .sum();
            outer + own.as_ref().map_or(0.0, |own| own[row])
        };
        (0..coupling.rows()).map(of_row).collect()
    });
    let all = diagonal.iter().copied().chain(constraint);
    all.chain(softness(matrices))
        .map(|value| {
            if value != 0.0 && value.is_finite() {
                value.abs().sqrt().recip()
            } else {
                1.0
            }
        })
        .collect()
}

/// sum_j C_ij^2 / A_jj of all multipliers: about the diagonal of their compliance.
pub(super) fn softness(matrices: &Matrices<'_>) -> Vec<f64> {
    let diagonal = matrices.stiffness.diagonal();
    let of_row = |row: usize| {
        let (columns, values) = matrices.contact.row(row);
        let terms = columns.iter().zip(values);
        terms
            .map(|(&column, value)| value * value / diagonal[column as usize].abs())
            .sum()
    };
    (0..matrices.contact.rows()).map(of_row).collect()
}

/// The scaled matrix, all constraints at work.
fn lower_columns(matrices: &Matrices<'_>, scale: &[f64]) -> LowerColumns {
    let unknowns = matrices.stiffness.rows();
    let transposed = matrices.coupling.as_ref().map(SparseRows::transposed);
    let contact = matrices.contact.transposed();
    let equalities = matrices.coupling.as_ref().map_or(0, LinearOperator::rows);
    let mut columns = Columns {
        matrix: LowerColumns {
            offsets: vec![0],
            ..LowerColumns::default()
        },
        scale,
    };
    let shift = if matrices.has_rigid_modes {
        RIGID_MODE_SHIFT
    } else {
        0.0
    };
    let yielding = yielding(&matrices.stiffness, scale);
    for column in 0..unknowns {
        columns.push(0, matrices.stiffness.row(column), (1.0, shift));
        if let Some(coupling) = &transposed {
            columns.push(unknowns, coupling.row(column), (1.0, 0.0));
        }
        columns.push(unknowns + equalities, contact.row(column), (1.0, 0.0));
        columns.finish();
    }
    for row in 0..equalities {
        let own = [row as u32];
        let entries = matrices
            .stabilisation
            .map_or((&own[..], &[0.0][..]), |s| s.row(row));
        let entries = (entries.0, entries.1);
        columns.push_square(unknowns, entries, (-1.0, -yielding));
        columns.finish();
    }
    for column in unknowns + equalities..scale.len() {
        let own = [(column - unknowns - equalities) as u32];
        columns.push_square(unknowns + equalities, (&own, &[0.0]), (1.0, -yielding));
        columns.finish();
    }
    columns.matrix
}

/// The shift of constraints.
fn yielding(stiffness: &SparseRows, scale: &[f64]) -> f64 {
    let mut largest = 1.0_f64;
    for row in 0..stiffness.rows() {
        let (columns, values) = stiffness.row(row);
        for (&column, value) in columns.iter().zip(values) {
            largest = largest.max((value * scale[row] * scale[column as usize]).abs());
        }
    }
    SHIFT.min(SOFTENING / (largest * largest))
}

/// A matrix under construction, column by column.
struct Columns<'a> {
    matrix: LowerColumns,
    scale: &'a [f64],
}

impl Columns<'_> {
    /// The column under construction.
    fn column(&self) -> usize {
        self.matrix.offsets.len() - 1
    }

    /// Adds the entries of a symmetric block's row from the diagonal on.
    fn push_square(
        &mut self,
        first: usize,
        (rows, values): (&[u32], &[f64]),
        (factor, shift): (f64, f64),
    ) {
        let column = self.column();
        let start = rows.partition_point(|&row| first + (row as usize) < column);
        self.push(first, (&rows[start..], &values[start..]), (factor, shift));
    }

    /// Adds `factor` times entries of rows that begin at `first`, and `shift` on the
    /// diagonal.
    fn push(
        &mut self,
        first: usize,
        (rows, values): (&[u32], &[f64]),
        (factor, shift): (f64, f64),
    ) {
        let column = self.column();
        for (&row, &value) in rows.iter().zip(values) {
            let row = first + row as usize;
            if row < column {
                continue;
            }
            let scaled = factor * value * self.scale[row] * self.scale[column];
            let own = if row == column { shift } else { 0.0 };
            self.matrix.rows.push(row as u32);
            self.matrix.values.push(scaled + own);
        }
    }

    /// Ends a column.
    fn finish(&mut self) {
        self.matrix.offsets.push(self.matrix.rows.len() as u32);
    }
}

/// The elimination order: displacements by their places, each constraint right after the
/// last one that it sees.
fn order(matrices: &Matrices<'_>) -> Vec<u32> {
    let last = |(columns, _): (&[u32], &[f64])| {
        let places = columns
            .iter()
            .map(|&column| matrices.places[column as usize]);
        places.max().unwrap_or(0)
    };
    let mut keys: Vec<(u32, u32)> = matrices.places.iter().map(|&place| (place, 0)).collect();
    if let Some(coupling) = &matrices.coupling {
        keys.extend((0..coupling.rows()).map(|row| (last(coupling.row(row)), 1)));
    }
    let contact = matrices.contact;
    keys.extend((0..contact.rows()).map(|row| (last(contact.row(row)), 2)));
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by_key(|&unknown| keys[unknown as usize]);
    order
}
