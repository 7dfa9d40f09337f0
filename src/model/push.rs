//! Obstacles that are pushed rather than led: what they shall exert on the body, component by
//! component, in the caller's units. The pose of those components follows from that.
//!
//! ```text
//! sum of contact forces = F_i,   sum of their moments about the reference point = M_j
//! ```
//!
//! Axes 0 to 2 are those of translation and force, 3 to 5 those of rotation and moment.

use crate::scene::ObstacleTarget;

/// What one obstacle shall exert; none where its pose is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Push {
    /// Forces, then moments about the reference point `[6]`.
    pub(crate) components: [Option<f64>; 6],
}

/// A component of a pose that follows from a push.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Control {
    /// Number of the obstacle in the plan.
    pub(crate) obstacle: usize,
    /// Axis of the component, 0 to 5.
    pub(crate) axis: usize,
}

impl Control {
    /// Key of the scene by which a step asks for it, after that of the obstacle.
    pub(crate) fn key(self) -> &'static str {
        const KEYS: [&str; 6] = [
            "force.x", "force.y", "force.z", "moment.x", "moment.y", "moment.z",
        ];
        KEYS[self.axis]
    }
}

impl Push {
    /// Whether the pose follows in no component.
    pub(crate) fn is_none(&self) -> bool {
        self.components.iter().all(Option::is_none)
    }

    /// Behind a step that names `target`: a pose that is named ends the push along its axes,
    /// unless a push is named there, too.
    pub(crate) fn after(&self, target: &ObstacleTarget) -> Self {
        let mut components = self.components;
        let (forces, moments) = components.split_at_mut(3);
        let halves = [
            (forces, target.force, target.translation.is_some()),
            (moments, target.moment, target.rotation.is_some()),
        ];
        for (own, named, is_led) in halves {
            if named.iter().any(Option::is_some) || is_led {
                own.copy_from_slice(&named);
            }
        }
        Self { components }
    }

    /// A fraction of the way to `end`, whose components it has.
    pub(crate) fn towards(&self, end: &Self, fraction: f64) -> Self {
        let mut components = end.components;
        for (value, start) in components.iter_mut().zip(self.components) {
            if let (Some(value), Some(start)) = (value, start) {
                *value = start + fraction * (*value - start);
            }
        }
        Self { components }
    }

    /// What `end` asks for, where this does not say where it starts from: `exerted` `[6]`.
    pub(crate) fn filled(&self, end: &Self, exerted: &[f64; 6]) -> Self {
        let mut components = [None; 6];
        for (axis, value) in components.iter_mut().enumerate() {
            *value = end.components[axis].map(|_| self.components[axis].unwrap_or(exerted[axis]));
        }
        Self { components }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(z: f64) -> ObstacleTarget {
        ObstacleTarget {
            force: [None, None, Some(z)],
            ..ObstacleTarget::default()
        }
    }

    #[test]
    fn a_push_lasts_until_a_pose_is_named_along_its_axes() {
        let push = Push::default().after(&pushed(-2.0));
        assert_eq!(push.components[2], Some(-2.0));
        let turned = ObstacleTarget {
            rotation: Some([0.0, 0.0, 1.0]),
            ..ObstacleTarget::default()
        };
        assert_eq!(push.after(&turned), push);
        let led = ObstacleTarget {
            translation: Some([1.0, 0.0, 0.0]),
            ..ObstacleTarget::default()
        };
        assert!(push.after(&led).is_none());
        let both = ObstacleTarget {
            translation: Some([1.0, 0.0, 0.0]),
            ..pushed(-3.0)
        };
        assert_eq!(push.after(&both).components[2], Some(-3.0));
    }

    #[test]
    fn a_push_ramps_from_what_the_obstacle_exerts() {
        let end = Push::default().after(&pushed(-2.0));
        let start = Push::default().filled(&end, &[9.0, 9.0, -1.0, 9.0, 9.0, 9.0]);
        assert_eq!(start.components, [None, None, Some(-1.0), None, None, None]);
        let half = start.towards(&end, 0.5);
        assert_eq!(half.components[2], Some(-1.5));
    }
}
