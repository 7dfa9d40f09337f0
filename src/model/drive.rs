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

use super::fluid_drive::{self, FluidDrive};
use super::given::Given;
use super::push::{Applied, Control, Part, Push, filled, joined, named, towards};
use crate::geometry::rigid_motion::RigidMotion;
use crate::mesh::Mesh;
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

impl ObstaclePose {
    /// Takes over what a step names, but for the components that follow from `push`.
    fn lead(&mut self, target: &ObstacleTarget, push: &Push) {
        let own = [&mut self.translation, &mut self.rotation];
        lead(own, [target.translation, target.rotation], push);
    }
}

/// Sets translation and rotation to what is `named`, but for the components that follow from `push`.
fn lead(own: [&mut [f64; 3]; 2], named: [Option<[f64; 3]>; 2], push: &Push) {
    let axes = own.into_iter().zip(named).zip([0, 3]);
    for ((own, named), first) in axes {
        for (axis, value) in named.into_iter().flatten().enumerate() {
            if push.components[first + axis].is_none() {
                own[axis] = value;
            }
        }
    }
}

/// Translation and rotation in one `[6]`.
fn pose_of(motion: &RigidMotion) -> [f64; 6] {
    joined(motion.translation, motion.rotation)
}

/// Everything that ramps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    /// Factor of all loads: tractions, body force and pressures.
    pub(crate) load: f64,
    /// Pose of each obstacle, in the order of the plan.
    pub(crate) poses: Vec<ObstaclePose>,
    /// What each obstacle shall exert, in the order of the plan; empty where all are led.
    pub(crate) pushes: Vec<Push>,
    /// What each support shall exert, and its spring with it, likewise.
    pub(crate) support_pushes: Vec<Push>,
    /// Coefficient of friction of each obstacle, in the order of the plan; constant through
    /// a step. Empty where no obstacle is frictional.
    pub(crate) friction: Vec<f64>,
    /// Prescribed components of each support; a normal component stands first.
    pub(crate) supports: Vec<[f64; 3]>,
    /// Rigid motion of each support, added to its components.
    pub(crate) motions: Vec<RigidMotion>,
    /// Values of other codes.
    pub(crate) given: Given,
    /// Pressure of each fluid, in the order of the plan; empty where there is none.
    pub(crate) fluids: Vec<FluidDrive>,
}

impl Drive {
    /// Whether loads and supports are the same, wherever obstacles are.
    pub(crate) fn is_loaded_like(&self, other: &Self) -> bool {
        self.load.to_bits() == other.load.to_bits()
            && self.supports == other.supports
            && self.motions == other.motions
            && self.given == other.given
            && self.fluids == other.fluids
    }

    /// Whether the pressure of a fluid rises from that of `start` to its blow-off.
    pub(crate) fn seeks_blow_off(&self, start: &Self) -> bool {
        let mut ends = self.fluids.iter().zip(&start.fluids);
        ends.any(|(end, start)| end.to_blow_off && end.pressure > start.pressure)
    }

    /// The undeformed state.
    pub(crate) fn undeformed(plan: &Plan) -> Self {
        let supports = plan.problem.resolved.supports.len();
        Self {
            load: 0.0,
            poses: plan
                .problem
                .obstacles
                .iter()
                .map(|obstacle| ObstaclePose {
                    name: obstacle.name.clone(),
                    ..ObstaclePose::default()
                })
                .collect(),
            pushes: Vec::new(),
            support_pushes: Vec::new(),
            friction: if plan.has_friction() {
                plan.problem
                    .obstacles
                    .iter()
                    .map(|one| one.friction)
                    .collect()
            } else {
                Vec::new()
            },
            supports: vec![[0.0; 3]; supports],
            motions: vec![RigidMotion::default(); supports],
            given: Given::default(),
            fluids: vec![FluidDrive::default(); plan.problem.resolved.fluids.len()],
        }
    }

    /// Where the first step leads when it names nothing.
    pub(crate) fn first_target(plan: &Plan) -> Self {
        let supports = plan.problem.resolved.supports.iter();
        let pushes = supports.clone().map(|support| Push {
            components: support.push,
        });
        let about = supports.map(|support| RigidMotion {
            about: support.about,
            ..RigidMotion::default()
        });
        let first = Self {
            support_pushes: named(pushes.collect()),
            motions: about.collect(),
            ..Self::undeformed(plan)
        };
        Self {
            load: 1.0,
            supports: plan
                .problem
                .resolved
                .supports
                .iter()
                .map(|support| match support.normal {
                    Some(value) => [value, 0.0, 0.0],
                    None => support.displacement.map(|value| value.unwrap_or(0.0)),
                })
                .collect(),
            given: Given::of_scene(plan),
            fluids: fluid_drive::of_scene(plan),
            ..first
        }
    }

