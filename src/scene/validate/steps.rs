//! Load steps and obstacle updates.

use super::support_load::Poses;
use super::{Faults, fluids, in_plane, values};
use crate::mesh::Mesh;
use crate::scene::names::hint;
use crate::scene::{
    ObstacleTarget, Profile, Scene, SceneError, SceneKind, Step, Support, SupportTarget,
};

/// Most increments in one step.
const MOST_INCREMENTS: u32 = 100_000;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Checks one step on its own.
pub(crate) fn check_step(scene: &Scene, step: &Step, mesh: &Mesh) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    Steps { scene, mesh }.check(step, "step", &mut faults);
    faults.result()
}

/// What steps are checked against.
#[derive(Clone, Copy)]
pub(crate) struct Steps<'a> {
    /// The scene that they load.
    pub(crate) scene: &'a Scene,
    /// Its mesh.
    pub(crate) mesh: &'a Mesh,
}

impl Steps<'_> {
    /// Adds the faults of all steps of a scene.
    pub(super) fn check_all(&self, steps: &[Step], faults: &mut Faults) {
        for (index, step) in steps.iter().enumerate() {
            self.check(step, &format!("step[{index}]"), faults);
        }
    }

    /// Adds the faults of one step, whose key is `path`.
    pub(crate) fn check(&self, step: &Step, path: &str, faults: &mut Faults) {
        if !(1..=MOST_INCREMENTS).contains(&step.increments) {
            let message = format!(
                "must lie between 1 and {MOST_INCREMENTS}, not {}",
                step.increments
            );
            faults.add(format!("{path}.increments"), message);
        }
        if let Some(load) = step.load {
            faults.finite(&format!("{path}.load"), &[load]);
        }
        values::check_step((self.scene, step), self.mesh, path, faults);
        fluids::check_step(self.scene, step, path, faults);
        for target in &step.obstacles {
            if faults.is_full() {
                return;
            }
            let path = format!("{path}.obstacle.{}", target.name);
            self.obstacle(target, &path, faults);
        }
        for target in &step.supports {
            if faults.is_full() {
                return;
            }
            let path = format!("{path}.support.{}", target.name);
            self.support(target, &path, faults);
        }
    }

    fn poses(&self) -> Poses<'_> {
        Poses {
            scene: self.scene,
            mesh: self.mesh,
        }
    }

    fn obstacle(&self, target: &ObstacleTarget, path: &str, faults: &mut Faults) {
        let known = self.scene.obstacles.iter().map(|one| one.name.as_str());
        if !known.clone().any(|name| name == target.name) {
            let hint = hint(&target.name, known);
            let message = format!("the scene has no obstacle `{}`{hint}", target.name);
            faults.add(path, message);
        }
        self.friction(target, path, faults);
        if let Some(translation) = target.translation {
            let path = format!("{path}.translation");
            faults.finite(&path, &translation);
            in_plane(faults, self.mesh, &path, translation);
        }
        if let Some(rotation) = target.rotation {
            in_plane_rotation(faults, self.mesh, &format!("{path}.rotation"), rotation);
        }
        let poses = self.poses();
        let components = [target.force, target.moment];
        poses.check(path, ["force", "moment"], components, faults);
    }

    /// The friction that a step names.
    fn friction(&self, target: &ObstacleTarget, path: &str, faults: &mut Faults) {
        let Some(friction) = target.friction else {
            return;
        };
        let path = format!("{path}.friction");
        faults.not_negative(&path, friction);
        let mut obstacles = self.scene.obstacles.iter();
        let Some(obstacle) = obstacles.find(|one| one.name == target.name) else {
            return;
        };
        if obstacle.tresca.is_some() {
            faults.add(path, "the obstacle has a tresca bound in place of friction");
        }
    }

    fn support(&self, target: &SupportTarget, path: &str, faults: &mut Faults) {
        let Some(support) = self.scene.supports.iter().find(|s| s.name == target.name) else {
            let known = self
                .scene
                .supports
                .iter()
                .map(|support| support.name.as_str());
            let hint = hint(&target.name, known);
            let message = format!("the scene has no support `{}`{hint}", target.name);
            return faults.add(path, message);
        };
        let held = support.held();
        for (axis, (value, held)) in target.displacement.iter().zip(held).enumerate() {
            let key = format!("{path}.displacement.{}", AXES[axis]);
            match (value, held) {
                (Some(value), Some(_)) => {
                    faults.finite(&key, &[*value]);
                }
                (Some(_), None) => faults.add(key, "the support does not hold this component"),
                (None, _) => (),
            }
        }
        if target.names_motion() {
            self.motion(support, target, path, faults);
        }
        self.poses().check_target(support, target, path, faults);
    }

    /// The rigid motion of a support.
    fn motion(&self, support: &Support, target: &SupportTarget, path: &str, faults: &mut Faults) {
        if target.displacement.iter().any(Option::is_some) {
            let message = "give either displacement, or translation and rotation, not both";
            faults.add(path, message);
        }
        if support.profile != Profile::Constant {
            faults.add(path, "the support has a profile, which no rigid motion has");
        }
        if self.scene.manufactured.is_some() {
            faults.add(path, "the manufactured field prescribes the values");
        }
        if let Some(translation) = target.translation {
            let path = format!("{path}.translation");
            faults.finite(&path, &translation);
            in_plane(faults, self.mesh, &path, translation);
            let holds = |axis: usize| support.held()[axis].is_some() || support.normal.is_some();
            for axis in (0..3).filter(|&axis| translation[axis] != 0.0) {
                if !holds(axis) {
                    let message = format!("the support does not hold the {} component", AXES[axis]);
                    faults.add(&path, message);
                }
            }
        }
        if let Some(rotation) = target.rotation {
            let path = format!("{path}.rotation");
            in_plane_rotation(faults, self.mesh, &path, rotation);
            if self.scene.kind == Some(SceneKind::Axisymmetric) {
                faults.add(&path, "an axisymmetric body does not turn in its plane");
            } else if rotation.iter().any(|&x| x != 0.0)
                && !self.scene.materials.iter().any(|one| one.model.is_rubber())
            {
                faults.unsupported(&path, "a large rotation of a body that is not rubber");
            }
        }
        if let Some(about) = target.about {
            faults.finite(&format!("{path}.about"), &about);
        }
    }
}

fn in_plane_rotation(faults: &mut Faults, mesh: &Mesh, path: &str, rotation: [f64; 3]) {
    faults.finite(path, &rotation);
    let about_z = rotation[0] == 0.0 && rotation[1] == 0.0;
    if mesh.cell_kind().dimension() == 2 && !about_z {
        faults.add(path, "must be about z in a plane scene");
    }
}
