//! What drives a body: load factor, obstacle poses, support values, in the
//! caller's units, and their linear ramps.
//!
//! A drive is what fields in equilibrium belong to; a step leads from one to another, and
//! every increment ends at a point between them:
//!
//! ```text
//! value = (1 - s) start + s end,   0 <= s <= 1
//! ```
//!
//! for load factor, translations, rotation vectors and prescribed displacements alike.
//! Obstacles and supports are in the order of the plan. Lengths are the caller's, angles
//! radians.

use crate::geometry::rigid_motion::RigidMotion;
use crate::plan::Plan;
use crate::scene::{ObstacleTarget, Step, SupportTarget};

/// Difference of two ways, over the values' own size, that rounding leaves.
const PARALLEL: f64 = 1e-9;

/// Pose of an obstacle from its initial one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstaclePose {
    /// Name of the obstacle.
    pub name: String,
    /// Translation from the initial pose `[3]`, length.
    pub translation: [f64; 3],
    /// Rotation vector about the reference point `[radians, 3]`.
    pub rotation: [f64; 3],
}

/// Everything that ramps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    /// Factor of all loads: tractions, body force and pressures.
    pub(crate) load: f64,
    /// Pose of each obstacle, in the order of the plan.
    pub(crate) poses: Vec<ObstaclePose>,
    /// Coefficient of friction of each obstacle, in the order of the plan; constant through
    /// a step. Empty where no obstacle is rough.
    pub(crate) friction: Vec<f64>,
    /// Prescribed components of each support; a normal component stands first.
    pub(crate) supports: Vec<[f64; 3]>,
    /// Rigid motion of each support, added to its components.
    pub(crate) motions: Vec<RigidMotion>,
}

impl Drive {
    /// The undeformed state.
    pub(crate) fn undeformed(plan: &Plan) -> Self {
        let supports = plan.resolved.supports.len();
        Self {
            load: 0.0,
            poses: plan
                .obstacles
                .iter()
                .map(|obstacle| ObstaclePose {
                    name: obstacle.name.clone(),
                    ..ObstaclePose::default()
                })
                .collect(),
            friction: match plan.has_friction() {
                true => plan.obstacles.iter().map(|one| one.friction).collect(),
                false => Vec::new(),
            },
            supports: vec![[0.0; 3]; supports],
            motions: vec![RigidMotion::default(); supports],
        }
    }

    /// Where the first step leads when it names nothing.
    pub(crate) fn first_target(plan: &Plan) -> Self {
        Self {
            load: 1.0,
            supports: plan
                .resolved
                .supports
                .iter()
                .map(|support| match support.normal {
                    Some(value) => [value, 0.0, 0.0],
                    None => support.displacement.map(|value| value.unwrap_or(0.0)),
                })
                .collect(),
            ..Self::undeformed(plan)
        }
    }

    /// The end of a step that starts from this target.
    pub(crate) fn after(&self, plan: &Plan, step: &Step) -> Self {
        let mut end = self.clone();
        end.load = step.load.unwrap_or(end.load);
        step.obstacles.iter().for_each(|one| end.place(one));
        step.supports.iter().for_each(|one| end.hold(plan, one));
        end
    }

    /// Sets the pose and the friction that a step names; what the step leaves out keeps
    /// its value.
    fn place(&mut self, target: &ObstacleTarget) {
        let mut poses = self.poses.iter_mut().enumerate();
        if let Some((index, pose)) = poses.find(|(_, pose)| pose.name == target.name) {
            if let (Some(own), Some(new)) = (self.friction.get_mut(index), target.friction) {
                *own = new;
            }
            pose.translation = target.translation.unwrap_or(pose.translation);
            pose.rotation = target.rotation.unwrap_or(pose.rotation);
        }
    }

    /// Sets displacement and motion of the support that a step names; what the step
    /// leaves out keeps its value.
    fn hold(&mut self, plan: &Plan, target: &SupportTarget) {
        let mut supports = plan.resolved.supports.iter();
        let Some(index) = supports.position(|support| support.name == target.name) else {
            return;
        };
        for (value, new) in self.supports[index].iter_mut().zip(target.displacement) {
            *value = new.unwrap_or(*value);
        }
        let motion = &mut self.motions[index];
        motion.translation = target.translation.unwrap_or(motion.translation);
        motion.rotation = target.rotation.unwrap_or(motion.rotation);
        motion.about = target.about.unwrap_or(motion.about);
    }

    /// Whether any support prescribes more than zeros.
    pub(crate) fn moves_supports(&self) -> bool {
        let values = self.supports.as_flattened();
        values.iter().any(|&value| value != 0.0)
            || self.motions.iter().any(|motion| !motion.is_rest())
    }