    /// The end of a step that starts from this target.
    pub(crate) fn after(&self, plan: &Plan, step: &Step) -> Self {
        let mut end = self.clone();
        end.load = step.load.unwrap_or(end.load);
        step.obstacles.iter().for_each(|one| end.place(one));
        step.supports.iter().for_each(|one| end.hold(plan, one));
        end.fluids = fluid_drive::after(&self.fluids, plan, step);
        end
    }

    /// The same drive with the values that a step names.
    pub(crate) fn given_by(self, (plan, mesh): (&Plan, &Mesh), step: &Step) -> Self {
        Self {
            given: self.given.after((plan, mesh), step),
            ..self
        }
    }

    /// Sets the pose and the friction that a step names; what the step leaves out keeps
    /// its value.
    fn place(&mut self, target: &ObstacleTarget) {
        let mut poses = self.poses.iter_mut().enumerate();
        if let Some((index, pose)) = poses.find(|(_, pose)| pose.name == target.name) {
            if let (Some(own), Some(new)) = (self.friction.get_mut(index), target.friction) {
                *own = new;
            }
            let push = self.pushes.get(index).copied().unwrap_or_default();
            let push = push.after(target);
            pose.lead(target, &push);
            self.push(index, push);
        }
    }

    /// Notes what an obstacle shall exert; where none shall exert anything no push is left.
    fn push(&mut self, index: usize, push: Push) {
        self.pushes.resize(self.poses.len(), Push::default());
        self.pushes[index] = push;
        self.pushes = named(std::mem::take(&mut self.pushes));
    }

    /// Whether any pose follows from a push.
    pub(crate) fn is_pushed(&self) -> bool {
        !self.pushes.is_empty() || !self.support_pushes.is_empty()
    }

    /// The components of poses that follow from pushes, in the order of the obstacles, then of
    /// the supports.
    pub(crate) fn controls(&self) -> Vec<Control> {
        let obstacles = self.pushes.iter().enumerate();
        let obstacles = obstacles.map(|(index, push)| (Part::Obstacle(index), push));
        let supports = self.support_pushes.iter().enumerate();
        let supports = supports.map(|(index, push)| (Part::Support(index), push));
        let controls = obstacles.chain(supports).flat_map(|(part, push)| {
            let axes = (0..6).filter(|&axis| push.components[axis].is_some());
            axes.map(move |axis| Control { part, axis })
        });
        controls.collect()
    }

    /// This drive with the poses of `other` where they follow from pushes.
    pub(crate) fn carried_by(&self, other: &Self) -> Self {
        let mut carried = self.clone();
        for control in self.controls() {
            let pose = match control.part {
                Part::Obstacle(_) => other.pose(control.part),
                // About the own reference point, which a step may have changed.
                Part::Support(index) => {
                    let about = carried.motions[index].about;
                    pose_of(&other.motions[index].expressed_about(about))
                }
            };
            *carried.component(control) = pose[control.axis];
        }
        carried
    }

    /// The same drive with the motions of supports about the reference points of `other`.
    pub(crate) fn about_like(&self, other: &Self) -> Self {
        let mut like = self.clone();
        for (motion, other) in like.motions.iter_mut().zip(&other.motions) {
            if motion.about.map(f64::to_bits) != other.about.map(f64::to_bits) {
                *motion = motion.expressed_about(other.about);
            }
        }
        like
    }

    /// Translation and rotation of a part `[6]`.
    pub(crate) fn pose(&self, part: Part) -> [f64; 6] {
        match part {
            Part::Obstacle(index) => {
                let pose = &self.poses[index];
                joined(pose.translation, pose.rotation)
            }
            Part::Support(index) => pose_of(&self.motions[index]),
        }
    }

    /// One component of a pose.
    pub(crate) fn component(&mut self, control: Control) -> &mut f64 {
        let [translation, rotation] = match control.part {
            Part::Obstacle(index) => {
                let pose = &mut self.poses[index];
                [&mut pose.translation, &mut pose.rotation]
            }
            Part::Support(index) => {
                let motion = &mut self.motions[index];
                [&mut motion.translation, &mut motion.rotation]
            }
        };
        match control.axis {
            axis @ 0..3 => &mut translation[axis],
            axis => &mut rotation[axis - 3],
        }
    }

    /// What a part shall exert along a component; zero where it is led.
    pub(crate) fn goal(&self, control: Control) -> f64 {
        let push = match control.part {
            Part::Obstacle(index) => self.pushes.get(index),
            Part::Support(index) => self.support_pushes.get(index),
        };
        let component = push.and_then(|push| push.components[control.axis]);
        component.unwrap_or_default()
    }

