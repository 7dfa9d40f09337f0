//! Load steps: where obstacles and supports shall be at their end.
//!
//! Values are from the initial pose, not from the last step: a step says where things are,
//! so that a step that was cut short can be followed by any other.

use super::{FluidTarget, Values};

/// Where one obstacle shall be at the end of a step; `None` keeps its pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstacleTarget {
    /// Name of the obstacle that moves.
    pub name: String,
    /// Translation from the initial pose `[3]`, length; components with a force are not read.
    pub translation: Option<[f64; 3]>,
    /// Rotation vector about the reference point `[3]`, radians; components with a moment are
    /// not read.
    pub rotation: Option<[f64; 3]>,
    /// Force that the obstacle shall exert on the body, component by component `[3]`: along
    /// those that are named it moves freely, until a step names a translation and no force.
    pub force: [Option<f64>; 3],
    /// Moment about the reference point that the obstacle shall exert on the body `[3]`: about
    /// those axes that are named it turns freely, until a step names a rotation and no moment.
    pub moment: [Option<f64>; 3],
    /// Coefficient of friction from the first increment of the step on.
    pub friction: Option<f64>,
}

impl ObstacleTarget {
    /// Whether the obstacle is pushed rather than led in some component.
    pub fn names_push(&self) -> bool {
        let mut components = self.force.iter().chain(&self.moment);
        components.any(Option::is_some)
    }
}

/// What one support shall prescribe at the end of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SupportTarget {
    /// Name of the support that moves.
    pub name: String,
    /// New values of held components; `None` keeps the value.
    pub displacement: [Option<f64>; 3],
    /// Rigid motion of the support, on top of the values: from the undeformed
    /// body `[3]`, length.
    pub translation: Option<[f64; 3]>,
    /// Rotation vector `[3]`, radians; several turns allowed. Needs rubber.
    pub rotation: Option<[f64; 3]>,
    /// Point of the undeformed body that the rotation leaves in place `[3]`; that of the scene
    /// at first.
    pub about: Option<[f64; 3]>,
    /// Force that the support shall exert on the body, with what its springs take, component by
    /// component `[3]`: its surface moves freely as a rigid part along those that are named, until
    /// a step names a motion along them and no force.
    pub force: [Option<f64>; 3],
    /// Moment about the reference point, likewise `[3]`. Needs rubber.
    pub moment: [Option<f64>; 3],
    /// New displacement of each node, length, on top of the others; `None` keeps them, zeros
    /// at first.
    pub values: Option<Values>,
}

/// New values of a traction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TractionTarget {
    /// Name of the traction.
    pub name: String,
    /// Force per undeformed area of each node or facet, stress, on top of its `value`.
    pub values: Values,
}

impl SupportTarget {
    /// Whether the support is pushed rather than led in some component.
    pub fn names_push(&self) -> bool {
        let mut components = self.force.iter().chain(&self.moment);
        components.any(Option::is_some)
    }

    /// Whether it names a rigid motion.
    pub fn names_motion(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.about.is_some()
    }
}

/// One load step: everything ramps linearly from the end of the previous step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Number of equal parts of the step, each reported; at least 1.
    pub increments: u32,
    /// Factor of all loads at the end; `None`: keeps its value (1 in the first step).
    pub load: Option<f64>,
    /// Where obstacles shall be at the end; those not named stay.
    pub obstacles: Vec<ObstacleTarget>,
    /// What supports shall prescribe at the end; those not named stay.
    pub supports: Vec<SupportTarget>,
    /// New values of tractions; those not named keep theirs, zeros at first.
    pub tractions: Vec<TractionTarget>,
    /// Where the pressures of fluids lead; those not named keep theirs.
    pub fluids: Vec<FluidTarget>,
    /// New values of the body force, on top of the constant one; `None` keeps them.
    pub body_force: Option<Values>,
}

impl Default for Step {
    fn default() -> Self {
        Self {
            increments: 1,
            load: None,
            obstacles: Vec::new(),
            supports: Vec::new(),
            tractions: Vec::new(),
            fluids: Vec::new(),
            body_force: None,
        }
    }
}
