//! The problem as data: what a caller writes in a scene file or sends over the
//! wire, in the caller's own consistent units.
//!
//! Nothing here is checked; [`crate::plan::Plan::new`] validates a scene
//! against its mesh and names the offending key of every fault. Vectors have
//! three components in two dimensions too, the third being zero.

mod choices;
mod contact_pair;
mod error;
mod fluid;
mod goal;
mod material;
mod names;
pub(crate) mod numbers;
mod parameter;
mod questions;
mod solver;
mod step;
mod tie;
pub(crate) mod validate;
mod values;

pub use crate::obstacle::Shape;
pub use choices::{
    Choice, ContactMethod, ContactSpace, DisplacementMethod, ElementKind, ErrorEstimate,
    MetricKind, Named, OnInstability, P1Solver, ReportScope, ResponseMethod, SaddleMethod,
    StabilityCheck, UnknownName,
};
pub use contact_pair::ContactPair;
pub use error::{SceneError, Violation};
pub use fluid::{Film, Fluid, FluidLoad, FluidTarget, FluidThreshold};
pub use goal::{Goal, GoalKind, Malformed};
pub use material::{Formulation, Material, MaterialModel, Modulus, RubberModel};
pub use parameter::Parameter;
pub(crate) use questions::InStep;
pub use questions::{AskedAt, GoalErrors, GoalQuestions};
pub use solver::{SolverOptions, ToleranceRule};
pub use step::{ObstacleTarget, Step, SupportTarget, TractionTarget};
pub use tie::Tie;
pub use values::{ValuePlace, Values};

/// Geometry of the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    /// A body in space, meshed by tetrahedra.
    Solid,
    /// Triangles in the plane z = 0 that nothing holds across it, per unit thickness: a
    /// sheet, sigma_zz = 0.
    PlaneStress,
    /// Triangles in the plane z = 0, per unit thickness.
    PlaneStrain,
    /// Triangles in the half plane x >= 0, turned about the axis x = 0: x is the
    /// radius, y the height. Forces and volumes are of the full turn.
    Axisymmetric,
}

impl SceneKind {
    /// The name used in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::PlaneStrain => "plane-strain",
            Self::PlaneStress => "plane-stress",
            Self::Axisymmetric => "axisymmetric",
        }
    }
}

/// How the held values of a support vary over its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// The same value everywhere on the surface.
    #[default]
    Constant,
    /// The values at the middle of a flat surface perpendicular to an axis,
    /// falling to zero on the rim of its bounding box: times 4 s (1 − s) along
    /// every other axis, s from 0 to 1 across the box.
    Parabolic,
}

/// Held displacement components on surface groups.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Name of the support, unique among supports; steps and results refer to it.
    pub name: String,
    /// Names of the surface groups that are held.
    pub on: Vec<String>,
    /// Held components with their values, length; `None` is free.
    pub displacement: [Option<f64>; 3],
    /// In the place of components: the displacement along the outward normal of the
    /// undeformed surface, length; points slide in the plane of their face, which a
    /// rigid motion of the support carries along.
    pub normal: Option<f64>,
    /// How the values vary over the surface.
    pub profile: Profile,
    /// Displacement of each node, length, on top of `displacement`; components that are not
    /// held are not read.
    pub values: Option<Values>,
    /// Forces and springs on the surface as on a rigid part.
    pub load: SupportLoad,
}

impl Support {
    /// Held components: those that are given, and at rest those that follow from a force or a
    /// spring, whose motion is that of the support `[3]`.
    pub fn held(&self) -> [Option<f64>; 3] {
        let pushed = self.load.components();
        std::array::from_fn(|axis| self.displacement[axis].or(pushed[axis].map(|_| 0.0)))
    }
}

/// Forces on a support, whose surface moves as a rigid part: the pose of the components that are
/// named follows from them, until a step names a motion and no force. Such components are held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SupportLoad {
    /// Force that the support shall exert on the body at the end of the first step, with what its
    /// springs take `[3]`.
    pub force: [Option<f64>; 3],
    /// Moment about the reference point, likewise `[3]`. Needs rubber.
    pub moment: [Option<f64>; 3],
    /// Springs from the reference point to the ground, force per length `[3]`.
    pub stiffness: [Option<f64>; 3],
    /// Springs against rotation, moment per radian `[3]`. Need rubber.
    pub rotational_stiffness: [Option<f64>; 3],
    /// Reference point of moments and rotation in the undeformed body `[3]`; the origin without.
    pub about: Option<[f64; 3]>,
}

