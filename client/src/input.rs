//! Reads the files that a command names.

use std::path::Path;

use signorini_client::WireMesh;
use signorini_client::formats::mesh::{self, MeshFile};
use signorini_client::scene_file;
use signorini_proto::v1;

use crate::arguments::SceneArguments;
use crate::exit::{Exit, Failure};

/// What is told where a scene has no steps.
const WITHOUT_STEPS: &str =
    "the scene has no [[step]]: loads act in full at once, and no obstacle or support moves";

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
    let file = scene_file::read(&text, path, &arguments.overrides)?;
    let mut mesh = load_mesh(&file.mesh)?;
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
    mesh::read(&bytes, path)
        .map_err(|error| Failure::new(Exit::Invalid, format!("{}: {error}", path.display())))
}
