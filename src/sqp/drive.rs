//! What drives a body: load factor, obstacle poses, support values, in the
//! caller's units, and their linear ramps.

use crate::scene::{Scene, Step};

/// Pose of an obstacle from its initial one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstaclePose {
    /// Obstacle name.
    pub name: String,
    /// Translation `[length, 3]`.
    pub translation: [f64; 3],
    /// Rotation vector about the reference point `[radians, 3]`.
    pub rotation: [f64; 3],
}

/// Everything that ramps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    pub(crate) load: f64,
    pub(crate) poses: Vec<ObstaclePose>,
    /// Prescribed components of each support.
    pub(crate) supports: Vec<[f64; 3]>,
}

impl Drive {
    /// The undeformed state.
    pub(crate) fn undeformed(scene: &Scene) -> Self {
        Self {
            load: 0.0,
            poses: scene
                .obstacles
                .iter()
                .map(|obstacle| ObstaclePose {
                    name: obstacle.name.clone(),
                    ..ObstaclePose::default()
                })
                .collect(),
            supports: vec![[0.0; 3]; scene.supports.len()],
        }
    }

    /// Where the first step leads when it names nothing.
    pub(crate) fn first_target(scene: &Scene) -> Self {
        Self {
            load: 1.0,
            supports: scene
                .supports
                .iter()
                .map(|support| support.displacement.map(|value| value.unwrap_or(0.0)))
                .collect(),
            ..Self::undeformed(scene)
        }
    }

    /// The end of a step that starts from this target.
    pub(crate) fn after(&self, scene: &Scene, step: &Step) -> Self {
        let mut end = self.clone();
        end.load = step.load.unwrap_or(end.load);
        for target in &step.obstacles {
            if let Some(pose) = end.poses.iter_mut().find(|pose| pose.name == target.name) {
                pose.translation = target.translation.unwrap_or(pose.translation);
                pose.rotation = target.rotation.unwrap_or(pose.rotation);
            }
        }
        for target in &step.supports {
            let index = scene.supports.iter().position(|s| s.name == target.name);
            if let Some(values) = index.and_then(|index| end.supports.get_mut(index)) {
                for (value, new) in values.iter_mut().zip(target.displacement) {
                    *value = new.unwrap_or(*value);
                }
            }
        }
        end
    }

    /// A fraction of the way to `end`; exactly `end` at one.
    pub(crate) fn towards(&self, end: &Self, fraction: f64) -> Self {
        if fraction >= 1.0 {
            return end.clone();
        }
        let mix = |a: f64, b: f64| a + fraction * (b - a);
        let mix3 = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| mix(a[i], b[i]));
        Self {
            load: mix(self.load, end.load),
            poses: self
                .poses
                .iter()
                .zip(&end.poses)
                .map(|(a, b)| ObstaclePose {
                    name: a.name.clone(),
                    translation: mix3(a.translation, b.translation),
                    rotation: mix3(a.rotation, b.rotation),
                })
                .collect(),
            supports: self
                .supports
                .iter()
                .zip(&end.supports)
                .map(|(a, b)| mix3(*a, *b))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Obstacle, ObstacleTarget, Profile, Shape, Support, SupportTarget};

    fn scene() -> Scene {
        Scene {
            supports: vec![Support {
                name: "wall".to_owned(),
                on: vec!["x0".to_owned()],
                displacement: [Some(0.5), None, Some(0.0)],
                profile: Profile::Constant,
            }],
            obstacles: vec![Obstacle {
                name: "ball".to_owned(),
                on: vec!["z1".to_owned()],
                shape: Shape::Sphere {
                    centre: [0.0; 3],
                    radius: 1.0,
                },
            }],
            ..Scene::default()
        }
    }

    fn step() -> Step {
        Step {
            load: Some(-2.0),
            obstacles: vec![ObstacleTarget {
                name: "ball".to_owned(),
                translation: Some([1.0, 2.0, 3.0]),
                rotation: None,
            }],
            supports: vec![SupportTarget {
                name: "wall".to_owned(),
                displacement: [None, None, Some(4.0)],
            }],
            ..Step::default()
        }
    }

    /// Bits, so that equal means the same number.
    fn bits(vector: [f64; 3]) -> [u64; 3] {
        vector.map(f64::to_bits)
    }

    #[test]
    fn the_first_step_leads_to_full_load_and_the_scenes_values() {
        let target = Drive::first_target(&scene()).after(&scene(), &Step::default());
        assert_eq!(target.load.to_bits(), 1.0_f64.to_bits());
        assert_eq!(bits(target.supports[0]), bits([0.5, 0.0, 0.0]));
        assert_eq!(bits(target.poses[0].translation), bits([0.0; 3]));
    }

    #[test]
    fn a_step_changes_what_it_names() {
        let first = Drive::first_target(&scene());
        let end = first.after(&scene(), &step());
        assert_eq!(end.load.to_bits(), (-2.0_f64).to_bits());
        assert_eq!(bits(end.supports[0]), bits([0.5, 0.0, 4.0]));
        assert_eq!(bits(end.poses[0].translation), bits([1.0, 2.0, 3.0]));
        assert_eq!(bits(end.poses[0].rotation), bits([0.0; 3]));
        assert_eq!(end.after(&scene(), &Step::default()), end);
    }

    #[test]
    fn everything_ramps_linearly_and_ends_exactly() {
        let start = Drive::undeformed(&scene());
        let end = Drive::first_target(&scene()).after(&scene(), &step());
        let half = start.towards(&end, 0.5);
        assert!((half.load + 1.0).abs() < 1e-15);
        assert_eq!(bits(half.supports[0]), bits([0.25, 0.0, 2.0]));
        assert_eq!(bits(half.poses[0].translation), bits([0.5, 1.0, 1.5]));
        assert_eq!(start.towards(&end, 0.0), start);
        assert_eq!(start.towards(&end, 1.0), end);
    }
}
