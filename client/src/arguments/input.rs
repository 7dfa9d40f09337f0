//! Reads the files that a command names.

use std::path::{Path, PathBuf};

use signorini_client::bounded_file;
use signorini_client::formats::grid;
use signorini_client::formats::inp::{self, scene::DeckScene};
use signorini_client::formats::mesh::{self, Body, MeshFile};
use signorini_client::formats::reader::{self, Format, ReadError};
use signorini_client::formats::stl;
use signorini_client::formats::vtp::Triangulation;
use signorini_client::scene_file::{self, Override, SceneFile, SceneFileError};
use signorini_client::{Client, WireMesh, WireSurface};
use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;

use crate::arguments::SceneArguments;
use crate::report::results::Drawings;
use crate::terminal::exit::{Exit, Failure};

/// What is told where a scene has no steps.
const WITHOUT_STEPS: &str =
    "the scene has no [[step]]: loads act in full at once, and no obstacle or support moves";

/// What is told where nothing of a mesh has a name.
pub(crate) const WITHOUT_GROUPS: &str = "the mesh has no groups, so no key of a scene can name a part of it; \
    in Gmsh, before meshing: Physical Volume(\"body\") = {1}; Physical Surface(\"top\") = {6}; \
    of a section: Physical Surface(\"body\") = {1}; Physical Curve(\"top\") = {3};";

/// Bytes of a scene file: comments included, four times what a server takes of a scene.
const MOST_SCENE_BYTES: u64 = 16 << 20;

/// Bytes of a mesh or a tool: a text of the largest mesh that a server takes.
const MOST_BYTES: u64 = 32 << 30;

/// Where a mesh is looked for.
const BESIDE: &str = " (the mesh of a scene lies beside the scene, one of --set beside the shell)";

/// A scene with its mesh.
pub(crate) struct Input {
    /// Names its mesh by digest.
    pub(crate) scene: v1::Scene,
    /// Where the mesh was read.
    pub(crate) mesh_path: PathBuf,
    pub(crate) mesh: MeshFile,
    pub(crate) wire: WireMesh,
    /// Surfaces that the scene names by digest, with their files.
    pub(crate) surfaces: Vec<(PathBuf, WireSurface)>,
    /// What they look like.
    pub(crate) drawings: Drawings,
}

impl Input {
    /// Makes sure that the server has the mesh and the surfaces.
    pub(crate) async fn upload(&mut self, client: &Client) -> Result<(), Failure> {
        let uploaded = client.upload_mesh(self.wire.clone()).await;
        uploaded.map_err(|error| error.about(&self.mesh_path))?;
        for (path, surface) in self.surfaces.drain(..) {
            let uploaded = client.upload_surface(surface).await;
            uploaded.map_err(|error| error.about(&path))?;
        }
        Ok(())
    }
}

/// Reads a scene and the mesh it names.
pub(crate) fn load(arguments: &SceneArguments) -> Result<Input, Failure> {
    let mut file = read_scene(&arguments.scene, &arguments.overrides)?;
    scene_file::read_values(&mut file).map_err(SceneFileError::Invalid)?;
    let mut mesh = whole_mesh(&file)?;
    if mesh.groups.is_empty() {
        mesh.warnings.push(WITHOUT_GROUPS.to_owned());
    }
    if file.scene.steps.is_empty() {
        mesh.warnings.push(WITHOUT_STEPS.to_owned());
    }
    let wire = WireMesh::new(&mesh)?;
    let mut scene = v1::Scene {
        mesh: wire.name(),
        ..file.scene
    };
    let surfaces = load_surfaces(&mut scene, &file.surfaces)?;
    Ok(Input {
        scene,
        mesh_path: if file.bodies.is_empty() {
            file.mesh
        } else {
            arguments.scene.clone()
        },
        mesh,
        wire,
        surfaces: surfaces.wire,
        drawings: surfaces.drawings,
    })
}

/// What a scene file says, with changes to it.
fn read_scene(path: &Path, overrides: &[Override]) -> Result<SceneFile, Failure> {
    let text = read_text(path)?;
    scene_file::read(&text, path, overrides).map_err(|error| {
        let whole = matches!(error, SceneFileError::Syntax(_));
        let failure = Failure::from(error);
        if whole { failure.about(path) } else { failure }
    })
}

/// A scene alone, with changes to it, without the files that it names.
pub(crate) fn changed_scene(arguments: &SceneArguments) -> Result<v1::Scene, Failure> {
    Ok(read_scene(&arguments.scene, &arguments.overrides)?.scene)
}

/// The mesh of a scene, with the path that it was read from.
pub(crate) fn mesh_of(path: &Path) -> Result<(PathBuf, MeshFile), Failure> {
    let file = read_scene(path, &[])?;
    let read = whole_mesh(&file)?;
    let from = if file.bodies.is_empty() {
        file.mesh
    } else {
        path.to_owned()
    };
    Ok((from, read))
}

/// The mesh of a scene, that of all its bodies where these have meshes of their own.
pub(crate) fn whole_mesh(file: &SceneFile) -> Result<MeshFile, Failure> {
    let load = |path: &Path| {
        load_mesh(path).map_err(|failure| match path.exists() {
            true => failure,
            false => failure.hint(BESIDE),
        })
    };
    if file.bodies.is_empty() {
        return load(&file.mesh);
    }
    let bodies = file.bodies.iter().map(|body| {
        Ok(Body {
            name: body.name.clone(),
            mesh: load(&body.mesh)?,
            placement: body.placement,
        })
    });
    let bodies = bodies.collect::<Result<Vec<Body>, Failure>>()?;
    mesh::joined(bodies).map_err(|fault| Failure::new(Exit::Invalid, format!("body: {fault}")))
}

