//! The folder of `--out`: a PVD series of VTU files (the body) and VTP files
//! (the obstacles, where they are touched, and where fluids leak), beside the result lines.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use signorini_client::formats::Notes;
use signorini_client::formats::contact_patch::PatchSurface;
use signorini_client::formats::derived::{
    OutOfPlane, principal_stresses, principal_stretches, von_mises,
};
use signorini_client::formats::leak_path;
use signorini_client::formats::mesh::MeshFile;
use signorini_client::formats::pvd::{self, PvdEntry};
use signorini_client::formats::vtp::{self, BoundingBox, Pose, Triangulation};
use signorini_client::formats::vtu::{Grid, GridField};
use signorini_client::scene_file::{drawn_near, file_drawn_near};
use signorini_client::solve::{Field, Increment};
use signorini_proto::{v1, words};

use super::stem::{file_stem, unique_stems};
use super::units;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::whole_file;

/// What the numbers of a field mean that do not say it themselves.
const CONTACT_STATES: &str = "-1 not a candidate, 0 open, 1 in contact";

/// Fields written when the scene names none.
pub(crate) const DEFAULT_FIELDS: [v1::FieldName; 5] = [
    v1::FieldName::Displacement,
    v1::FieldName::Pressure,
    v1::FieldName::ContactPressure,
    v1::FieldName::Gap,
    v1::FieldName::ContactState,
];

/// Fields that are made of the stress and the displacement.
pub(crate) const DERIVED: [&str; 3] = ["von_mises", "principal_stresses", "principal_stretches"];

/// What the name of a contact patch has after that of its obstacle.
const PATCH: &str = "_contact";

/// What the name of a leak path has after that of its fluid.
const LEAK: &str = "_leak";

/// Name of the result lines in the folder.
pub(crate) const LINES: &str = "results.jsonl";

/// What tools from files look like in their initial pose, by the names of their obstacles.
pub(crate) type Drawings = HashMap<String, Triangulation>;

/// Writes the results of one run.
pub(crate) struct ResultFolder {
    folder: PathBuf,
    stem: String,
    scene_name: String,
    /// What they are called, by arrays.
    units: BTreeMap<String, String>,
    grid: Grid,
    /// Whether stretches belong to its stress, and what stretches out of the plane.
    stretches: Option<OutOfPlane>,
    /// Around the undeformed body.
    body: BoundingBox,
    /// Names, the part of a file's name that stands for each, and shapes.
    obstacles: Vec<(String, String, v1::Shape)>,
    /// Where each of these may be touched, by the part of a file's name.
    touched: Vec<(String, PatchSurface)>,
    /// Names of fluids, and the part of a file's name that stands for the leak path of each.
    fluids: Vec<(String, String)>,
    drawings: Drawings,
    entries: Vec<PvdEntry>,
    written: usize,
}

