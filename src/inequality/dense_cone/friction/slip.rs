//! The equation of a point that slips, in a Newton step.

use super::{Newton, Point};
use crate::linalg::DenseMatrix;
use crate::linalg::vector::norm;

/// The slip equation of a point: t' rows as M, e and right-hand side.
pub(super) struct SlipRow {
    /// M `[2, 2]`.
    matrix: [[f64; 2]; 2],
    /// Direction of d `[2]`.
    direction: [f64; 2],
    /// -M d + r_0 e `[2]`.
    right: [f64; 2],
    /// Step length rho.
    step: f64,
}

impl Newton<'_> {
    /// The slip equation of a point at an iterate.
    pub(super) fn slip_row(&self, point: Point, at: (&[f64], &[f64])) -> SlipRow {
        let width = self.width();
        let pulled = self.pulled(point, at);
        let length = norm(&pulled);
        let bound = point.bound.radius(self.predicted(point.partner, at));
        let mut traction = [0.0; 2];
        traction[..width].copy_from_slice(&at.0[point.first..point.first + width]);
        let size = norm(&traction);
        let direction = pulled.map(|d| d / length);
        let along: f64 = traction.iter().zip(&direction).map(|(t, e)| t * e).sum();
        // Positive far from the solution, where traction and d may be opposite.
        let alpha = if size > 0.0 { along / size } else { 0.0 };
        let delta = (size / bound).min(1.0);
        let beta = if alpha < 0.0 {
            1.0 / (1.0 - alpha * delta)
        } else {
            1.0
        };
        let share = beta / bound.max(size);
        let ratio = bound / length;
        let matrix: [[f64; 2]; 2] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let unit = if i == j { 1.0 } else { 0.0 };
                ratio * (unit - share * traction[i] * direction[j])
            })
        });
        let given = bound - point.bound.slope() * self.predicted(point.partner, at);
        let right = std::array::from_fn(|i| {
            let product: f64 = matrix[i].iter().zip(&pulled).map(|(m, d)| m * d).sum();
            given * direction[i] - product
        });
        SlipRow {
            matrix,
            direction,
            right,
            step: self.point_step(point),
        }
    }

    /// Puts a slip equation in the place of s_t = 0.
    pub(super) fn place(
        &self,
        row: &SlipRow,
        (point, selected): (Point, &[usize]),
        (matrix, right): (&mut DenseMatrix, &mut [f64]),
    ) {
        let at = |index: usize| selected.partition_point(|&other| other < index);
        let (own, width) = (at(point.first), self.width());
        let partner = at(point.partner);
        for column in 0..selected.len() {
            let mut known = [0.0; 2];
            (0..width).for_each(|i| known[i] = matrix.at(own + i, column));
            for i in 0..width {
                let through: f64 = row.matrix[i].iter().zip(&known).map(|(m, k)| m * k).sum();
                let mut entry = row.step * through;
                if let Some(j) = column.checked_sub(own).filter(|&j| j < width) {
                    entry += if i == j { 1.0 } else { 0.0 } - row.matrix[i][j];
                }
                if column == partner {
                    entry -= point.bound.slope() * row.direction[i];
                }
                *matrix.at_mut(own + i, column) = entry;
            }
        }
        let linear = &self.problem.linear[point.first..point.first + width];
        for i in 0..width {
            let through: f64 = row.matrix[i].iter().zip(linear).map(|(m, q)| m * q).sum();
            right[own + i] = row.right[i] - row.step * through;
        }
    }
}
