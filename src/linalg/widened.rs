//! Operators in single precision where double is asked for.

use super::{LinearOperator, ResidualUpdate, Workspace};

/// An operator in single precision as one in double, whose products are rounded.
pub struct Widened<'a> {
    /// A.
    pub operator: &'a dyn ResidualUpdate<f32>,
    /// Rows and columns.
    pub size: usize,
}

impl LinearOperator for Widened<'_> {
    fn rows(&self) -> usize {
        self.size
    }

    fn columns(&self) -> usize {
        self.size
    }

    fn apply(&self, x: &[f64], y: &mut [f64], work: &mut Workspace) {
        let mut single = work.scratch_f32(self.size);
        let mut product = work.scratch_f32(self.size);
        single.iter_mut().zip(x).for_each(|(s, x)| *s = *x as f32);
        product.fill(0.0);
        self.operator.update_residual(&single, &mut product, work);
        y.iter_mut()
            .zip(&product)
            .for_each(|(y, p)| *y = -f64::from(*p));
        work.give_f32(single);
        work.give_f32(product);
    }

    /// Of a symmetric operator.
    fn apply_transposed(&self, y: &[f64], x: &mut [f64], work: &mut Workspace) {
        self.apply(y, x, work);
    }
}
