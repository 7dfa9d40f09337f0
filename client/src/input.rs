//! Reads the files that a command names.

use std::path::Path;

use signorini_client::WireMesh;
use signorini_client::formats::mesh::MeshFile;
use signorini_client::formats::reader;
use signorini_client::scene_file::{self, SceneFileError};
use signorini_proto::v1;

use crate::arguments::SceneArguments;
use crate::exit::{Exit, Failure};

/// What is told where a scene has no steps.
const WITHOUT_STEPS: &str =
    "the scene has no [[step]]: loads act in full at once, and no obstacle or support moves";

/// What is told where nothing of a mesh has a name.
pub(crate) const WITHOUT_GROUPS: &str = "the mesh has no groups, so no key of a scene can name a part of it; \
    in Gmsh, before meshing: Physical Volume(\"body\") = {1}; Physical Surface(\"top\") = {6}; \
    of a section: Physical Surface(\"body\") = {1}; Physical Curve(\"top\") = {3};";

/// Where a mesh is looked for.
const BESIDE: &str = " (the mesh of a scene lies beside the scene, one of --set beside the shell)";

/// A scene with its mesh.
pub(crate) struct Input {
    /// Names its mesh by digest.
    pub(crate) scene: v1::Scene,
    /// Where the mesh was read.
    pub(crate) mesh_path: std::path::PathBuf,
    pub(crate) mesh: MeshFile,
    pub(crate) wire: WireMesh,
}

/// Reads a scene and the mesh it names.
pub(crate) fn load(arguments: &SceneArguments) -> Result<Input, Failure> {
    let path = &arguments.scene;
    let text = std::fs::read_to_string(path).map_err(|error| Failure::unreadable(path, &error))?;
    let file = scene_file::read(&text, path, &arguments.overrides).map_err(|error| {
        let whole = matches!(error, SceneFileError::Syntax(_));
        let failure = Failure::from(error);
        if whole { failure.about(path) } else { failure }
    })?;
    let mut mesh = load_mesh(&file.mesh).map_err(|failure| {
        let is_there = file.mesh.exists();
        if is_there {
            failure
        } else {
            failure.hint(BESIDE)
        }
    })?;
    if mesh.groups.is_empty() {
        mesh.warnings.push(WITHOUT_GROUPS.to_owned());
    }
    if file.scene.steps.is_empty() {
        mesh.warnings.push(WITHOUT_STEPS.to_owned());
    }
    let wire = WireMesh::new(&mesh)?;
    let scene = v1::Scene {
        mesh: wire.name(),
        ..file.scene
    };
    Ok(Input {
        scene,
        mesh_path: file.mesh,
        mesh,
        wire,
    })
}

/// Reads a mesh file of any format.
pub(crate) fn load_mesh(path: &Path) -> Result<MeshFile, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, &error))?;
    reader::read(&bytes, path)
        .map_err(|error| Failure::new(Exit::Invalid, format!("{}: {error}", path.display())))
}