    /// Sets displacement and motion of the support that a step names; what the step
    /// leaves out keeps its value.
    fn hold(&mut self, plan: &Plan, target: &SupportTarget) {
        let resolved = &plan.problem.resolved.supports;
        let Some(index) = resolved.iter().position(|one| one.name == target.name) else {
            return;
        };
        let before = self.support_pushes.get(index).copied().unwrap_or_default();
        let push = before.after_support(target, &resolved[index].spring);
        for (value, new) in self.supports[index].iter_mut().zip(target.displacement) {
            *value = new.unwrap_or(*value);
        }
        let motion = &mut self.motions[index];
        if let (Some(about), false) = (target.about, push.is_none()) {
            *motion = motion.expressed_about(about);
        }
        // Where a displacement ends a push it says where the face shall be.
        for axis in (0..3).filter(|&axis| target.displacement[axis].is_some()) {
            if before.components[axis].is_some() && push.components[axis].is_none() {
                motion.translation[axis] = 0.0;
            }
        }
        let own = [&mut motion.translation, &mut motion.rotation];
        lead(own, [target.translation, target.rotation], &push);
        motion.about = target.about.unwrap_or(motion.about);
        self.support_pushes.resize(resolved.len(), Push::default());
        self.support_pushes[index] = push;
        self.support_pushes = named(std::mem::take(&mut self.support_pushes));
    }

    /// Whether any support prescribes more than zeros.
    pub(crate) fn moves_supports(&self) -> bool {
        let values = self.supports.as_flattened();
        values.iter().any(|&value| value != 0.0)
            || self.motions.iter().any(|motion| !motion.is_rest())
            || !self.given.is_at_rest()
    }

    /// Whether the body of `plan` has a load under this drive, but for its factor.
    pub(crate) fn has_loads(&self, plan: &Plan) -> bool {
        plan.problem.resolved.is_loaded() || !self.given.is_unloaded()
    }

    /// Whether any load acts on the body of `plan`: those with a factor, or the pressure of a fluid.
    pub(crate) fn is_loaded(&self, plan: &Plan) -> bool {
        (self.has_loads(plan) && self.load != 0.0) || self.has_fluid_pressure()
    }

    /// Whether any fluid has a pressure.
    pub(crate) fn has_fluid_pressure(&self) -> bool {
        self.fluids.iter().any(|fluid| fluid.pressure != 0.0)
    }

    /// r where the way from `to` to this drive is r times that from `from` to `to`,
    /// to round-off; none where it is another way, or one of them has no length.
    pub(crate) fn continues(&self, from: &Self, to: &Self) -> Option<f64> {
        let controls = self.controls();
        if from.controls() != controls || to.controls() != controls {
            return None;
        }
        let shape = self.given.shape();
        if from.given.shape() != shape || to.given.shape() != shape {
            return None;
        }
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

    /// All numbers that are given, motions expressed about the reference points of `other`:
    /// of a pose that follows from a push, the push.
    fn values(&self, other: &Self) -> Vec<f64> {
        let mut given = self.clone();
        for control in self.controls() {
            *given.component(control) = self.goal(control);
        }
        let poses = given.poses.iter();
        let poses = poses.flat_map(|pose| [pose.translation, pose.rotation]);
        let motions = given.motions.iter().zip(&other.motions);
        let motions = motions.flat_map(|(motion, other)| {
            let motion = motion.expressed_about(other.about);
            [motion.translation, motion.rotation]
        });
        let vectors = poses.chain(self.supports.iter().copied()).chain(motions);
        std::iter::once(self.load)
            .chain(vectors.flatten())
            .chain(self.given.numbers())
            .chain(self.fluids.iter().map(|fluid| fluid.pressure))
            .collect()
    }

    /// This drive with no load factor where the body of `plan` has no load.
    pub(crate) fn felt_by(&self, plan: &Plan) -> Self {
        let mut felt = self.clone();
        felt.load = if self.has_loads(plan) { self.load } else { 0.0 };
        felt
    }

    /// A fraction of the way to `end`; exactly `end` at one.
    pub(crate) fn towards(&self, end: &Self, fraction: f64) -> Self {
        if fraction >= 1.0 {
            return end.clone();
        }
        let mix = |a: f64, b: f64| a + fraction * (b - a);
        let mix3 = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| mix(a[i], b[i]));
        let factors = [self.load, end.load];
        Self {
            given: self.given.towards(&end.given, fraction, factors),
            fluids: fluid_drive::towards(&self.fluids, &end.fluids, fraction),
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
            pushes: towards(&self.pushes, &end.pushes, fraction),
            support_pushes: towards(&self.support_pushes, &end.support_pushes, fraction),
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

    /// This drive with a push to start from wherever `end` has one: that of its own, else what
    /// `applied` says.
    pub(crate) fn pushing_like(&self, end: &Self, applied: &Applied) -> Self {
        Self {
            pushes: filled(&self.pushes, &end.pushes, &applied.obstacles),
            support_pushes: filled(&self.support_pushes, &end.support_pushes, &applied.supports),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests;
