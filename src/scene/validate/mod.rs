//! Checks a scene against its mesh and resolves names to cells and facets.
//!
//! All faults are collected, each with the path of its key; combinations that
//! this version cannot solve are [`SceneError::Unsupported`].

mod bodies;
mod extent;
mod fluids;
mod foams;
mod goals;
mod materials;
mod names;
mod obstacles;
mod pairs;
mod parabola;
mod planes;
mod profiles;
mod resolved;
mod rigid_modes;
mod rubber;
mod solver;
mod spread;
mod steps;
mod support_load;
mod surfaces;
mod ties;
mod values;

use super::{Obstacle, RubberModel, Scene, SceneError, SceneKind, Step, Violation};
use crate::material::Isochoric;
use crate::mesh::{CellKind, Mesh};

pub(crate) use obstacles::build;
pub(crate) use parabola::Parabola;
pub(crate) use planes::rotates;
pub(crate) use resolved::{
    HeldPlane, ObliquePlane, Placed, Resolved, ResolvedFluid, ResolvedMaterial, ResolvedObstacle,
    ResolvedPair, ResolvedPressure, ResolvedProbe, ResolvedSupport, ResolvedTraction,
};
pub(crate) use rigid_modes::{joined_parts, parts};
pub(crate) use spread::{Spread, Table};
pub(crate) use steps::check_step;
pub(crate) use values::{Ground, resolve as resolve_values};

/// Most faults that are told of one scene or step: more help nobody, and the
/// text of each can be long.
const MOST_FAULTS: usize = 100;

/// Collects faults, at most [`MOST_FAULTS`].
#[derive(Debug, Default)]
pub(crate) struct Faults {
    violations: Vec<Violation>,
    unsupported: Option<Violation>,
}

impl Faults {
    pub(crate) fn add(&mut self, path: impl Into<String>, message: impl Into<String>) {
        if self.is_full() {
            return;
        }
        self.violations.push(Violation {
            path: path.into(),
            message: message.into(),
        });
    }

    /// Whether no fault was found.
    pub(crate) fn is_empty(&self) -> bool {
        self.violations.is_empty()
    }

    /// Whether no further fault is taken, so that none needs to be worded.
    pub(crate) fn is_full(&self) -> bool {
        self.violations.len() >= MOST_FAULTS
    }

    pub(crate) fn unsupported(&mut self, path: impl Into<String>, message: impl Into<String>) {
        self.unsupported.get_or_insert(Violation {
            path: path.into(),
            message: message.into(),
        });
    }

    pub(crate) fn finite(&mut self, path: &str, values: &[f64]) -> bool {
        let finite = values.iter().all(|value| value.is_finite());
        if !finite {
            self.add(path, format!("must be finite, not {values:?}"));
        }
        finite
    }

    /// Adds a fault where `value`, that of the key `path`, is not above zero and finite.
    pub(crate) fn above_zero(&mut self, path: &str, value: f64) {
        if !(value > 0.0 && value.is_finite()) {
            self.add(path, format!("must be above zero and finite, not {value}"));
        }
    }

    /// Adds a fault where a body has no shear stiffness at rest: it has no equilibrium to find. What
    /// is not finite has its own message.
    pub(crate) fn at_rest(&mut self, shear_modulus: f64, formula: &str, path: &str) {
        let is_usable = shear_modulus > 0.0 && shear_modulus.is_finite();
        if !is_usable && !shear_modulus.is_nan() {
            let message = format!(
                "the shear modulus at rest, {formula}, must be above zero and finite, not {shear_modulus}"
            );
            self.add(path, message);
        }
    }

    /// Adds a fault where `value`, that of the key `path`, is negative or not finite.
    pub(crate) fn not_negative(&mut self, path: &str, value: f64) {
        if !(value >= 0.0 && value.is_finite()) {
            self.add(
                path,
                format!("must be at least zero and finite, not {value}"),
            );
        }
    }

    pub(crate) fn result(self) -> Result<(), SceneError> {
        match (self.violations.is_empty(), self.unsupported) {
            (false, _) => Err(SceneError::Invalid(self.violations)),
            (true, Some(violation)) => Err(SceneError::Unsupported(violation)),
            (true, None) => Ok(()),
        }
    }
}

/// The law of a rubber without its volume, its constants checked.
///
/// # Errors
/// [`SceneError::Invalid`] with every fault.
pub(crate) fn isochoric(model: &RubberModel) -> Result<Isochoric, SceneError> {
    let mut faults = Faults::default();
    let law = rubber::law(model, "material", &mut faults);
    faults.result().map(|()| law)
}

/// The laws of a scene whose rest has been checked.
///
/// # Errors
/// [`SceneError`] with the path of every constant that has no meaning.
pub(crate) fn laws(scene: &Scene, mesh: &Mesh) -> Result<Vec<ResolvedMaterial>, SceneError> {
    let mut faults = Faults::default();
    let kind = kind(scene, mesh, &mut faults);
    let (mut materials, _) = materials::resolve(scene, mesh, &mut faults);
    if kind == SceneKind::PlaneStress {
        materials::flatten(scene, &mut materials, &mut faults);
    }
    materials::mixed(scene, &mut materials, &mut faults);
    faults.result().map(|()| materials)
}

