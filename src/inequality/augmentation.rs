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
//! Both systems have the same solution for every E. A body that presses with many shear
//! moduli against an obstacle has an A with a large negative part on the motions that C
//! forbids (the module `contact::area_change` has R and M); a Krylov method sees those
//! motions until it has converged. Cost: a factor of M on the face, and a product with
//! C, R and that factor an iteration.

use crate::linalg::cholesky::{LowerColumns, Precision};
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, SparseCholesky, SparseRows, Workspace};
use crate::saddle::Status;

use super::blocks::ContactBlock;

/// R and M of all multipliers.
#[derive(Clone, Debug)]
pub struct Augmentation {
    /// R `[multipliers, displacement]`.
    pub rows: SparseRows,
    /// M `[multipliers, multipliers]`, symmetric positive definite.
    pub mass: SparseRows,
    /// Order in which M is eliminated, new to old `[multipliers]`.
    pub order: Vec<u32>,
}

/// E on one face.
pub(super) struct OnFace<'a> {
    /// C and D.
    contact: ContactBlock<'a>,
    /// R of all multipliers.
    rows: &'a SparseRows,
    /// Multipliers that stick, ascending.
    selected: Vec<usize>,
    /// Factor of M on them.
    factor: SparseCholesky,
    /// What the curvature of the gaps takes off the stiffness.
    curvature: Option<&'a SparseRows>,
}

impl Augmentation {
    /// On the multipliers that stick, with the `curvature` of the program; none where
    /// none sticks or their mass has no factor.
    pub(super) fn on_face<'a>(
        &'a self,
        contact: ContactBlock<'a>,
        status: &[Status],
        curvature: Option<&'a SparseRows>,
    ) -> Option<OnFace<'a>> {
        let sticks = |&i: &usize| status[i] == Status::Stick;
        let selected: Vec<usize> = (0..status.len()).filter(sticks).collect();
        if selected.is_empty() {
            return None;
        }
        let place = |m: u32| selected.binary_search(&(m as usize)).ok();
        let order = self.order.iter().filter_map(|&m| place(m));
        let order: Vec<u32> = order.map(|place| place as u32).collect();
        let lower = self.lower_part(&selected);
        let factor = SparseCholesky::new(&lower, &order, Precision::Double).ok()?;
        Some(OnFace {
            contact,
            rows: &self.rows,
            selected,
            factor,
            curvature,
        })
    }

    /// The lower triangle of M on `selected`, column by column.
    fn lower_part(&self, selected: &[usize]) -> LowerColumns {
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

impl OnFace<'_> {
    /// M^-1 on the face in place, zero elsewhere `[multipliers]`.
    fn solve(&self, values: &mut [f64], work: &mut Workspace) {
        let mut small: Vec<f64> = self.selected.iter().map(|&i| values[i]).collect();
        self.factor.solve(&mut small, 1, work);
        values.fill(0.0);
        for (&index, value) in self.selected.iter().zip(small) {
            values[index] = value;
        }
    }

    /// E du `[multipliers]`.
    pub(super) fn multipliers(&self, du: &[f64], work: &mut Workspace) -> Vec<f64> {
        let mut values = vec![0.0; self.rows.rows()];
        self.rows.apply(du, &mut values, work);
        self.solve(&mut values, work);
        values
    }

    /// Adds `factor` E^T `gap` to `force`; what of the gap is off the face counts as zero.
    pub(super) fn add_force(
        &self,
        factor: f64,
        gap: &[f64],
        (force, work): (&mut [f64], &mut Workspace),
    ) {
        let mut values = gap.to_vec();
        self.solve(&mut values, work);
        self.rows.add_transposed(factor, &values, force, work);
    }

    /// Adds `factor` (D^T E + E^T C) du to `force`.
    fn add_stiffness(&self, factor: f64, du: &[f64], (force, work): (&mut [f64], &mut Workspace)) {
        let moved = self.multipliers(du, work);
        let columns = self.contact.columns;
        columns.add_transposed(factor, &moved, force, work);
        let mut closing = vec![0.0; self.rows.rows()];
        self.contact.rows.apply(du, &mut closing, work);
        self.add_force(factor, &closing, (force, work));
    }
}

/// What is taken off A: the curvature less D^T E + E^T C.
impl LinearOperator for OnFace<'_> {
    fn rows(&self) -> usize {
        self.rows.columns()
    }

    fn columns(&self) -> usize {
        self.rows.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        match self.curvature {
            Some(curvature) => curvature.apply(x, y, work),
            None => y.fill(0.0),
        }
        self.add_stiffness(-1.0, x, (y, work));
    }

    /// Symmetric where C and D are the same.
    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}

impl OnFace<'_> {
    /// The multipliers of the original system from those of the augmented one, and its
    /// force residual.
    pub(super) fn restore(
        &self,
        (du, gap): (&[f64], &[f64]),
        (multiplier, force): (&mut [f64], &mut [f64]),
        work: &mut Workspace,
    ) {
        let moved = self.multipliers(du, work);
        add_scaled(multiplier, 1.0, &moved);
        self.add_force(-1.0, gap, (force, work));
    }
}