    /// r where the way from `to` to this drive is r times that from `from` to `to`,
    /// to round-off; none where it is another way, or one of them has no length.
    pub(crate) fn continues(&self, from: &Self, to: &Self) -> Option<f64> {
        let [a, b, c] = [from, to, self].map(|drive| drive.values(self));
        // Each value over its own size: loads, lengths and angles have no common one.
        let ways = a.iter().zip(&b).zip(&c).map(|((a, b), c)| {
            let size = a.abs().max(b.abs()).max(c.abs()).max(f64::MIN_POSITIVE);
            ((b - a) / size, (c - b) / size)
        });
        let ways: Vec<_> = ways.collect();
        let length: f64 = ways.iter().map(|(last, _)| last * last).sum();
        let ratio = ways.iter().map(|(last, next)| last * next).sum::<f64>() / length;
        let is_parallel = ways
            .iter()
            .all(|(last, next)| (next - ratio * last).abs() <= PARALLEL);
        (length > 0.0 && ratio != 0.0 && is_parallel).then_some(ratio)
    }

    /// All numbers, motions expressed about the reference points of `other`.
    fn values(&self, other: &Self) -> Vec<f64> {
        let poses = self.poses.iter();
        let poses = poses.flat_map(|pose| [pose.translation, pose.rotation]);
        let motions = self.motions.iter().zip(&other.motions);
        let motions = motions.flat_map(|(motion, other)| {
            let motion = motion.expressed_about(other.about);
            [motion.translation, motion.rotation]
        });
        let vectors = poses.chain(self.supports.iter().copied()).chain(motions);
        std::iter::once(self.load)
            .chain(vectors.flatten())
            .collect()
    }

