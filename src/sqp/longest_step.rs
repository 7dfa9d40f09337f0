//! How far a step leads before a point of the body has too little volume left:
//!
//! ```text
//! max s in [0, 1]:   det(F + t (F_1 - F)) >= floor   for t in [0, s],   all points of the rule
//! ```
//!
//! F at the start of the step and F_1 at its end; cubic in t at every point
//! ([`crate::element::jacobian::largest_step`]). Cost: two gradients and some hundred
//! flops a point, asked for only where the whole step leads too far.

use crate::element::jacobian::largest_step;
use crate::geometry::tensor::{Tensor, plus_unit};
use crate::model::Model;
use crate::model::state::State;
use crate::model::values::gradient_at;

/// F at the rule's points, cell by cell; empty for linear bodies.
pub(crate) fn deformation_gradients(model: &Model<'_>, state: &State) -> Vec<Tensor<f64>> {
    let Some(strain) = &model.prepared.strain else {
        return Vec::new();
    };
    let points = &strain.rule().points;
    let cells = 0..model.mesh.cell_count();
    let all = cells.flat_map(|cell| points.iter().map(move |point| (cell, point)));
    all.map(|(cell, point)| plus_unit(&gradient_at(model, state, cell, point)))
        .collect()
}

/// The part of the way between two states at which every J is still above `floor`.
pub(crate) fn longest_step(start: &[Tensor<f64>], end: &[Tensor<f64>], floor: f64) -> f64 {
    let ways = start.iter().zip(end);
    let lengths = ways.map(|(f, f_1)| {
        let change = std::array::from_fn(|i| std::array::from_fn(|j| f_1[i][j] - f[i][j]));
        largest_step(f, &change, floor)
    });
    lengths.fold(1.0, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stretch of unit volume but for the factor `volume` along x.
    fn flattened(volume: f64) -> Tensor<f64> {
        [[volume, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    }

    #[test]
    fn the_point_that_turns_first_bounds_the_step() {
        let start = [1.0, 1.0, 1.0].map(flattened);
        let end = [2.0, -0.5, -1.0].map(flattened);
        assert!((longest_step(&start, &end, 0.2) - 0.4).abs() < 1e-15);
    }

    #[test]
    fn a_step_that_keeps_all_volumes_is_taken_whole() {
        let start = [1.0, 0.5].map(flattened);
        let end = [0.3, 0.4].map(flattened);
        assert!((longest_step(&start, &end, 0.2) - 1.0).abs() < f64::EPSILON);
        assert!((longest_step(&[], &[], 0.2) - 1.0).abs() < f64::EPSILON);
    }
}
