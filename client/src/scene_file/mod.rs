//! Scene files: TOML into the message that the service takes.
//!
//! The form only is read here: names of keys, types of values, required keys.
//! What the values mean is checked by the server, which answers with the same
//! key paths; keys of capabilities that it does not have yet are passed on, so
//! that it can say so. Every fault of a file is reported, not just the first.

mod bodies;
mod body;
mod fluid;
mod goals;
pub(crate) mod keys;
mod material;
mod obstacle;
mod outline;
mod overrides;
mod sampled;
mod shape;
mod step;
mod suggest;
mod syntax;
mod values;

#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;
use toml::Table;

pub use bodies::BodyFile;
pub use outline::{drawn_near, outline};
pub use overrides::{Override, read_value};
pub use sampled::{facets, file_drawn_near, grid_surface};
pub use values::{NamedValues, ValuesPlace, read_values};

use crate::library::error::Violation;
use keys::{Faults, Keys};

const SCENE: &[&str] = &[
    "name",
    "mesh",
    "mesh_scale",
    "kind",
    "units",
    "material",
    "support",
    "traction",
    "pressure",
    "fluid",
    "body_force",
    "obstacle",
    "body",
    "contact",
    "tie",
    "manufactured",
    "step",
    "solver",
    "probe",
    "gradient",
    "accuracy",
    "output",
];

const KINDS: &[(&str, v1::SceneKind)] = &[
    ("solid", v1::SceneKind::Solid),
    ("plane-strain", v1::SceneKind::PlaneStrain),
    ("plane-stress", v1::SceneKind::PlaneStress),
    ("axisymmetric", v1::SceneKind::Axisymmetric),
];

/// A scene file that has been read.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// The message; `mesh` is still empty, for the mesh has no digest yet.
    pub scene: v1::Scene,
    /// Path of the mesh file; empty where bodies have meshes of their own.
    pub mesh: PathBuf,
    /// Bodies with mesh files of their own; empty where the scene has one mesh.
    pub bodies: Vec<BodyFile>,
    /// Paths of the triangulated surfaces and grids, by the place of their obstacle; their names in the
    /// message are still what the file says.
    pub surfaces: Vec<(usize, PathBuf)>,
    /// Files of values, whose rows [`read_values`] puts into the message.
    pub values: Vec<NamedValues>,
}

/// Why a scene file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneFileError {
    /// The text is not TOML; line and column are in the message.
    #[error("not a TOML file: {0}")]
    Syntax(String),
    /// Keys that are wrong, at least one.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Invalid(Vec<Violation>),
}

/// Reads a scene from text. `path` names the file: its stem is the default name
/// and its folder is where a relative `mesh` begins, of the scene or of a body. Overrides are applied to
/// the file's tables before anything is checked; a mesh among them is relative
/// to the working directory.
///
/// # Errors
/// [`SceneFileError`], with every key that is wrong.
pub fn read(text: &str, path: &Path, overrides: &[Override]) -> Result<SceneFile, SceneFileError> {
    Template::parse(text, path)?.read(overrides)
}

/// The tables of a scene file, to be read with one set of changes after another.
#[derive(Clone, Debug)]
pub struct Template {
    table: Table,
    path: PathBuf,
}

