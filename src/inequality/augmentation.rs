//! Terms that vanish where the constraints hold, and take off the stiffness what makes it
//! indefinite there:
//!
//! ```text
//! A du + D^T dl = r              (A + D^T E + E^T C) du + D^T dl' = r + E^T g
//! C du          = g     becomes   C du                            = g,   dl = dl' + E du
//!
//! E = M^-1 R on the multipliers that stick
//! ```
//!
//! Both systems have the same solution for every E. Of tractions of friction only D^T E is
//! there: their slips are no constraints where they slide, and tractions that slide are shifted
//! with the pressures that they follow. A body that presses with many shear
//! moduli against an obstacle has an A with a large negative part on the motions that C
//! forbids (the module `contact::area_change` has R and M); a Krylov method sees those
//! motions until it has converged. Cost: a factor of M on the face, and a product with
//! C, R and that factor an iteration.

use crate::linalg::SparseRows;
use crate::linalg::cholesky::LowerColumns;

/// R and M of all multipliers.
#[derive(Clone, Debug)]
pub struct Augmentation {
    /// R `[multipliers, displacement]`.
    pub rows: SparseRows,
    /// Which multipliers are tractions `[multipliers]`.
    pub is_traction: Vec<bool>,
    /// M `[multipliers, multipliers]`, symmetric positive definite.
    pub mass: SparseRows,
    /// Order in which M is eliminated, new to old `[multipliers]`.
    pub order: Vec<u32>,
}

impl Augmentation {
    /// The lower triangle of M on `selected`, column by column.
    pub(super) fn lower_part(&self, selected: &[usize]) -> LowerColumns {
        let mut lower = LowerColumns {
            offsets: vec![0],
            ..LowerColumns::default()
        };
        for (place, &column) in selected.iter().enumerate() {
            let (rows, values) = self.mass.row(column);
            for (&row, &value) in rows.iter().zip(values) {
                match selected.binary_search(&(row as usize)) {
                    Ok(row) if row >= place => {
                        lower.rows.push(row as u32);
                        lower.values.push(value);
                    }
                    Ok(_) | Err(_) => (),
                }
            }
            lower.offsets.push(lower.rows.len() as u32);
        }
        lower
    }
}
