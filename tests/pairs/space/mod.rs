//! Two bodies in space.

mod balls;
mod boxes;
mod clamps;
mod edges;
mod folds;
mod friction;
mod mirrors;
mod patches;
mod turns;

use signorini::MeshParts;

use super::scenes::joined;
use crate::common::meshes::{irregular, moved, unit_box};

/// Two blocks of a unit square each that meet at z = 0, of those cells, their inner nodes moved at
/// random and those of the surfaces shifted so that no two are opposite.
pub(crate) fn blocks(low: [usize; 3], high: [usize; 3]) -> MeshParts {
    let shifted = |[x, y, z]: [f64; 3]| {
        let wave = 0.08 * (std::f64::consts::PI * x).sin() * (std::f64::consts::PI * y).sin();
        [x - 0.5 + wave * (0.3 - z), y - 0.5 - 0.7 * wave, z]
    };
    let lower = moved(irregular(unit_box(low), low[0]), shifted);
    let upper = irregular(unit_box(high), high[0] + 1);
    let upper = moved(upper, |[x, y, z]| [x - 0.5, y - 0.5, z]);
    joined(&[
        ("low_", moved(lower, |[x, y, z]| [x, y, z - 1.0])),
        ("up_", upper),
    ])
}
