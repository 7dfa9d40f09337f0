//! How far a frictional obstacle has turned against the surface that it touches, in one increment:
//!
//! ```text
//! max over R of sum_i (x_i - x) . R (y_i - y),   y_i = Q x0_i
//! ```
//!
//! x_i where the points of friction are, y_i where the obstacle would have taken them. Slip
//! is counted along the chord and taken for its direction at the end, whose error is half the
//! angle of R: after half a turn friction pulls the other way. The largest eigenvector of a
//! symmetric matrix of four by four numbers holds half the angle (Horn, J. Opt. Soc. Am. A 4,
//! 1987). Cost: a pass over the points of frictional obstacles.

use crate::geometry::vector3::{add, norm, scale, sub};
use crate::linalg::DenseMatrix;
use crate::linalg::eigen::symmetric;
use crate::linalg::vector::dot;
use crate::model::Model;
use crate::model::state::State;
use crate::report::{Warning, WarningKind};

/// Angle in one increment from which on a word is due, radians: chord and arc differ by 1 %,
/// directions by a quarter of a right angle.
const COARSE: f64 = std::f64::consts::FRAC_PI_6;

/// Frictional obstacles that touch and have turned too far since the increment began.
pub(crate) fn coarse_turns(model: &Model<'_>, state: &State) -> Vec<Warning> {
    let (Some(friction), Some(start)) = (&model.interfaces.friction, &model.conditions.slip_start)
    else {
        return Vec::new();
    };
    let traces = friction.traces(model, state);
    let travels = friction.travels(&traces, (model, state), start);
    let places = traces.moments(model.prepared.space.components, &state.displacement);
    let obstacles = model.plan.problem.obstacles.iter().enumerate();
    let warning = |index: usize, name: &str| {
        let (mut pairs, mut is_pressed) = (Vec::new(), false);
        for (number, point) in friction.points.iter().enumerate() {
            if point.obstacle == index {
                let shrink = traces.weights[number].recip();
                let now = scale(shrink, places[number]);
                let carried = sub(now, scale(shrink, travels[number]));
                pairs.push((carried, now));
                is_pressed |= state.multiplier[friction.partners[number] as usize] > 0.0;
            }
        }
        let angle = angle_between(&pairs, model.plan.problem.units.dimension);
        (is_pressed && angle > COARSE).then(|| of_angle(name, angle))
    };
    obstacles
        .filter(|(_, planned)| planned.is_frictional)
        .filter_map(|(index, planned)| warning(index, &planned.name))
        .collect()
}

/// The words for an angle in radians.
fn of_angle(name: &str, angle: f64) -> Warning {
    let degrees = angle.to_degrees();
    Warning::new(
        WarningKind::CoarseTurn,
        name,
        Some(angle),
        format!(
            "frictional obstacle `{name}` has turned against the body by {degrees:.0} degrees in one increment: friction follows the chord, take increments of 30 degrees at most"
        ),
    )
}

/// Angle of the rotation that takes the first points of the pairs nearest to the second ones;
/// in the plane of the rotation about its normal.
fn angle_between(pairs: &[([f64; 3], [f64; 3])], dimension: usize) -> f64 {
    let share = (pairs.len() as f64).recip();
    let sums = pairs.iter().fold([[0.0; 3]; 2], |[a, b], (from, to)| {
        [add(a, *from), add(b, *to)]
    });
    let [from, to] = sums.map(|sum| scale(share, sum));
    let mut product = [[0.0; 3]; 3];
    for (a, b) in pairs {
        let (a, b) = (sub(*a, from), sub(*b, to));
        (0..3).for_each(|i| product[i] = add(product[i], scale(a[i], b)));
        if dimension == 2 {
            // The normal of the plane is taken to itself.
            product[2][2] += norm(a) * norm(b);
        }
    }
    let [xx, yy, zz] = [0, 1, 2].map(|i| product[i][i]);
    let along = |i: usize, j: usize| product[i][j] + product[j][i];
    let axis = |i: usize, j: usize| product[i][j] - product[j][i];
    let rows = [
        [xx + yy + zz, axis(1, 2), axis(2, 0), axis(0, 1)],
        [axis(1, 2), xx - yy - zz, along(0, 1), along(2, 0)],
        [axis(2, 0), along(0, 1), yy - xx - zz, along(1, 2)],
        [axis(0, 1), along(2, 0), along(1, 2), zz - xx - yy],
    ];
    let mut matrix = DenseMatrix::zeros(4, 4);
    for (i, row) in rows.iter().enumerate() {
        (0..4).for_each(|j| *matrix.at_mut(i, j) = row[j]);
    }
    // Numbers that are not finite have no directions, and an ending of their own.
    let directions = symmetric(&matrix).unwrap_or_default();
    let quotient = |q: &[f64]| {
        let terms = rows.iter().zip(q).map(|(row, x)| x * dot(row, q));
        terms.sum::<f64>()
    };
    let largest = directions
        .iter()
        .max_by(|a, b| quotient(a).total_cmp(&quotient(b)));
    largest.map_or(0.0, |q| 2.0 * q[0].abs().min(1.0).acos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rigid_motion::{multiply, rotation_matrix};

    /// Points on two faces of a box, and where a turn takes them.
    fn pairs(turn: [f64; 3], dimension: usize) -> Vec<([f64; 3], [f64; 3])> {
        let matrix = rotation_matrix(turn);
        let places = (0..12).map(|k| {
            let k = f64::from(k);
            match dimension {
                2 => [0.3 * k, 2.0, 0.0],
                _ => [0.3 * k, 0.1 * (k % 3.0), 1.0],
            }
        });
        let turned = |x: [f64; 3]| (x, multiply(&matrix, x));
        places.map(turned).collect()
    }

    #[test]
    fn angles_of_turns_are_found_on_flat_faces_and_on_lines_in_the_plane() {
        for angle in [0.0, 1e-3, 0.5, 1.6, 3.1] {
            let axis: [f64; 3] = [0.6, 0.0, 0.8];
            let found = angle_between(&pairs(axis.map(|x| angle * x), 3), 3);
            assert!((found - angle).abs() < 1e-6, "{angle} {found}");
            let found = angle_between(&pairs([0.0, 0.0, -angle], 2), 2);
            assert!((found - angle).abs() < 1e-6, "{angle} {found}");
        }
    }
}
