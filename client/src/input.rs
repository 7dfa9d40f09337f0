//! Reads the files that a command names.

use std::path::Path;

use signorini_client::WireMesh;
use signorini_client::formats::msh::{self, MeshFile};
use signorini_client::scene_file;
use signorini_proto::v1;

use crate::arguments::SceneArguments;
use crate::exit::{Exit, Failure};

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
    let mesh = load_mesh(&file.mesh)?;
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

/// Reads a mesh file.
pub(crate) fn load_mesh(path: &Path) -> Result<MeshFile, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, &error))?;
    msh::read(&bytes)
        .map_err(|error| Failure::new(Exit::Invalid, format!("{}: {error}", path.display())))
}
