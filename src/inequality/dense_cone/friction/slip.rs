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
    /// Slope of the bound.
    slope: f64,
    /// First of its tractions among the unknowns.
    pub(super) own: usize,
    /// Its pressure among the unknowns.
    pub(super) partner: usize,
    /// q of its tractions `[2]`.
    linear: [f64; 2],
}

impl Newton<'_> {
    /// The slip equation of a point at an iterate, among the unknowns `selected`.
    pub(super) fn slip_row(
        &self,
        point: Point,
        selected: &[usize],
        at: (&[f64], &[f64]),
    ) -> SlipRow {
        let width = self.width();
        let pulled = self.pulled(point, at);
        let length = norm(&pulled);
        let pressure = self.predicted(point.partner, at);
        let (bound, slope) = (point.bound.radius(pressure), point.bound.slope(pressure));
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
        let given = bound - slope * pressure;
        let right = std::array::from_fn(|i| {
            let product: f64 = matrix[i].iter().zip(&pulled).map(|(m, d)| m * d).sum();
            given * direction[i] - product
        });
        let place = |index: usize| selected.partition_point(|&other| other < index);
        let mut linear = [0.0; 2];
        linear[..width].copy_from_slice(&self.problem.linear[point.first..point.first + width]);
        SlipRow {
            matrix,
            direction,
            right,
            step: self.point_step(point),
            slope,
            own: place(point.first),
            partner: place(point.partner),
            linear,
        }
    }

    /// Puts slip equations in the place of s_t = 0, column by column.
    pub(super) fn place(&self, rows: &[SlipRow], (matrix, right): (&mut DenseMatrix, &mut [f64])) {
        let width = self.width();
        for column in 0..matrix.columns() {
            let entries = matrix.column_mut(column);
            for row in rows {
                row.place(column, &mut entries[row.own..row.own + width]);
            }
        }
        for row in rows {
            let own = &mut right[row.own..row.own + width];
            for (i, value) in own.iter_mut().enumerate() {
                let parts = row.matrix[i].iter().zip(&row.linear);
                let through: f64 = parts.map(|(m, q)| m * q).sum();
                *value = row.right[i] / row.step - through;
            }
        }
    }
}

/// Least part of M along d that counts: what is on the edge of its disc has none.
const LEAST_SHARE: f64 = 1e-6;

impl SlipRow {
    /// M in the frame of d, its rows off the diagonal left out, no less than what counts.
    fn shares(&self) -> [f64; 2] {
        let [x, y] = self.direction;
        let quotient = |[x, y]: [f64; 2]| {
            let m = &self.matrix;
            x * (m[0][0] * x + m[0][1] * y) + y * (m[1][0] * x + m[1][1] * y)
        };
        [quotient([x, y]), quotient([-y, x])].map(|share| share.clamp(LEAST_SHARE, 1.0))
    }

    /// (1 - M) / (rho M) of `shares`, in the axes of the tractions: what gives way.
    pub(super) fn softness(&self) -> [[f64; 2]; 2] {
        let [x, y] = self.direction;
        let [along, across] = self.shares().map(|share| (1.0 / share - 1.0) / self.step);
        [
            [along * x * x + across * y * y, (along - across) * x * y],
            [(along - across) * x * y, along * y * y + across * x * x],
        ]
    }

    /// The gap along the tractions that the equation's residual is, the traction that follows
    /// `pressure` with it; in place.
    pub(super) fn gap(&self, pressure: f64, residual: &mut [f64]) {
        let mut known = [0.0; 2];
        known[..residual.len()].copy_from_slice(residual);
        let ([x, y], shares) = (self.direction, self.shares());
        let follows = self.slope * pressure / self.step;
        let along = (known[0] * x + known[1] * y + follows) / shares[0];
        let across = (known[1] * x - known[0] * y) / shares[1];
        let gap = [along * x - across * y, along * y + across * x];
        residual.copy_from_slice(&gap[..residual.len()]);
    }

    /// Makes the entries of a column of its own rows from those of s_t.
    fn place(&self, column: usize, entries: &mut [f64]) {
        let mut known = [0.0; 2];
        known[..entries.len()].copy_from_slice(entries);
        let width = entries.len();
        for (i, entry) in entries.iter_mut().enumerate() {
            let through: f64 = self.matrix[i].iter().zip(&known).map(|(m, k)| m * k).sum();
            *entry = through;
            if let Some(j) = column.checked_sub(self.own).filter(|&j| j < width) {
                *entry += (if i == j { 1.0 } else { 0.0 } - self.matrix[i][j]) / self.step;
            }
            if column == self.partner {
                *entry -= self.slope * self.direction[i] / self.step;
            }
        }
    }
}