impl Template {
    /// Parses the text of a file.
    ///
    /// # Errors
    /// [`SceneFileError::Syntax`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneFileError> {
        let table = text.parse().map_err(|error| {
            let message = syntax::explain(text, &error);
            SceneFileError::Syntax(message)
        })?;
        let path = path.to_owned();
        Ok(Self { table, path })
    }

    /// As [`read`].
    ///
    /// # Errors
    /// [`SceneFileError::Invalid`].
    pub fn read(&self, overrides: &[Override]) -> Result<SceneFile, SceneFileError> {
        let (mut table, faults) = (Cow::Borrowed(&self.table), Faults::default());
        for change in overrides {
            if let Err(violation) = change.apply(table.to_mut()) {
                faults.add(violation.path, violation.message);
            }
        }
        let keys = Keys::new(String::new(), &table, SCENE, &faults);
        let stem = self.path.file_stem();
        let stem = stem.map(|stem| stem.to_string_lossy().into_owned());
        let scene = scene(&keys, stem.unwrap_or_default());
        let beside = self.path.parent().unwrap_or(Path::new(""));
        let bodies = bodies::bodies(&keys, beside);
        let mesh = match bodies[..] {
            [] => PathBuf::from(keys.required_text("mesh")),
            _ => PathBuf::new(),
        };
        let given = overrides.iter().any(Override::is_mesh);
        let folder = if given { Path::new("") } else { beside };
        faults.finish().map_err(SceneFileError::Invalid)?;
        Ok(SceneFile {
            surfaces: surfaces(&scene, beside),
            values: values::named(&table, beside),
            scene,
            mesh: if bodies.is_empty() {
                folder.join(mesh)
            } else {
                mesh
            },
            bodies,
        })
    }

    /// The tables in one order, without comments, of equal bytes where the scenes are equal.
    pub fn canonical(&self) -> String {
        // Tables of a file can always be written again.
        toml::to_string(&self.table).unwrap_or_default()
    }
}

/// Files of the surfaces of obstacles, relative to `folder`.
fn surfaces(scene: &v1::Scene, folder: &Path) -> Vec<(usize, PathBuf)> {
    let obstacles = scene.obstacles.iter().enumerate();
    let file = |(index, obstacle): (usize, &v1::Obstacle)| {
        let file = surface_name(obstacle.shape.as_ref()?.kind.as_ref()?)?;
        Some((index, folder.join(file)))
    };
    obstacles.filter_map(file).collect()
}

/// The file, or the uploaded surface, that a shape names.
pub fn surface_name(kind: &Kind) -> Option<&str> {
    match kind {
        Kind::Surface(surface) => Some(&surface.surface),
        Kind::HeightField(field) => Some(&field.grid),
        Kind::DistanceGrid(distances) => Some(&distances.grid),
        Kind::HalfSpace(_)
        | Kind::Sphere(_)
        | Kind::Cylinder(_)
        | Kind::CappedCylinder(_)
        | Kind::Box(_)
        | Kind::Torus(_)
        | Kind::Cone(_) => None,
    }
}

/// Lets a shape from a file name another file, or an uploaded surface.
pub fn name_surface(kind: &mut Kind, name: String) {
    match kind {
        Kind::Surface(surface) => surface.surface = name,
        Kind::HeightField(field) => field.grid = name,
        Kind::DistanceGrid(distances) => distances.grid = name,
        Kind::HalfSpace(_)
        | Kind::Sphere(_)
        | Kind::Cylinder(_)
        | Kind::CappedCylinder(_)
        | Kind::Box(_)
        | Kind::Torus(_)
        | Kind::Cone(_) => {}
    }
}

fn scene(keys: &Keys<'_>, stem: String) -> v1::Scene {
    let (body_force, body_force_values) = body::body_force(keys);
    v1::Scene {
        name: keys.text("name").unwrap_or(stem),
        mesh: String::new(),
        mesh_scale: keys.number("mesh_scale"),
        kind: keys.choice("kind", KINDS).map_or(0, i32::from),
        materials: material::materials(keys),
        supports: body::supports(keys),
        tractions: body::tractions(keys),
        pressures: body::pressures(keys),
        fluids: fluid::fluids(keys),
        body_force,
        body_force_values,
        obstacles: obstacle::obstacles(keys),
        contacts: obstacle::contacts(keys),
        ties: obstacle::ties(keys),
        manufactured: body::manufactured(keys),
        steps: step::steps(keys),
        solver: body::solver(keys),
        probes: body::probes(keys),
        gradients: goals::gradients(keys),
        accuracy: goals::accuracy(keys),
        output: body::output(keys),
        units: body::units(keys),
    }
}
