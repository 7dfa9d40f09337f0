//! Rigid motions x ↦ c + R(x − c) + t with R = exp(K), K v = r × v.
//!
//! The rotation vector r (radians) may be of any length, several turns
//! included. Rodrigues' formula is written with sin(θ)/θ and its square at θ/2,
//! which keep full accuracy down to θ = 0. One matrix costs two sines and some
//! forty flops; a caller that moves many points keeps the matrix.

use super::vector3::{add, cross, dot, norm, scale, sub};

/// A 3×3 matrix, row by row.
pub type Matrix3 = [[f64; 3]; 3];

/// A rotation about a reference point, then a translation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidMotion {
    /// Translation t `[3]`, length, applied after the rotation.
    pub translation: [f64; 3],
    /// Rotation vector r `[3]`, radians: its direction is the axis, its length the
    /// angle, which may exceed a turn.
    pub rotation: [f64; 3],
    /// Reference point c `[3]` that only the translation moves, length.
    pub about: [f64; 3],
}

impl RigidMotion {
    /// The image of a point `[3]`.
    pub fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.rotate(sub(point, self.about));
        add(add(self.about, turned), self.translation)
    }

    /// The point whose image is the given point `[3]`.
    pub fn inverse_apply(&self, point: [f64; 3]) -> [f64; 3] {
        let offset = sub(sub(point, self.translation), self.about);
        add(self.about, self.inverse_rotate(offset))
    }

    /// The image of a direction `[3]`.
    pub fn rotate(&self, vector: [f64; 3]) -> [f64; 3] {
        multiply(&self.matrix(), vector)
    }

    /// The direction whose image is the given direction `[3]`.
    pub fn inverse_rotate(&self, vector: [f64; 3]) -> [f64; 3] {
        multiply_transposed(&self.matrix(), vector)
    }

    /// How far a point moves `[3]`: (R − I)(x − c) + t, where a small rotation
    /// keeps its digits.
    pub fn displacement(&self, point: [f64; 3]) -> [f64; 3] {
        let [first, second] = weights(self.rotation);
        let once = cross(self.rotation, sub(point, self.about));
        let twice = cross(self.rotation, once);
        add(
            add(scale(first, once), scale(second, twice)),
            self.translation,
        )
    }

    /// Where the reference point goes `[3]`.
    pub fn about_moved(&self) -> [f64; 3] {
        add(self.about, self.translation)
    }

    /// The same motion with another reference point.
    pub fn expressed_about(&self, about: [f64; 3]) -> Self {
        let turn = Self {
            translation: [0.0; 3],
            rotation: self.rotation,
            about,
        };
        Self {
            translation: sub(self.translation, turn.displacement(self.about)),
            ..turn
        }
    }

    /// Whether every point stays where it is by construction.
    pub fn is_rest(&self) -> bool {
        let mut all = self.translation.iter().chain(&self.rotation);
        all.all(|&value| value == 0.0)
    }

    /// R, orthogonal to rounding.
    pub fn matrix(&self) -> Matrix3 {
        rotation_matrix(self.rotation)
    }
}

/// exp(K) for the rotation vector `[3]` in radians:
/// R = I + (sin θ/θ) K + ½ (sin(θ/2)/(θ/2))² K², K² = r rᵀ − θ² I.
pub fn rotation_matrix(rotation: [f64; 3]) -> Matrix3 {
    let [x, y, z] = rotation;
    let [first, second] = weights(rotation);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        [
            1.0 - second * (yy + zz),
            second * x * y - first * z,
            second * x * z + first * y,
        ],
        [
            second * x * y + first * z,
            1.0 - second * (xx + zz),
            second * y * z - first * x,
        ],
        [
            second * x * z - first * y,
            second * y * z + first * x,
            1.0 - second * (xx + yy),
        ],
    ]
}

/// Of K and K² in R − I.
fn weights(rotation: [f64; 3]) -> [f64; 2] {
    let angle = norm(rotation);
    let half = cardinal_sine(0.5 * angle);
    [cardinal_sine(angle), 0.5 * half.powi(2)]
}

/// M v.
pub fn multiply(matrix: &Matrix3, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| dot(row, vector))
}

/// Mᵀ v.
pub fn multiply_transposed(matrix: &Matrix3, vector: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = vector;
    [0, 1, 2].map(|column| matrix[0][column] * x + matrix[1][column] * y + matrix[2][column] * z)
}

/// R H Rᵀ: a symmetric tensor H carried along by a rotation R.
pub fn conjugate(rotation: &Matrix3, tensor: &Matrix3) -> Matrix3 {
    let half = tensor.map(|row| multiply(rotation, row));
    let mut carried = [[0.0; 3]; 3];
    for (row, weights) in carried.iter_mut().zip(rotation) {
        *row = multiply_transposed(&half, *weights);
    }
    carried
}

