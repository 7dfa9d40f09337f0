//! What drives a body: load factor, obstacle poses, support values, in the
//! caller's units, and their linear ramps.

use crate::scene::{Scene, Step};

/// Pose of an obstacle from its initial one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstaclePose {
    /// Obstacle name.
    pub name: String,
    /// Translation [length, 3].
    pub translation: [f64; 3],
    /// Rotation vector about the reference point [radians, 3].
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