    /// This drive with no load factor where the body of `plan` has no load.
    pub(crate) fn felt_by(&self, plan: &Plan) -> Self {
        let mut felt = self.clone();
        felt.load = if plan.resolved.is_loaded() {
            self.load
        } else {
            0.0
        };
        felt
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
            friction: end.friction.clone(),
            supports: self
                .supports
                .iter()
                .zip(&end.supports)
                .map(|(a, b)| mix3(*a, *b))
                .collect(),
            motions: self
                .motions
                .iter()
                .zip(&end.motions)
                .map(|(a, b)| {
                    // About one point all the way: a turn stays a turn.
                    let a = a.expressed_about(b.about);
                    RigidMotion {
                        translation: mix3(a.translation, b.translation),
                        rotation: mix3(a.rotation, b.rotation),
                        about: b.about,
                    }
                })
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::geometry::vector3::{norm, sub};
    use crate::mesh::samples;
    use crate::scene::{
        Formulation, Material, MaterialModel, Modulus, Obstacle, Profile, Scene, Shape, Support,
    };

    fn plan() -> Plan {
        let scene = Scene {
            materials: vec![Material {
                group: "body".to_owned(),
                model: MaterialModel::LinearElastic {
                    modulus: Modulus::Shear(1.0),
                    poisson_ratio: 0.3,
                    formulation: Formulation::Auto,
                },
            }],
            supports: vec![Support {
                name: "wall".to_owned(),
                on: vec!["x0".to_owned()],
                normal: None,
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
                surface: crate::scene::SurfaceGeometry::default(),
                friction: 0.0,
                tresca: None,
            }],
            ..Scene::default()
        };
        Plan::new(&scene, &[], &samples::cube(1)).expect("a valid scene")
    }

    fn step() -> Step {
        Step {
            load: Some(-2.0),
            obstacles: vec![ObstacleTarget {
                name: "ball".to_owned(),
                translation: Some([1.0, 2.0, 3.0]),
                rotation: None,
                friction: None,
            }],
            supports: vec![SupportTarget {
                name: "wall".to_owned(),
                displacement: [None, None, Some(4.0)],
                ..SupportTarget::default()
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
        let target = Drive::first_target(&plan()).after(&plan(), &Step::default());
        assert_eq!(target.load.to_bits(), 1.0_f64.to_bits());
        assert_eq!(bits(target.supports[0]), bits([0.5, 0.0, 0.0]));
        assert_eq!(bits(target.poses[0].translation), bits([0.0; 3]));
    }

    #[test]
    fn a_step_changes_what_it_names() {
        let first = Drive::first_target(&plan());
        let end = first.after(&plan(), &step());
        assert_eq!(end.load.to_bits(), (-2.0_f64).to_bits());
        assert_eq!(bits(end.supports[0]), bits([0.5, 0.0, 4.0]));
        assert_eq!(bits(end.poses[0].translation), bits([1.0, 2.0, 3.0]));
        assert_eq!(bits(end.poses[0].rotation), bits([0.0; 3]));
        assert_eq!(end.after(&plan(), &Step::default()), end);
    }

    #[test]
    fn everything_ramps_linearly_and_ends_exactly() {
        let start = Drive::undeformed(&plan());
        let end = Drive::first_target(&plan()).after(&plan(), &step());
        let half = start.towards(&end, 0.5);
        assert!((half.load + 1.0).abs() < 1e-15);
        assert_eq!(bits(half.supports[0]), bits([0.25, 0.0, 2.0]));
        assert_eq!(bits(half.poses[0].translation), bits([0.5, 1.0, 1.5]));
        assert_eq!(start.towards(&end, 0.0), start);
        assert_eq!(start.towards(&end, 1.0), end);
    }

    /// A step that turns the wall about z through `turn`, then shifts it along x.
    fn turning(turn: f64, about: [f64; 3], shift: f64) -> Step {
        Step {
            obstacles: vec![ObstacleTarget {
                name: "ball".to_owned(),
                translation: None,
                rotation: Some([0.0, 0.0, turn]),
                friction: None,
            }],
            supports: vec![SupportTarget {
                name: "wall".to_owned(),
                translation: Some([shift, 0.0, 0.0]),
                rotation: Some([0.0, 0.0, turn]),
                about: Some(about),
                ..SupportTarget::default()
            }],
            ..Step::default()
        }
    }

    #[test]
    fn several_turns_of_supports_and_obstacles_survive_a_ramp() {
        let start = Drive::undeformed(&plan());
        let end = start.after(&plan(), &turning(3.0 * TAU, [1.0, 0.0, 0.0], 0.0));
        let part = start.towards(&end, 0.25);
        assert_eq!(bits(part.poses[0].rotation), bits([0.0, 0.0, 0.75 * TAU]));
        // Three quarters of a turn about (1, 0, 0) lead from the origin to (1, 1, 0).
        let moved = part.motions[0].apply([0.0; 3]);
        assert!(norm(sub(moved, [1.0, 1.0, 0.0])) < 1e-15, "{moved:?}");
        assert!(part.moves_supports() && !start.moves_supports());
    }

    #[test]
    fn a_motion_is_kept_until_a_step_names_another() {
        let first = Drive::first_target(&plan());
        let turned = first.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.5));
        let later = turned.after(&plan(), &step());
        assert_eq!(later.motions, turned.motions);
        assert_eq!(bits(later.supports[0]), bits([0.5, 0.0, 4.0]));
    }

    #[test]
    fn a_motion_about_another_point_starts_where_the_last_one_ended() {
        let start = Drive::undeformed(&plan());
        let turned = start.after(&plan(), &turning(0.5 * PI, [1.0, 0.0, 0.0], 0.3));
        let end = turned.after(&plan(), &turning(PI, [0.0, 2.0, 0.0], -0.2));
        let point = [0.4, 0.7, -0.2];
        let soon = turned.towards(&end, 1e-9).motions[0].apply(point);
        let before = turned.motions[0].apply(point);
        assert!(norm(sub(soon, before)) < 1e-8, "{soon:?} {before:?}");
        let late = turned.towards(&end, 1.0 - 1e-9).motions[0].apply(point);
        let after = end.motions[0].apply(point);
        assert!(norm(sub(late, after)) < 1e-8, "{late:?} {after:?}");
    }

    #[test]
    fn equal_increments_of_a_ramp_continue_each_other() {
        let start = Drive::undeformed(&plan());
        let end = start.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.3));
        let [a, b, c] = [0.1, 0.3, 0.8].map(|fraction| start.towards(&end, fraction));
        let further = c.continues(&a, &b).expect("the same direction");
        assert!((further - 2.5).abs() < 1e-12, "{further}");
        let back = a.continues(&b, &c).expect("the way back");
        assert!((back + 1.4).abs() < 1e-12, "{back}");
    }

    #[test]
    fn another_direction_and_rest_continue_nothing() {
        let start = Drive::undeformed(&plan());
        let turned = start.after(&plan(), &turning(PI, [1.0, 0.0, 0.0], 0.3));
        let loaded = Drive {
            load: 1.0,
            ..turned.clone()
        };
        let further = loaded.towards(
            &turned.after(&plan(), &turning(2.0 * PI, [1.0, 0.0, 0.0], 0.6)),
            0.5,
        );
        assert_eq!(loaded.continues(&start, &turned), None);
        assert_eq!(further.continues(&turned, &loaded), None);
        assert_eq!(turned.continues(&start, &start), None);
        assert_eq!(turned.continues(&start, &turned), None);
    }

    #[test]
    fn units_do_not_change_how_far_a_ramp_goes_on() {
        for unit in [1e-6, 1.0, 1e6] {
            let shifted = |by: f64| Drive {
                load: 0.5 * by,
                ..Drive::undeformed(&plan()).after(&plan(), &turning(by, [0.0; 3], unit * by))
            };
            let further = shifted(0.7).continues(&shifted(0.1), &shifted(0.3));
            assert!(further.is_some_and(|further| (further - 2.0).abs() < 1e-12));
        }
    }
}