/// sin(t)/t, 1 at zero. The quotient is accurate to rounding for every t above zero.
fn cardinal_sine(argument: f64) -> f64 {
    if argument > 0.0 {
        argument.sin() / argument
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use proptest::prelude::*;

    use super::*;
    use crate::geometry::vector3::scale;

    fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-limit..limit)
    }

    fn motion() -> impl Strategy<Value = RigidMotion> {
        (vector(5.0), vector(20.0), vector(3.0)).prop_map(|(translation, rotation, about)| {
            RigidMotion {
                translation,
                rotation,
                about,
            }
        })
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        norm(sub(a, b))
    }

    #[test]
    fn zero_rotation_is_exactly_the_identity() {
        assert_eq!(
            rotation_matrix([0.0; 3]),
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        );
    }

    #[test]
    fn tiny_rotations_keep_their_first_order_part() {
        for angle in [1e-300, 1e-160, 1e-20, 1e-9] {
            let turned = multiply(&rotation_matrix([0.0, 0.0, angle]), [1.0, 0.0, 0.0]);
            assert!((turned[1] / angle - 1.0).abs() < 1e-15, "{angle}");
        }
    }

    #[test]
    fn quarter_turn_maps_x_to_y() {
        let turned = multiply(&rotation_matrix([0.0, 0.0, 0.5 * PI]), [1.0, 0.0, 0.0]);
        assert!(distance(turned, [0.0, 1.0, 0.0]) < 1e-15);
    }

    #[test]
    fn whole_turns_do_nothing() {
        let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        for turns in [1.0, 2.0, 7.0] {
            let matrix = rotation_matrix(scale(turns * TAU, axis));
            let point = [0.3, -0.7, 1.1];
            assert!(distance(multiply(&matrix, point), point) < 1e-13, "{turns}");
        }
    }

    #[test]
    fn reference_point_is_only_translated() {
        let motion = RigidMotion {
            translation: [1.0, 2.0, 3.0],
            rotation: [0.4, -2.0, 9.0],
            about: [-1.0, 0.5, 2.0],
        };
        assert!(distance(motion.apply(motion.about), [0.0, 2.5, 5.0]) < 1e-15);
    }

    #[test]
    fn rotation_vector_stays_fixed() {
        let rotation = [0.4, -2.0, 9.0];
        let turned = multiply(&rotation_matrix(rotation), rotation);
        assert!(distance(turned, rotation) < 1e-13);
    }

    #[test]
    fn tiny_rotations_move_points_by_their_arm() {
        let motion = RigidMotion {
            rotation: [0.0, 0.0, 1e-30],
            about: [1.0, 0.0, 0.0],
            ..RigidMotion::default()
        };
        let moved = motion.displacement([3.0, 0.0, 0.0])[1];
        assert!((moved / 2e-30 - 1.0).abs() < 1e-15);
        assert!(RigidMotion::default().is_rest() && !motion.is_rest());
    }

    proptest! {
        #[test]
        fn a_displacement_leads_from_a_point_to_its_image(motion in motion(), point in vector(10.0)) {
            let moved = add(point, motion.displacement(point));
            prop_assert!(distance(moved, motion.apply(point)) < 1e-12);
        }

        #[test]
        fn another_reference_point_gives_the_same_motion(
            motion in motion(), about in vector(3.0), point in vector(10.0),
        ) {
            let same = motion.expressed_about(about);
            prop_assert!(distance(same.about, about) < f64::MIN_POSITIVE);
            prop_assert!(distance(same.apply(point), motion.apply(point)) < 1e-11);
        }

        #[test]
        fn inverse_undoes_the_motion(motion in motion(), point in vector(10.0)) {
            prop_assert!(distance(motion.inverse_apply(motion.apply(point)), point) < 1e-12);
            prop_assert!(distance(motion.apply(motion.inverse_apply(point)), point) < 1e-12);
            prop_assert!(distance(motion.inverse_rotate(motion.rotate(point)), point) < 1e-12);
        }

        #[test]
        fn motions_keep_distances_and_handedness(
            motion in motion(), a in vector(10.0), b in vector(10.0),
        ) {
            let moved = distance(motion.apply(a), motion.apply(b));
            prop_assert!((moved - distance(a, b)).abs() < 1e-12);
            let [x, y, z] = motion.matrix();
            let determinant = dot(x, cross(y, z));
            prop_assert!((determinant - 1.0).abs() < 1e-13);
        }

        #[test]
        fn conjugated_tensor_acts_on_rotated_vectors(
            motion in motion(), a in vector(2.0), b in vector(2.0), v in vector(2.0),
        ) {
            let mut tensor = [[0.0; 3]; 3];
            for row in 0..3 {
                for column in 0..3 {
                    tensor[row][column] = a[row] * a[column] + b[row] * b[column];
                }
            }
            let matrix = motion.matrix();
            let carried = multiply(&conjugate(&matrix, &tensor), multiply(&matrix, v));
            let expected = multiply(&matrix, multiply(&tensor, v));
            prop_assert!(distance(carried, expected) < 1e-11);
        }
    }
}