impl ResultFolder {
    /// Makes the folder. Tools from files that have no drawing are not written.
    pub(crate) fn new(
        folder: &Path,
        scene: &v1::Scene,
        (mesh, drawings): (&MeshFile, Drawings),
    ) -> Result<Self, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| Failure::unwritable(folder, &error))?;
        let scale = scene.mesh_scale.unwrap_or(1.0);
        let points: Vec<[f64; 3]> = mesh
            .coordinates
            .iter()
            .map(|point| point.map(|x| x * scale))
            .collect();
        let mut grid = Grid::new(mesh.vertices_per_cell, &points, &mesh.cells)
            .map_err(|error| Failure::new(Exit::Invalid, error.to_string()))?;
        let curved = mesh.curved.iter();
        grid.bend(curved.map(|edge| (edge.ends, edge.offset.map(|x| x * scale))));
        let body = BoundingBox::of(&points);
        let names = scene.obstacles.iter().map(|one| one.name.clone());
        let patches = scene.obstacles.iter().map(|one| one.name.clone() + PATCH);
        let leaks = scene.fluids.iter().map(|one| one.name.clone() + LEAK);
        let mut stems = unique_stems(names.chain(patches).chain(leaks));
        let of_leaks = stems.split_off(2 * scene.obstacles.len());
        let of_patches = stems.split_off(scene.obstacles.len());
        let obstacles = scene.obstacles.iter().zip(stems);
        let shapes =
            obstacles.filter_map(|(one, stem)| Some((one.name.clone(), stem, one.shape.clone()?)));
        let obstacles = scene.obstacles.iter().zip(of_patches);
        let touched = obstacles.map(|(one, stem)| (stem, PatchSurface::new(mesh, &one.on)));
        let names = scene.fluids.iter().map(|one| one.name.clone());
        let fluids = names.zip(of_leaks);
        Ok(Self {
            folder: folder.to_owned(),
            stem: file_stem(&scene.name),
            scene_name: scene.name.clone(),
            units: units::of_arrays(scene),
            grid,
            stretches: stretches(scene),
            body,
            obstacles: shapes.collect(),
            touched: touched.collect(),
            fluids: fluids.collect(),
            drawings,
            entries: Vec::new(),
            written: 0,
        })
    }

    /// The folder itself.
    pub(crate) fn path(&self) -> &Path {
        &self.folder
    }

    /// Path of the result lines.
    pub(crate) fn lines(&self) -> PathBuf {
        self.folder.join(LINES)
    }

    /// Path of the series.
    pub(crate) fn series(&self) -> PathBuf {
        self.folder.join(format!("{}.pvd", self.stem))
    }

    /// Writes the files of an increment that came with fields.
    pub(crate) fn add(&mut self, increment: &Increment) -> Result<(), Failure> {
        let mut fields = increment.fields.iter();
        if fields.all(|field| field.name == v1::FieldName::ContactPath) {
            return Ok(());
        }
        self.written += 1;
        let number = self.written;
        let body = self.body_file(&increment.fields, increment.report.time)?;
        let name = format!("{}_{number:04}.vtu", self.stem);
        self.put(increment.report.time, 0, name, &body)?;
        let near = self.neighbourhood(&increment.fields);
        for part in 0..self.obstacles.len() {
            self.add_obstacle(part, &increment.report, number, &near)?;
        }
        self.add_patches(increment, number)?;
        self.add_leak_paths(&increment.report, number)?;
        // Rewritten each time, so that an interrupted run leaves a whole series.
        let series = self.series();
        write(&series, pvd::write(&self.entries).as_bytes())
    }

    fn notes(&self, time: f64) -> Notes {
        Notes {
            time: Some(time),
            texts: vec![("scene".to_owned(), self.scene_name.clone())],
            units: self.units.clone(),
        }
    }

    fn body_file(&self, fields: &[Field], time: f64) -> Result<Vec<u8>, Failure> {
        let on_body = fields
            .iter()
            .filter(|field| field.name != v1::FieldName::ContactPath);
        let named = on_body.map(|field| Named {
            name: words::field(field.name),
            components: field.components,
            values: Cow::Borrowed(field.values.as_slice()),
        });
        let mut all: Vec<Named<'_>> = named.collect();
        all.extend(self.derived(fields));
        let mut notes = self.notes(time);
        if all.iter().any(|field| field.name == "contact_state") {
            let meaning = ("contact_state".to_owned(), CONTACT_STATES.to_owned());
            notes.texts.push(meaning);
        }
        let fields: Vec<GridField<'_>> = all
            .iter()
            .map(|field| GridField {
                name: &field.name,
                components: field.components,
                values: &field.values,
            })
            .collect();
        let written = self.grid.write(&fields, &notes);
        written.map_err(|error| Failure::new(Exit::Server, error.to_string()))
    }

    /// What belongs to the stress, where it was asked for.
    fn derived(&self, fields: &[Field]) -> Vec<Named<'static>> {
        let find = |name| fields.iter().find(|field| field.name == name);
        let Some(stress) = find(v1::FieldName::Stress) else {
            return Vec::new();
        };
        let made = |name: &str, components, values| Named {
            name: name.to_owned(),
            components,
            values: Cow::Owned(values),
        };
        let [mises, stresses, stretches] = DERIVED;
        let mut derived = vec![
            made(mises, 1, von_mises(&stress.values)),
            made(stresses, 3, principal_stresses(&stress.values)),
        ];
        if let (Some(out), Some(motion)) = (self.stretches, find(v1::FieldName::Displacement)) {
            let values = principal_stretches(&self.grid, &motion.values, out);
            derived.push(made(stretches, 3, values));
        }
        derived
    }

    /// The box around the body, undeformed and deformed, in which obstacles are drawn.
    fn neighbourhood(&self, fields: &[Field]) -> BoundingBox {
        let motion = fields
            .iter()
            .find(|field| field.name == v1::FieldName::Displacement);
        let motion = motion.map_or(&[][..], |field| field.values.as_slice());
        let (points, _) = self.grid.points().as_chunks::<3>();
        let (motions, _) = motion.as_chunks::<3>();
        let moved = points
            .iter()
            .zip(motions)
            .map(|(&[x, y, z], &[u, v, w])| [x + u, y + v, z + w]);
        self.body.with(moved).neighbourhood()
    }

    fn add_obstacle(
        &mut self,
        part: usize,
        report: &v1::StepReport,
        number: usize,
        near: &BoundingBox,
    ) -> Result<(), Failure> {
        let Some((name, stem, shape)) = self.obstacles.get(part) else {
            return Ok(());
        };
        let pose = report.obstacle_poses.iter().find(|pose| pose.name == *name);
        let pose = pose.map(pose_of).unwrap_or_default();
        let surface = match self.drawings.get(name) {
            Some(drawing) => Some(file_drawn_near(drawing, &pose, near)),
            None => drawn_near(shape, &pose, near),
        };
        let Some(surface) = surface else {
            return Ok(());
        };
        let mut notes = self.notes(report.time);
        notes.texts.push(("obstacle".to_owned(), name.clone()));
        let drawn = vtp::write(&surface, &notes);
        let file = format!("{}_{stem}_{number:04}.vtp", self.stem);
        self.put(report.time, part + 1, file, &drawn)
    }

    /// Writes where the body presses on each obstacle, if it is known.
    fn add_patches(&mut self, increment: &Increment, number: usize) -> Result<(), Failure> {
        let find = |name| increment.fields.iter().find(|field| field.name == name);
        let (Some(motion), Some(pressure)) = (
            find(v1::FieldName::Displacement),
            find(v1::FieldName::ContactPressure),
        ) else {
            return Ok(());
        };
        let time = increment.report.time;
        let drawn = self.touched.iter().map(|(stem, surface)| {
            let outline = surface.outline(&self.grid, &motion.values, &pressure.values);
            let file = format!("{}_{stem}_{number:04}.vtp", self.stem);
            (file, outline.write(&self.notes(time)))
        });
        for (place, (file, bytes)) in drawn.collect::<Vec<_>>().into_iter().enumerate() {
            self.put(time, self.obstacles.len() + 1 + place, file, &bytes)?;
        }
        Ok(())
    }

    /// Writes the path on which each fluid leaks first, where it has one.
    fn add_leak_paths(&mut self, report: &v1::StepReport, number: usize) -> Result<(), Failure> {
        let first = self.obstacles.len() + self.touched.len() + 1;
        let paths = self
            .fluids
            .iter()
            .enumerate()
            .filter_map(|(place, (name, stem))| {
                let path = report.fluids.get(name)?.leak_path.as_ref()?;
                let mut notes = self.notes(report.time);
                notes.texts.push(("fluid".to_owned(), name.clone()));
                let (points, _) = path.points.as_chunks::<3>();
                let drawn = leak_path::write(points, &path.pressures, &notes);
                let file = format!("{}_{stem}_{number:04}.vtp", self.stem);
                Some((first + place, file, drawn))
            });
        for (part, file, bytes) in paths.collect::<Vec<_>>() {
            self.put(report.time, part, file, &bytes)?;
        }
        Ok(())
    }

    fn put(&mut self, time: f64, part: usize, file: String, bytes: &[u8]) -> Result<(), Failure> {
        write(&self.folder.join(&file), bytes)?;
        self.entries.push(PvdEntry { time, part, file });
        Ok(())
    }
}

