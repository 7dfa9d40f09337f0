//! Obstacles and supports that are pushed rather than led: what they shall exert on the body,
//! component by component, in the caller's units. The pose of those components follows from that.
//!
//! ```text
//! sum of forces = F_i,   sum of their moments about the reference point = M_j
//! ```
//!
//! A support that a spring holds to the ground exerts what it shall less what the spring takes.
//! Axes 0 to 2 are those of translation and force, 3 to 5 those of rotation and moment.

use crate::scene::{ObstacleTarget, SupportTarget};

/// What one obstacle or support shall exert; none where its pose is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Push {
    /// Forces, then moments about the reference point `[6]`.
    pub(crate) components: [Option<f64>; 6],
}

/// What has a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// The obstacle of that number in the plan.
    Obstacle(usize),
    /// The support of that number.
    Support(usize),
}

/// A component of a pose that follows from a push.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Control {
    /// What moves.
    pub(crate) part: Part,
    /// Axis of the component, 0 to 5.
    pub(crate) axis: usize,
}

impl Control {
    /// Whether the pose is that of a support.
    pub(crate) fn is_of_support(self) -> bool {
        matches!(self.part, Part::Support(_))
    }

    /// Key of the scene by which a step asks for it, after that of the part.
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

    /// After a step that names `target`: a pose that is named ends the push along its axes,
    /// unless a push is named there, too.
    pub(crate) fn after(&self, target: &ObstacleTarget) -> Self {
        let is_led = [target.translation.is_some(), target.rotation.is_some()];
        self.replaced([target.force, target.moment], is_led)
    }

    /// The same of a support; a displacement that is named ends the push along its axis, and no
    /// step ends one of an axis with a `spring` `[6]`.
    pub(crate) fn after_support(&self, target: &SupportTarget, spring: &[f64; 6]) -> Self {
        let is_led = [target.translation.is_some(), target.rotation.is_some()];
        let mut after = self.replaced([target.force, target.moment], is_led);
        let named = target.displacement.iter().zip(target.force).enumerate();
        for (axis, _) in named.filter(|(_, (value, force))| value.is_some() && force.is_none()) {
            after.components[axis] = None;
        }
        let sprung = after.components.iter_mut().zip(self.components).zip(spring);
        for ((own, before), _) in sprung.filter(|(_, spring)| **spring > 0.0) {
            *own = own.or(before).or(Some(0.0));
        }
        after
    }

    /// This push with `named` forces and moments in the place of those halves that they name or
    /// that are led.
    fn replaced(&self, named: [[Option<f64>; 3]; 2], is_led: [bool; 2]) -> Self {
        let mut components = self.components;
        let halves = components.chunks_exact_mut(3).zip(named).zip(is_led);
        for ((own, named), is_led) in halves {
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

/// What parts exert on the body, in the caller's units: forces, then moments about their reference
/// points; of supports, with what their springs take.
#[derive(Clone, Debug, Default)]
pub(crate) struct Applied {
    /// `[obstacles][6]`.
    pub(crate) obstacles: Vec<[f64; 6]>,
    /// `[supports][6]`.
    pub(crate) supports: Vec<[f64; 6]>,
}

impl Applied {
    /// Along one component; zero of a part that is not there.
    pub(crate) fn at(&self, control: Control) -> f64 {
        let found = match control.part {
            Part::Obstacle(index) => self.obstacles.get(index),
            Part::Support(index) => self.supports.get(index),
        };
        found.map_or(0.0, |found| found[control.axis])
    }
}

/// Three components along axes, then three about them.
pub(crate) fn joined(along: [f64; 3], about: [f64; 3]) -> [f64; 6] {
    std::array::from_fn(|axis| match axis {
        0..3 => along[axis],
        _ => about[axis - 3],
    })
}

/// The pushes; none where no part is pushed.
pub(crate) fn named(pushes: Vec<Push>) -> Vec<Push> {
    if pushes.iter().all(Push::is_none) {
        Vec::new()
    } else {
        pushes
    }
}

/// What is exerted on the way from `start` to `end`.
pub(crate) fn towards(start: &[Push], end: &[Push], fraction: f64) -> Vec<Push> {
    let pushes = end.iter().enumerate();
    let pushes = pushes.map(|(index, end)| match start.get(index) {
        Some(start) => start.towards(end, fraction),
        None => *end,
    });
    pushes.collect()
}

/// Pushes to start from wherever `end` has one: `own`, else what is `applied`.
pub(crate) fn filled(own: &[Push], end: &[Push], applied: &[[f64; 6]]) -> Vec<Push> {
    let own = |index: usize| own.get(index).copied().unwrap_or_default();
    let pushes = end.iter().zip(applied).enumerate();
    let pushes = pushes.map(|(index, (end, applied))| own(index).filled(end, applied));
    pushes.collect()
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
