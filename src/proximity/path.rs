//! How far an obstacle moves from one pose to another, and poses on its path:
//!
//! ```text
//! |x(s) - x(0)| <= s (|t1 - t0| + |r1 - r0| max |x - c - t|),   x = c + t + R(r) X,   s from 0 to 1
//! ```
//!
//! t the translation, r the rotation vector, c the reference point, the maximum over points of the
//! body and both ends. dR/dr has norm one at most, so that a turn moves a point by less than
//! angle times lever. As distances change by no more than what moves, the next pose that may
//! differ is as far on as the obstacle is from the body.

use crate::geometry::RigidMotion;
use crate::geometry::vector3::{add, norm, sub};

/// Poses at least and at most, before they become fewer.
const FEWEST_POSES: f64 = 100.0;
const MOST_POSES: f64 = 4000.0;
/// Faces times poses at most.
const MOST_SAMPLES: f64 = 4e5;

/// Length of the path from one pose to another, `reach` the distance of the farthest point from a centre.
pub fn length([start, end]: [RigidMotion; 2], reach: impl Fn([f64; 3]) -> f64) -> f64 {
    let shift = norm(sub(end.translation, start.translation));
    let turn = norm(sub(end.rotation, start.rotation));
    if turn == 0.0 {
        return shift;
    }
    let levers = [start, end].map(|motion| reach(add(motion.about, motion.translation)));
    shift + turn * levers[0].max(levers[1])
}

/// Poses on a path, as far apart as the obstacle is from the body.
pub struct March {
    /// Length of the path.
    length: f64,
    /// Least length between two poses.
    spacing: f64,
    /// Poses from which on the spacing is a share of the path.
    most: f64,
    /// Length gone, and poses on it.
    gone: f64,
    poses: f64,
}

impl March {
    /// On a path of that length before that many faces, poses at least `spacing` apart.
    pub fn new(length: f64, spacing: f64, faces: usize) -> Self {
        let most = MOST_SAMPLES / faces.max(1) as f64;
        Self {
            length,
            spacing,
            most: most.clamp(FEWEST_POSES, MOST_POSES),
            gone: 0.0,
            poses: 0.0,
        }
    }

    /// The share of the path at which the next pose is, after one at that `distance` from the
    /// body, its end at last; none after that.
    pub fn next(&mut self, distance: f64) -> Option<f64> {
        if self.gone >= self.length {
            return None;
        }
        let least = if self.poses < self.most {
            self.spacing
        } else {
            self.spacing.max(self.length / self.most)
        };
        // No nearer than it is can it come on a path as long as that.
        self.gone += distance.max(least);
        self.poses += 1.0;
        Some((self.gone / self.length).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn motion(translation: [f64; 3], rotation: [f64; 3]) -> RigidMotion {
        RigidMotion {
            translation,
            rotation,
            about: [0.0, 8.0, 0.0],
        }
    }

    #[test]
    fn no_point_moves_farther_than_the_way_that_a_motion_is_said_to_have() {
        let point = [0.5, 0.2, -0.7];
        let reach = |centre: [f64; 3]| norm(sub(point, centre));
        let start = motion([0.1, 0.0, 0.3], [0.2, 0.0, 0.4]);
        for (translation, rotation) in [
            ([0.1, 0.0, 0.3], [0.6, 0.0, 0.0]),
            ([1.1, -2.0, 0.3], [0.2, 0.0, 0.4]),
            ([5.0, 3.0, 0.3], [-1.0, 2.0, 3.0]),
        ] {
            let end = motion(translation, rotation);
            let way = length([start, end], reach);
            let mut last = start.inverse_apply(point);
            for step in 1..=100 {
                let share = f64::from(step) / 100.0;
                let mix = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
                    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
                };
                let at = motion(
                    mix(start.translation, end.translation),
                    mix(start.rotation, end.rotation),
                );
                let next = at.inverse_apply(point);
                let moved = norm(sub(next, last));
                assert!(moved <= 0.01 * way * (1.0 + 1e-9), "{share} {moved} {way}");
                last = next;
            }
        }
    }

    #[test]
    fn half_a_turn_is_as_long_as_half_a_circle() {
        let turns = [motion([0.0; 3], [0.0; 3]), motion([0.0; 3], [PI, 0.0, 0.0])];
        let way = length(turns, |centre| norm(sub([0.0, 6.0, 0.0], centre)));
        assert!((way - 2.0 * PI).abs() < 1e-12, "{way}");
    }

    #[test]
    fn a_march_steps_by_the_distance_and_ends_at_the_end() {
        let mut march = March::new(10.0, 0.5, 1);
        let shares: Vec<f64> = std::iter::from_fn(|| march.next(4.0)).collect();
        assert_eq!(shares, [0.4, 0.8, 1.0]);
        let mut march = March::new(1e18, 0.5, 1);
        let poses = std::iter::from_fn(|| march.next(-1.0)).count() as f64;
        assert!(poses <= 2.0 * MOST_POSES + 1.0, "{poses}");
    }
}
