//! Products with A + C^T W C.

use std::sync::Arc;

use crate::linalg::{LinearOperator, ResidualUpdate, SparseRows, Workspace};

/// A with springs.
pub(super) struct Stiffened<A: ?Sized> {
    /// A.
    pub(super) inner: Arc<A>,
    /// C in the basis of A.
    pub(super) rows: Arc<SparseRows>,
    /// W.
    pub(super) weights: Arc<[f64]>,
}

impl<A: ?Sized> Stiffened<A> {
    /// Adds `factor` C^T W C x.
    fn add_springs(&self, factor: f64, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let mut forces = work.scratch(self.weights.len());
        self.rows.apply(x, &mut forces, work);
        forces
            .iter_mut()
            .zip(&*self.weights)
            .for_each(|(force, weight)| *force *= weight);
        self.rows.add_transposed(factor, &forces, y, work);
        work.give(forces);
    }
}

impl LinearOperator for Stiffened<dyn LinearOperator> {
    fn rows(&self) -> usize {
        self.inner.rows()
    }

    fn columns(&self) -> usize {
        self.inner.columns()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        self.inner.apply(x, y, work);
        self.add_springs(1.0, x, y, work);
    }

    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.inner.apply_transposed(y, x, work);
        self.add_springs(1.0, y, x, work);
    }

    fn subtract_product(&self, x: &[f64], r: &mut [f64], work: &mut Workspace) {
        self.inner.subtract_product(x, r, work);
        self.add_springs(-1.0, x, r, work);
    }
}

impl ResidualUpdate<f32> for Stiffened<dyn ResidualUpdate<f32>> {
    fn take_off(&self, x: &[f32], r: &mut [f32], work: &mut Workspace) {
        self.inner.take_off(x, r, work);
        // A surface has few rows, so that one thread serves.
        for (row, weight) in self.weights.iter().enumerate() {
            let (columns, values) = self.rows.row(row);
            let entries = columns.iter().map(|&column| column as usize).zip(values);
            let products = entries.clone().map(|(place, a)| a * f64::from(x[place]));
            let force = weight * products.sum::<f64>();
            entries.for_each(|(place, a)| r[place] -= (force * a) as f32);
        }
    }
}
