//! How far an obstacle moves over the faces that may touch it, and poses on its way:
//!
//! ```text
//! |x(s) - x(0)| <= s (|t1 - t0| + |r1 - r0| max |x - c - t|),   x = c + t + R(r) X,   s from 0 to 1
//! ```
//!
//! t the translation, r the rotation vector, c the reference point, the maximum over the nodes of
//! the faces and both ends. dR/dr has norm one at most, so that a turn moves a point by less than
//! angle times lever. As distances change by no more than what moves, the next pose that may
//! differ is as far on as the obstacle is from the body. Lengths are those of the scaled body.
//! Cost: a pass over the faces, and some distances a face at each pose.

use super::Model;
use super::drive::Drive;
use super::interfaces::Interface;
use crate::contact::nearest::nearest;
use crate::geometry::RigidMotion;
use crate::geometry::vector3::{add, norm, sub};

/// Poses at least and at most, before they become fewer.
const FEWEST_POSES: f64 = 100.0;
const MOST_POSES: f64 = 4000.0;
/// Faces times poses at most.
const MOST_SAMPLES: f64 = 4e5;

/// How far `interface`'s obstacle moves between two drives at most, over its faces as each of
/// `displacements` `[displacement]` puts them.
pub(crate) fn travel(
    model: &Model<'_>,
    interface: &Interface,
    [start, end]: [&Drive; 2],
    displacements: &[&[f64]],
) -> f64 {
    let motion = |drive: &Drive| {
        let mut placed = model.placed(drive);
        let own = placed.find(|(other, _)| other.name == interface.name);
        own.and_then(|(_, met)| met.obstacle().map(|obstacle| obstacle.motion()))
    };
    let (Some(start), Some(end)) = (motion(start), motion(end)) else {
        return 0.0;
    };
    let reach = |centre: [f64; 3]| {
        let bodies = displacements.iter();
        let reaches = bodies.map(|displacement| reach(model, interface, displacement, centre));
        reaches.fold(0.0, f64::max)
    };
    length([start, end], reach)
}

/// Length of the way of a motion, `reach` the distance of the farthest point from a centre.
fn length([start, end]: [RigidMotion; 2], reach: impl Fn([f64; 3]) -> f64) -> f64 {
    let shift = norm(sub(end.translation, start.translation));
    let turn = norm(sub(end.rotation, start.rotation));
    if turn == 0.0 {
        return shift;
    }
    let levers = [start, end].map(|motion| reach(add(motion.about, motion.translation)));
    shift + turn * levers[0].max(levers[1])
}

/// Distance of the farthest node of the faces from `centre`; edges bend by less than their middles are off.
fn reach(model: &Model<'_>, interface: &Interface, displacement: &[f64], centre: [f64; 3]) -> f64 {
    let (mut farthest, mut bent) = (0.0_f64, 0.0_f64);
    for face in &interface.surface.faces {
        for &corner in &face.corners {
            let place = model.place(corner as usize, displacement);
            farthest = farthest.max(norm(sub(place, centre)));
        }
        for &node in face.nodes.iter().skip(face.corners.len()) {
            bent = bent.max(norm(model.place(node as usize, displacement)));
        }
    }
    farthest + bent
}

/// Signed distance of an obstacle from the body where `drive` puts it and `displacement` the
/// body.
pub(crate) fn least_distance(
    model: &Model<'_>,
    (drive, displacement): (&Drive, &[f64]),
    interface: &Interface,
) -> f64 {
    let mut placed = model.placed(drive);
    let met = placed.find(|(other, _)| other.name == interface.name);
    let body = model.deformed(displacement);
    let met = met.as_ref().and_then(|(_, met)| met.obstacle());
    met.map_or(f64::INFINITY, |obstacle| {
        let distances = nearest(&body, &interface.surface, obstacle);
        distances.into_iter().fold(f64::INFINITY, f64::min)
    })
}

/// Poses on a way, as far apart as the obstacle is from the body.
pub(crate) struct March {
    /// Length of the way.
    way: f64,
    /// Least length between two poses.
    spacing: f64,
    /// Poses from which on the spacing is a share of the way.
    most: f64,
    /// Length behind, and poses on it.
    gone: f64,
    poses: f64,
}

impl March {
    /// On a way of that length before that many faces, poses at least `spacing` apart.
    pub(crate) fn new(way: f64, spacing: f64, faces: usize) -> Self {
        let most = MOST_SAMPLES / faces.max(1) as f64;
        Self {
            way,
            spacing,
            most: most.clamp(FEWEST_POSES, MOST_POSES),
            gone: 0.0,
            poses: 0.0,
        }
    }

    /// The share of the way at which the next pose is, after one at that `distance` from the
    /// body, its end at last; none after that.
    pub(crate) fn next(&mut self, distance: f64) -> Option<f64> {
        if self.gone >= self.way {
            return None;
        }
        let least = if self.poses < self.most {
            self.spacing
        } else {
            self.spacing.max(self.way / self.most)
        };
        // No nearer than it is can it come on a way as long as that.
        self.gone += distance.max(least);
        self.poses += 1.0;
        Some((self.gone / self.way).min(1.0))
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
