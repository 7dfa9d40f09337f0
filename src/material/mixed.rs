//! What the pressure of the mixed form adds to the tangent of a law: -p d(cof F)/dF.

use super::TangentMatrix;
use crate::geometry::tensor::{Tensor, cross};

/// Takes `pressure` times d(cof F)/dF at F = `gradient` off `tangent`.
pub(super) fn subtract_pressure(
    tangent: &mut TangentMatrix,
    gradient: &Tensor<f64>,
    pressure: f64,
) {
    for (place, row) in tangent.iter_mut().enumerate() {
        let mut unit = [[0.0; 3]; 3];
        unit[place / 3][place % 3] = 1.0;
        let turned = cross(gradient, &unit);
        for (entry, turn) in row.iter_mut().zip(turned.as_flattened()) {
            *entry -= pressure * turn;
        }
    }
}