/// Surfaces of obstacles, and what they look like by the names of the obstacles.
#[derive(Default)]
struct Surfaces {
    wire: Vec<(PathBuf, WireSurface)>,
    drawings: Drawings,
}

/// Reads the surfaces of obstacles, and names them in the scene.
fn load_surfaces(scene: &mut v1::Scene, files: &[(usize, PathBuf)]) -> Result<Surfaces, Failure> {
    let mut surfaces = Surfaces::default();
    for (index, path) in files {
        let Some(obstacle) = scene.obstacles.get_mut(*index) else {
            continue;
        };
        let shape = obstacle.shape.as_mut();
        if let Some(kind) = shape.and_then(|shape| shape.kind.as_mut()) {
            let (wire, drawing) = load_surface(kind, path)?;
            surfaces.wire.push((path.clone(), wire));
            surfaces.drawings.insert(obstacle.name.clone(), drawing);
        }
    }
    Ok(surfaces)
}

/// The surface of an obstacle as it travels, from its file.
pub(crate) fn wire_surface(
    scene: &v1::Scene,
    obstacle: usize,
    path: &Path,
) -> Result<WireSurface, Failure> {
    let shape = scene
        .obstacles
        .get(obstacle)
        .and_then(|one| one.shape.as_ref());
    let mut kind = shape.and_then(|shape| shape.kind.clone());
    let kind = kind.as_mut();
    let kind = kind.ok_or_else(|| Failure::new(Exit::Usage, "the obstacle has no shape"))?;
    Ok(load_surface(kind, path)?.0)
}

/// Names the surface of an obstacle that is from a file.
pub(crate) fn name_surface(scene: &mut v1::Scene, obstacle: usize, name: String) {
    let shape = scene
        .obstacles
        .get_mut(obstacle)
        .and_then(|one| one.shape.as_mut());
    if let Some(kind) = shape.and_then(|shape| shape.kind.as_mut()) {
        scene_file::name_surface(kind, name);
    }
}

/// Reads the file of a shape, and names what is in it there.
fn load_surface(kind: &mut Kind, path: &Path) -> Result<(WireSurface, Triangulation), Failure> {
    let (wire, drawing) = match kind {
        Kind::Surface(surface) => {
            let weld = surface.weld.unwrap_or(stl::WELD);
            let file = read_file(path, |bytes| stl::read_within(bytes, weld))?;
            let drawing = scene_file::facets(&file, surface.scale.unwrap_or(1.0));
            (WireSurface::new(&file)?, drawing)
        }
        Kind::HeightField(_) | Kind::DistanceGrid(_) => {
            let file = read_file(path, grid::read)?;
            (WireSurface::of_grid(&file), scene_file::grid_surface(&file))
        }
        Kind::HalfSpace(_)
        | Kind::Sphere(_)
        | Kind::Cylinder(_)
        | Kind::CappedCylinder(_)
        | Kind::Box(_)
        | Kind::Torus(_)
        | Kind::Cone(_) => return Err(Failure::new(Exit::Usage, "the shape has no file")),
    };
    scene_file::name_surface(kind, wire.name());
    Ok((wire, drawing))
}

fn read_text(path: &Path) -> Result<String, Failure> {
    let bytes = bounded_file::read(path, MOST_SCENE_BYTES);
    let bytes = bytes.map_err(|error| Failure::unreadable(path, &error))?;
    let wrong = |_| Failure::new(Exit::Invalid, format!("{}: no UTF-8", path.display()));
    String::from_utf8(bytes).map_err(wrong)
}

/// Reads a file, its faults told with its path.
pub(crate) fn read_file<T, E: std::fmt::Display>(
    path: &Path,
    read: impl FnOnce(&[u8]) -> Result<T, E>,
) -> Result<T, Failure> {
    let bytes =
        bounded_file::read(path, MOST_BYTES).map_err(|error| Failure::unreadable(path, &error))?;
    read(&bytes)
        .map_err(|error| Failure::new(Exit::Invalid, format!("{}: {error}", path.display())))
}

/// Reads a mesh file of any format, and what it includes beside it.
pub(crate) fn load_mesh(path: &Path) -> Result<MeshFile, Failure> {
    let told = |error: MeshFault| match error {
        MeshFault::System(error) => Failure::unreadable(path, &error),
        MeshFault::Content(error) => {
            Failure::new(Exit::Invalid, format!("{}: {error}", path.display()))
        }
    };
    let check = |head: &[u8]| reader::check_head(head, path).map_err(MeshFault::from);
    let bytes = bounded_file::read_if(path, MOST_BYTES, check).map_err(told)?;
    let mesh = reader::read(&bytes, path, &mut beside(path));
    mesh.map_err(|error| told(error.into()))
}

/// Why a file gives no mesh: it cannot be read, or is none.
#[derive(Debug, thiserror::Error)]
enum MeshFault {
    #[error(transparent)]
    System(#[from] std::io::Error),
    #[error(transparent)]
    Content(#[from] ReadError),
}

/// Reads what an Abaqus deck says beside its mesh; none of other formats.
pub(crate) fn load_deck(path: &Path) -> Result<Option<DeckScene>, Failure> {
    read_file(path, |bytes| match Format::of(bytes, path) {
        Some(Format::Inp) => inp::read_scene(bytes, &mut beside(path)).map(Some),
        _ => Ok(None),
    })
}

/// Reads files below the folder of a deck.
fn beside(path: &Path) -> impl FnMut(&Path) -> Result<Vec<u8>, String> {
    move |name| {
        let file = path.with_file_name(name);
        bounded_file::read(&file, MOST_BYTES).map_err(|error| error.to_string())
    }
}