/// A field of a file.
struct Named<'a> {
    name: String,
    components: usize,
    values: Cow<'a, [f64]>,
}

/// Whether a scene has rubber, whose stretches are drawn, and what stretches out of its plane; none in
/// a sheet whose volume can change, where the displacement does not tell.
fn stretches(scene: &v1::Scene) -> Option<OutOfPlane> {
    let laws: Vec<bool> = scene
        .materials
        .iter()
        .filter_map(has_fixed_volume)
        .collect();
    if laws.is_empty() {
        return None;
    }
    match scene.kind() {
        v1::SceneKind::Axisymmetric => Some(OutOfPlane::Hoop),
        v1::SceneKind::PlaneStress => {
            let is_fixed = laws.len() == scene.materials.len() && laws.iter().all(|&one| one);
            is_fixed.then_some(OutOfPlane::Thickness)
        }
        v1::SceneKind::Unspecified | v1::SceneKind::Solid | v1::SceneKind::PlaneStrain => {
            Some(OutOfPlane::Nothing)
        }
    }
}

/// Whether a law of finite strain keeps the volume; none of other materials.
fn has_fixed_volume(material: &v1::Material) -> Option<bool> {
    use v1::material::Model;
    let bulk_modulus = match material.model.as_ref()? {
        Model::MooneyRivlin(law) => law.bulk_modulus,
        Model::NeoHookean(law) => law.bulk_modulus,
        Model::Yeoh(law) => law.bulk_modulus,
        Model::Ogden(law) => law.bulk_modulus,
        Model::Polynomial(law) => law.bulk_modulus,
        Model::Gent(law) => law.bulk_modulus,
        Model::ArrudaBoyce(law) => law.bulk_modulus,
        Model::VanDerWaals(law) => law.bulk_modulus,
        Model::Hyperfoam(_) | Model::BlatzKo(_) => return Some(false),
        Model::LinearElastic(_) | Model::Stokes(_) => return None,
    };
    Some(bulk_modulus.is_none())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    whole_file::write(path, bytes).map_err(|error| Failure::unwritable(path, &error))
}

fn three(values: &[f64]) -> [f64; 3] {
    values.try_into().unwrap_or_default()
}

fn pose_of(pose: &v1::ObstaclePose) -> Pose {
    Pose {
        translation: three(&pose.translation),
        rotation: three(&pose.rotation),
    }
}