impl SupportLoad {
    /// Forces, then moments; zero where a spring is alone `[6]`.
    pub fn components(&self) -> [Option<f64>; 6] {
        let springs = self.springs();
        let named = [self.force, self.moment];
        let named = named.as_flattened();
        std::array::from_fn(|axis| named[axis].or(springs[axis].map(|_| 0.0)))
    }

    /// Springs along the axes, then about them `[6]`.
    pub fn springs(&self) -> [Option<f64>; 6] {
        let springs = [self.stiffness, self.rotational_stiffness];
        std::array::from_fn(|axis| springs.as_flattened()[axis])
    }

    /// Whether it moves anything.
    pub fn is_none(&self) -> bool {
        self.components().iter().all(Option::is_none)
    }
}

/// Dead load per undeformed area on surface groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traction {
    /// Name of the traction, unique among those that have one; steps refer to it.
    pub name: Option<String>,
    /// Names of the surface groups that are loaded.
    pub on: Vec<String>,
    /// Force per undeformed area `[3]`, stress.
    pub value: [f64; 3],
    /// Force per undeformed area of each node or facet, stress, on top of `value`.
    pub values: Option<Values>,
}

/// Follower pressure on surface groups: per deformed area, against the deformed
/// outward normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Names of the surface groups that are loaded.
    pub on: Vec<String>,
    /// Pressure per deformed area, stress; a positive one pushes on the body.
    pub value: f64,
}

/// A rigid body that the surface groups may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Name of the obstacle, unique among obstacles; steps and results refer to it.
    pub name: String,
    /// Names of the surface groups of the body that may touch it.
    pub on: Vec<String>,
    /// Geometry in its initial pose, in the caller's lengths.
    pub shape: Shape,
    /// Which surface of the body meets it.
    pub surface: SurfaceGeometry,
    /// Coefficient of Coulomb friction, at least zero.
    pub friction: f64,
    /// Largest traction of friction where there is pressure, in place of Coulomb's bound:
    /// force per undeformed area.
    pub tresca: Option<f64>,
    /// What follows where it begins inside the body.
    pub initial_penetration: PenetrationPolicy,
}

/// What follows where an obstacle begins inside the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PenetrationPolicy {
    /// The body is pushed out over the first increment, with a warning.
    #[default]
    Resolve,
    /// The scene is refused.
    Reject,
}

/// The surface of the body that meets an obstacle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceGeometry {
    /// Facets, and the edges of second order that the mesh has.
    #[default]
    AsMeshed,
    /// Arcs over the facets, fitted to their normals.
    Smooth,
}

/// A named point whose values each step reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Name of the probe, unique among probes.
    pub name: String,
    /// Position in the undeformed body `[3]`, length.
    pub point: [f64; 3],
}

/// A whole problem, without its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Name of the scene, for people.
    pub name: String,
    /// Factor on the mesh coordinates, above zero; none stands for one.
    pub mesh_scale: Option<f64>,
    /// `None`: solid for tetrahedra, plane strain for triangles.
    pub kind: Option<SceneKind>,
    /// One material for each group of cells.
    pub materials: Vec<Material>,
    /// Held displacement components of surface groups.
    pub supports: Vec<Support>,
    /// Dead loads per undeformed area of surface groups.
    pub tractions: Vec<Traction>,
    /// Follower pressures of surface groups; they need rubber.
    pub pressures: Vec<Pressure>,
    /// Fluids that creep in between the body and its obstacles.
    pub fluids: Vec<Fluid>,
    /// Force per undeformed volume `[3]`.
    pub body_force: [f64; 3],
    /// Force per undeformed volume of each node or cell, on top of `body_force`.
    pub body_force_values: Option<Values>,
    /// Rigid bodies that the body may touch.
    pub obstacles: Vec<Obstacle>,
    /// Surfaces of different bodies of the mesh that may touch each other.
    pub contacts: Vec<ContactPair>,
    /// Surfaces of different bodies of the mesh that are bonded.
    pub ties: Vec<Tie>,
    /// Name of an analytic field whose loads replace the others.
    pub manufactured: Option<String>,
    /// Points whose values each step reports.
    pub probes: Vec<Probe>,
    /// Functionals of increments that converge, with what is asked of them.
    pub questions: Vec<GoalQuestions>,
    /// Numerical settings; the default of every one is right for most scenes.
    pub solver: SolverOptions,
}
