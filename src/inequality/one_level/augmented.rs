//! The terms of [`crate::inequality::augmentation`] on one face: E = M^-1 R on the
//! multipliers that stick, its products, and the way back to the original system. Cost: a
//! sparse factor of M on the face, two products with it, C and R an iteration.

use super::slides::expand;
use crate::inequality::{Augmentation, Slide};
use crate::linalg::cholesky::Precision;
use crate::linalg::vector::add_scaled;
use crate::linalg::{LinearOperator, SparseCholesky, SparseRows, Workspace};
use crate::saddle::Status;

/// E on one face.
pub(crate) struct Augmented<'a> {
    /// C and D.
    rows_and_columns: [&'a dyn LinearOperator; 2],
    /// R and M of all multipliers.
    terms: &'a Augmentation,
    /// Points that slip: their tractions follow the pressures that E shifts.
    slides: &'a [Slide],
    /// Multipliers that stick, ascending.
    selected: Vec<usize>,
    /// Factor of M on them.
    factor: SparseCholesky,
    /// What the curvature of the gaps takes off the stiffness.
    curvature: Option<&'a SparseRows>,
}

impl<'a> Augmented<'a> {
    /// Those of `terms` on the multipliers that stick, with the `curvature` of the program; none where
    /// none sticks or their mass has no factor.
    pub(crate) fn new(
        terms: &'a Augmentation,
        rows_and_columns: [&'a dyn LinearOperator; 2],
        (status, slides): (&[Status], &'a [Slide]),
        curvature: Option<&'a SparseRows>,
    ) -> Option<Self> {
        let sticks = |&i: &usize| status[i] == Status::Stick;
        let selected: Vec<usize> = (0..status.len()).filter(sticks).collect();
        if selected.is_empty() {
            return None;
        }
        let place = |m: u32| selected.binary_search(&(m as usize)).ok();
        let order = terms.order.iter().filter_map(|&m| place(m));
        let order: Vec<u32> = order.map(|place| place as u32).collect();
        let lower = terms.lower_part(&selected);
        let factor = SparseCholesky::new(&lower, &order, Precision::Double).ok()?;
        Some(Self {
            rows_and_columns,
            terms,
            slides,
            selected,
            factor,
            curvature,
        })
    }
}

impl Augmented<'_> {
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
        let mut values = vec![0.0; self.terms.rows.rows()];
        self.terms.rows.apply(du, &mut values, work);
        self.solve(&mut values, work);
        expand(self.slides, &mut values);
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
        let tractions = values.iter_mut().zip(&self.terms.is_traction);
        tractions.for_each(|(value, &is_traction)| {
            if is_traction {
                *value = 0.0;
            }
        });
        self.solve(&mut values, work);
        self.terms.rows.add_transposed(factor, &values, force, work);
    }

    /// Adds `factor` (D^T E + E^T C) du to `force`.
    fn add_stiffness(&self, factor: f64, du: &[f64], (force, work): (&mut [f64], &mut Workspace)) {
        let moved = self.multipliers(du, work);
        let [rows, columns] = self.rows_and_columns;
        columns.add_transposed(factor, &moved, force, work);
        let mut closing = vec![0.0; self.terms.rows.rows()];
        rows.apply(du, &mut closing, work);
        self.add_force(factor, &closing, (force, work));
    }
}

/// What is taken off A: the curvature less D^T E + E^T C.
impl LinearOperator for Augmented<'_> {
    fn rows(&self) -> usize {
        self.terms.rows.columns()
    }

    fn columns(&self) -> usize {
        self.terms.rows.columns()
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

impl Augmented<'_> {
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