/// Checks everything and resolves names. Obstacles are left to [`build`], which needs
/// the reference length.
pub(crate) fn resolve<'a>(
    scene: &'a Scene,
    steps: &[Step],
    mesh: &Mesh,
) -> Result<(Resolved, Vec<Placed<'a, Obstacle>>), SceneError> {
    within_extent(scene, mesh)?;
    let mut faults = Faults::default();
    let kind = kind(scene, mesh, &mut faults);
    faults.above_zero("mesh_scale", scene.mesh_scale.unwrap_or(1.0));
    let (mut materials, cell_material) = materials::resolve(scene, mesh, &mut faults);
    if kind == SceneKind::PlaneStress {
        materials::flatten(scene, &mut materials, &mut faults);
    }
    materials::check_formulations(scene, &materials, &mut faults);
    let mixed = materials::mixed(scene, &mut materials, &mut faults);
    materials::check_flow(scene, &materials, &mut faults);
    let supports = surfaces::supports(scene, mesh, &mut faults);
    let supports = profiles::resolve(supports, (steps, mesh), &mut faults);
    let tractions = surfaces::tractions(scene, mesh, &mut faults);
    let pressures = surfaces::pressures(scene, mesh, &mut faults);
    let fluids = fluids::resolve(scene, mesh, &mut faults);
    let obstacles = obstacles::resolve(scene, mesh, &mut faults);
    let pairs = pairs::resolve(scene, (kind, mesh), &mut faults);
    fluids::check_beside(mesh, (&fluids, &pairs), &mut faults);
    let others = ties::Others::of(&obstacles, &pairs, &fluids);
    let ties = ties::resolve(scene, mesh, others, &mut faults);
    obstacles::refuse_held_faces(mesh, &supports, &obstacles, &mut faults);
    let manufactured = bodies::manufactured(scene, mesh, &mut faults);
    bodies::body_force(scene, mesh, &mut faults);
    let body_force_values = values::of_body(scene, mesh, &mut faults);
    bodies::refuse_values(scene, &mut faults);
    let probes = bodies::probes(scene, mesh, &mut faults);
    goals::check(scene, kind, &mut faults);
    solver::check(scene, formulated(mixed, &materials), &mut faults);
    let held = rigid_modes::Held::by(&supports, &ties);
    let free = rigid_modes::check((scene, kind), mesh, held, &mut faults);
    solver::check_contact(scene, &free.modes, &mut faults);
    rubber::check(scene, &materials, &mut faults);
    steps::Steps { scene, mesh }.check_all(steps, &mut faults);
    faults.result()?;
    let resolved = Resolved {
        kind,
        cell_material,
        materials,
        mixed,
        supports,
        tractions,
        pressures,
        fluids,
        pairs,
        ties,
        body_force: scene.body_force,
        body_force_values,
        probes,
        manufactured,
        free_modes: free.modes,
        free_alone: free.alone,
    };
    Ok((resolved, obstacles))
}

fn formulated(mixed: bool, materials: &[ResolvedMaterial]) -> solver::Formulated {
    solver::Formulated {
        mixed,
        incompressible: materials.iter().all(ResolvedMaterial::is_incompressible),
    }
}

/// Whether the scene names no more than is worth a look.
fn within_extent(scene: &Scene, mesh: &Mesh) -> Result<(), SceneError> {
    let mut faults = Faults::default();
    extent::check(scene, mesh, &mut faults);
    faults.result()
}

/// Vertices nearer to the axis than this part of the body lie on it.
pub(crate) const ON_AXIS: f64 = 1e-9;

fn kind(scene: &Scene, mesh: &Mesh, faults: &mut Faults) -> SceneKind {
    let fitting: &[SceneKind] = match mesh.cell_kind() {
        CellKind::Triangle => &[
            SceneKind::PlaneStrain,
            SceneKind::PlaneStress,
            SceneKind::Axisymmetric,
        ],
        CellKind::Tetrahedron => &[SceneKind::Solid],
    };
    let asked = scene.kind.unwrap_or(fitting[0]);
    if !fitting.contains(&asked) {
        let names: Vec<&str> = fitting.iter().map(|kind| kind.name()).collect();
        let message = format!(
            "`{}` does not fit the mesh, whose cells ask for `{}`",
            asked.name(),
            names.join("` or `")
        );
        faults.add("kind", message);
        return fitting[0];
    }
    if asked == SceneKind::Axisymmetric {
        right_of_axis(mesh, faults);
    }
    asked
}

/// An axisymmetric body lies in x >= 0.
fn right_of_axis(mesh: &Mesh, faults: &mut Faults) {
    let least = -ON_AXIS * mesh.extent();
    let mut vertices = mesh.coordinates().iter().enumerate();
    if let Some((vertex, x)) = vertices.find(|(_, x)| x[0] < least) {
        let message = format!(
            "an axisymmetric body lies in x >= 0, but vertex {} is at {x:?}",
            mesh.used_vertices()[vertex]
        );
        faults.add("kind", message);
    }
}

/// Faults of a vector that must lie in the plane z = 0 of a plane scene.
pub(crate) fn in_plane(faults: &mut Faults, mesh: &Mesh, path: &str, vector: [f64; 3]) {
    if mesh.cell_kind() == CellKind::Triangle && vector[2] != 0.0 {
        faults.add(path, "the z component must be zero in a plane scene");
    }
}
