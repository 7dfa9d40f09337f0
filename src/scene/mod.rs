//! The problem as data: what a caller writes in a scene file or sends over the
//! wire, in the caller's own consistent units.
//!
//! Nothing here is checked; [`crate::plan::Plan::new`] validates a scene
//! against its mesh and names the offending key of every fault. Vectors have
//! three components in two dimensions too, the third being zero.

mod error;
mod material;
pub(crate) mod validate;

pub use error::{SceneError, Violation};
pub use material::{Formulation, Material, MaterialModel, Modulus, RubberModel};

/// Geometry of the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    /// Tetrahedra.
    Solid,
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
            Self::Axisymmetric => "axisymmetric",
        }
    }
}

/// How the held values of a support vary over its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// The same everywhere.
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
    /// Unique among supports.
    pub name: String,
    /// Surface groups.
    pub on: Vec<String>,
    /// Held components with their values, length; `None` is free.
    pub displacement: [Option<f64>; 3],
    /// Variation of the values over the surface.
    pub profile: Profile,
}

/// Dead load per undeformed area on surface groups.
#[derive(Clone, Debug, PartialEq)]
pub struct Traction {
    /// Surface groups.
    pub on: Vec<String>,
    /// Stress `[3]`.
    pub value: [f64; 3],
}

/// Follower pressure on surface groups: per deformed area, against the deformed
/// outward normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Surface groups.
    pub on: Vec<String>,
    /// Stress; positive pushes on the body.
    pub value: f64,
}

/// Shape of a rigid obstacle in its initial pose.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points behind a plane.
    HalfSpace {
        /// A point of the plane, and the reference point.
        point: [f64; 3],
        /// Towards the free side; any length above zero.
        normal: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Centre, and the reference point.
        centre: [f64; 3],
        /// Above zero.
        radius: f64,
    },
    /// An infinite circular cylinder.
    Cylinder {
        /// A point of the axis, and the reference point.
        point: [f64; 3],
        /// Any length above zero.
        axis: [f64; 3],
        /// Above zero.
        radius: f64,
    },
}

/// A rigid body that the surface groups may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Unique among obstacles.
    pub name: String,
    /// Surface groups of the body that may touch it.
    pub on: Vec<String>,
    /// Geometry.
    pub shape: Shape,
}

/// A named point whose values each step reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Unique among probes.
    pub name: String,
    /// In the undeformed body `[3]`.
    pub point: [f64; 3],
}

/// How far the residuals are reduced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToleranceRule {
    /// To [`SolverOptions::tolerance`].
    #[default]
    Fixed,
    /// Until the algebraic error is a tenth of the estimated discretisation
    /// error, but not below [`SolverOptions::tolerance`].
    Discretisation,
}

/// Numerical settings; every one has a default.
#[derive(Clone, Debug, PartialEq)]
pub struct SolverOptions {
    /// Bound on all four residuals.
    pub tolerance: f64,
    /// Whether that bound is reached in every case.
    pub tolerance_rule: ToleranceRule,
    /// `auto`: each converged increment reports one; `off`.
    pub error_estimate: String,
    /// Degree of the volume rule: for loads and norms, and for the stress of
    /// rubber (2 to 12 there); `None` chooses.
    pub quadrature_degree: Option<u32>,
    /// Seconds after which a step ends with its last good state.
    pub max_wall_time: Option<f64>,
    /// `auto`, `taylor-hood`; `mini` and `bernardi-raugel` to compare.
    pub element: String,
    /// `auto`, `p-multigrid`, `hierarchical-ssor`, `hierarchical-multiplicative`,
    /// `hierarchical-additive`.
    pub displacement_preconditioner: String,
    /// `auto`, `cholesky`, `amg`, `ic-cg` (without contact).
    pub p1_solver: String,
    /// `auto`, `gcr`; mixed: `arrow-hurwicz`, `uzawa-cg`, `minres`; displacement
    /// form: `cg`, `stationary`. With contact: `gcr`, `arrow-hurwicz` (mixed).
    pub saddle: String,
    /// `auto`, `one-level`, `active-set`, `nested`, `mprgp`,
    /// `conjugate-projected-gradient`, `projected-arrow-hurwicz`.
    pub contact: String,
    /// `auto`, `compliance`, `mass`, `fractional`.
    pub contact_metric: String,
    /// Weight of a grad-div term in the displacement block, in units of the shear
    /// modulus; for incompressible materials. `None`: none. Of rubber: of the volume
    /// change that the pressure does not see; `None`: where an equilibrium is lost.
    pub penalty: Option<f64>,
    /// Recompute the residuals by the independent path after each increment.
    pub verify: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        let auto = || "auto".to_owned();
        Self {
            tolerance: 1e-8,
            tolerance_rule: ToleranceRule::Fixed,
            error_estimate: auto(),
            quadrature_degree: None,
            max_wall_time: None,
            element: auto(),
            displacement_preconditioner: auto(),
            p1_solver: auto(),
            saddle: auto(),
            contact: auto(),
            contact_metric: auto(),
            penalty: None,
            verify: false,
        }
    }
}

/// A whole problem, without its mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// For people.
    pub name: String,
    /// Multiplies the mesh coordinates; above zero.
    pub mesh_scale: Option<f64>,
    /// `None`: solid for tetrahedra, plane strain for triangles.
    pub kind: Option<SceneKind>,
    /// One per cell group.
    pub materials: Vec<Material>,
    /// Held components.
    pub supports: Vec<Support>,
    /// Dead loads.
    pub tractions: Vec<Traction>,
    /// Follower loads; need rubber.
    pub pressures: Vec<Pressure>,
    /// Force per undeformed volume `[3]`.
    pub body_force: [f64; 3],
    /// Rigid bodies.
    pub obstacles: Vec<Obstacle>,
    /// Name of an analytic field whose loads replace the others.
    pub manufactured: Option<String>,
    /// Points to report.
    pub probes: Vec<Probe>,
    /// Numerical settings.
    pub solver: SolverOptions,
}

/// Where one obstacle shall be at the end of a step; `None` keeps its pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstacleTarget {
    /// Obstacle name.
    pub name: String,
    /// From the initial pose `[3]`, length.
    pub translation: Option<[f64; 3]>,
    /// Rotation vector about the reference point `[3]`, radians.
    pub rotation: Option<[f64; 3]>,
}

/// What one support shall prescribe at the end of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SupportTarget {
    /// Support name.
    pub name: String,
    /// New values of held components; `None` keeps the value.
    pub displacement: [Option<f64>; 3],
    /// Rigid motion of the support, on top of the values: from the undeformed
    /// body `[3]`, length.
    pub translation: Option<[f64; 3]>,
    /// Rotation vector `[3]`, radians; several turns allowed. Needs rubber.
    pub rotation: Option<[f64; 3]>,
    /// Point of the undeformed body that the rotation leaves in place `[3]`; the
    /// origin at first.
    pub about: Option<[f64; 3]>,
}

impl SupportTarget {
    /// Whether it names a rigid motion.
    pub fn names_motion(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.about.is_some()
    }
}

/// One load step: everything ramps linearly from the end of the previous step.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Equal parts, each reported; at least 1.
    pub increments: u32,
    /// Factor of all loads at the end; `None`: keeps its value (1 in the first step).
    pub load: Option<f64>,
    /// Obstacle motion.
    pub obstacles: Vec<ObstacleTarget>,
    /// Support motion.
    pub supports: Vec<SupportTarget>,
}

impl Default for Step {
    fn default() -> Self {
        Self {
            increments: 1,
            load: None,
            obstacles: Vec::new(),
            supports: Vec::new(),
        }
    }
}
