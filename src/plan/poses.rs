//! Where steps lead an obstacle, as far as that is known before anything is solved: what follows
//! from pushes is not.

use std::sync::Arc;

use super::Units;
use crate::obstacle::Moving;
use crate::scene::Step;
use crate::scene::validate::ResolvedObstacle;

/// Poses that are looked at, of each obstacle.
const MOST: usize = 64;

/// Where an obstacle is told to be, from its initial pose: length, radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pose {
    pub(super) translation: [f64; 3],
    pub(super) rotation: [f64; 3],
}

impl Pose {
    /// The obstacle there.
    pub(super) fn of(self, obstacle: &ResolvedObstacle, units: &Units) -> Moving {
        let translation = self.translation.map(|x| x / units.length);
        Moving::new(Arc::clone(&obstacle.shape), translation, self.rotation)
    }

    /// A share of the way to another pose.
    pub(super) fn towards(self, to: Self, share: f64) -> Self {
        let between = |a: [f64; 3], b: [f64; 3]| {
            std::array::from_fn(|axis| (1.0 - share) * a[axis] + share * b[axis])
        };
        Self {
            translation: between(self.translation, to.translation),
            rotation: between(self.rotation, to.rotation),
        }
    }
}

/// The poses of an obstacle, its first one before those at the ends of the steps.
pub(super) fn poses(name: &str, steps: &[Step]) -> Vec<Pose> {
    let mut poses = vec![Pose::default()];
    let mut last = Pose::default();
    let targets = steps.iter().flat_map(|step| &step.obstacles);
    for target in targets.filter(|target| target.name == name) {
        last.translation = target.translation.unwrap_or(last.translation);
        last.rotation = target.rotation.unwrap_or(last.rotation);
        poses.push(last);
    }
    poses
}

/// Those poses with one half way between each two.
pub(super) fn with_middles(poses: &[Pose]) -> Vec<Pose> {
    let middles = poses
        .windows(2)
        .flat_map(|pair| [pair[0].towards(pair[1], 0.5), pair[1]]);
    poses.first().copied().into_iter().chain(middles).collect()
}

/// Some of the poses where they are many, the last one among them.
pub(super) fn some(poses: &[Pose]) -> Vec<Pose> {
    let stride = poses.len().div_ceil(MOST).max(1);
    poses.iter().rev().step_by(stride).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ObstacleTarget;

    /// A step that leads an obstacle there.
    fn moved(name: &str, translation: [f64; 3]) -> Step {
        Step {
            obstacles: vec![ObstacleTarget {
                name: name.to_owned(),
                translation: Some(translation),
                ..ObstacleTarget::default()
            }],
            ..Step::default()
        }
    }

    #[test]
    fn tools_are_followed_through_the_poses_of_their_steps() {
        let steps = [
            moved("ball", [2.0, 0.0, 0.0]),
            moved("other", [9.0; 3]),
            moved("ball", [2.0, 4.0, 0.0]),
        ];
        let ways = with_middles(&poses("ball", &steps)).into_iter();
        let ways: Vec<[f64; 3]> = ways.map(|pose| pose.translation).collect();
        let expected = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 4.0]];
        assert_eq!(ways, expected.map(|[x, y]| [x, y, 0.0]));
        let steps: Vec<Step> = (0..500)
            .map(|i| moved("ball", [f64::from(i), 0.0, 0.0]))
            .collect();
        let long = some(&poses("ball", &steps));
        assert!(long.len() <= MOST, "{}", long.len());
        let far = long.iter().map(|pose| pose.translation[0]);
        assert!(far.fold(0.0, f64::max) >= 499.0);
    }
}
