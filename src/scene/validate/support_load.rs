//! Forces, moments and springs of supports: the surface of such a support moves as a rigid part.
//!
//! Along z about an axis there is one pose, in the plane three, in space six.

use super::Faults;
use crate::mesh::Mesh;
use crate::scene::{MaterialModel, Profile, Scene, SceneKind, Support, SupportLoad, SupportTarget};

const AXES: [&str; 3] = ["x", "y", "z"];

/// What poses of obstacles and supports are checked against.
#[derive(Clone, Copy)]
pub(crate) struct Poses<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) mesh: &'a Mesh,
}

impl Poses<'_> {
    /// Components of a displacement.
    fn dimension(self) -> usize {
        self.mesh.cell_kind().dimension()
    }

    /// Checks what is named along the axes, `key` of `path`, and about them, `turned`: a flat body
    /// is pushed in its plane, one of revolution along its axis.
    pub(crate) fn check(
        self,
        path: &str,
        keys: [&str; 2],
        components: [[Option<f64>; 3]; 2],
        faults: &mut Faults,
    ) {
        let is_flat = self.dimension() == 2;
        let is_turned = is_flat && self.scene.kind == Some(SceneKind::Axisymmetric);
        for (half, (key, components)) in keys.into_iter().zip(components).enumerate() {
            let named = components.into_iter().enumerate();
            for (axis, value) in named.filter_map(|(axis, value)| Some((axis, value?))) {
                let path = format!("{path}.{key}.{}", AXES[axis]);
                faults.finite(&path, &[value]);
                if is_turned && (half, axis) != (0, 1) {
                    faults.add(path, "an axisymmetric body is pushed along y only");
                } else if is_flat && (half == 0) != (axis < 2) {
                    let message = "a plane body is pushed along x and y and turned about z";
                    faults.add(path, message);
                }
            }
        }
    }

    /// Checks the load of a support of the scene, whose key is `path`.
    pub(crate) fn check_load(self, support: &Support, path: &str, faults: &mut Faults) {
        let SupportLoad {
            force,
            moment,
            stiffness,
            rotational_stiffness,
            about,
        } = support.load;
        if let Some(about) = about {
            faults.finite(&format!("{path}.about"), &about);
        }
        if support.load.is_none() {
            return;
        }
        self.check(path, ["force", "moment"], [force, moment], faults);
        let keys = ["stiffness", "rotational_stiffness"];
        let springs = [stiffness, rotational_stiffness];
        self.check(path, keys, springs, faults);
        for (key, components) in keys.into_iter().zip(springs) {
            for (axis, value) in components.into_iter().enumerate() {
                if let Some(value) = value {
                    faults.above_zero(&format!("{path}.{key}.{}", AXES[axis]), value);
                }
            }
        }
        for axis in 0..3 {
            let is_pushed = force[axis].is_some() || stiffness[axis].is_some();
            if is_pushed && support.displacement[axis].is_some() {
                let key = format!("{path}.displacement.{}", AXES[axis]);
                faults.add(key, "its force or spring says where it goes: leave it out");
            }
        }
        self.rigid(support, support.load.components(), path, faults);
    }

    /// Checks the forces that a step gives to a support.
    pub(crate) fn check_target(
        self,
        support: &Support,
        target: &SupportTarget,
        path: &str,
        faults: &mut Faults,
    ) {
        let components = [target.force, target.moment];
        if target.names_push() {
            self.check(path, ["force", "moment"], components, faults);
            let components = std::array::from_fn(|axis| components.as_flattened()[axis]);
            self.rigid(support, components, path, faults);
        }
        let springs = support.load.springs();
        for axis in (0..3).filter(|&axis| springs[axis].is_some()) {
            if target.displacement[axis].is_some() {
                let key = format!("{path}.displacement.{}", AXES[axis]);
                faults.add(key, "a spring says where it goes: give a force");
            }
        }
        let led = target.translation.into_iter().flatten().enumerate();
        let turned = target.rotation.into_iter().flatten().enumerate();
        let led = led.chain(turned.map(|(axis, angle)| (axis + 3, angle)));
        let is_sprung = |(axis, value): &(usize, f64)| *value != 0.0 && springs[*axis].is_some();
        if led.filter(is_sprung).count() > 0 {
            faults.add(
                path,
                "a spring says where it goes: give a force in the place of a motion",
            );
        }
    }

    /// A support that is pushed along `components` `[6]` moves as a rigid part.
    fn rigid(
        self,
        support: &Support,
        components: [Option<f64>; 6],
        path: &str,
        faults: &mut Faults,
    ) {
        if support.normal.is_some() {
            faults.add(
                path,
                "is held along its normal: give displacement to push it",
            );
        }
        if support.profile != Profile::Constant || support.values.is_some() {
            faults.add(
                path,
                "has a profile or values, which no rigid part has: leave them out",
            );
        }
        if self.scene.manufactured.is_some() {
            faults.add(path, "the manufactured field prescribes the values");
        }
        let held = support.held();
        let dimension = self.dimension();
        let mut axes = (0..dimension).filter(|&axis| held[axis].is_none());
        let is_turned = components[3..].iter().any(Option::is_some);
        if let (true, Some(axis)) = (is_turned, axes.next()) {
            let message = format!(
                "a moment needs all components held, but {} is free",
                AXES[axis]
            );
            faults.add(path, message);
        }
        for (axis, held) in held.iter().enumerate() {
            if components[axis].is_some() && held.is_none() {
                let message = format!("the support does not hold the {} component", AXES[axis]);
                faults.add(format!("{path}.force.{}", AXES[axis]), message);
            }
        }
        let is_rubber = self.scene.materials.iter().any(|one| one.model.is_rubber());
        if is_turned && !is_rubber {
            faults.unsupported(path, "a moment on a support of a body that is not rubber");
        }
        if self
            .scene
            .materials
            .iter()
            .any(|one| matches!(one.model, MaterialModel::Stokes { .. }))
        {
            faults.unsupported(path, "a force on a support of a flow");
        }
    }
}
