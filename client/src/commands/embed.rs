//! `embed`: what a library of another language asks of this program, so that scenes and
//! meshes mean the same there, and a server lives no longer than its caller.
//!
//! Hidden from help: the package `signorini` of `client/python` is its only user and comes
//! with the same build, so nothing here has to stay as it is.

mod serve;

use std::io::{Read as _, Write as _};
use std::path::Path;

use prost::Message;
use signorini_client::formats::mesh::MeshFile;
use signorini_client::formats::{grid, stl};
use signorini_client::scene_file::{self, Override, SceneFile, SceneFileError};
use signorini_client::{WireMesh, WireSurface};
use signorini_proto::v1;

use crate::arguments::EmbedCommand;
use crate::arguments::input;
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::text::note;

pub(super) async fn run(command: EmbedCommand) -> Result<Exit, Failure> {
    match command {
        EmbedCommand::Scene { path, overrides } => scene(&path, &overrides),
        EmbedCommand::Bodies { path, overrides } => {
            upload(&input::whole_mesh(&given(&path, &overrides)?)?)
        }
        EmbedCommand::Mesh { path } => upload(&input::load_mesh(&path)?),
        EmbedCommand::Surface { path, weld } => {
            let read = |bytes: &[u8]| stl::read_within(bytes, weld.unwrap_or(stl::WELD));
            surface(WireSurface::new(&input::read_file(&path, read)?)?)
        }
        EmbedCommand::Grid { path } => {
            surface(WireSurface::of_grid(&input::read_file(&path, grid::read)?))
        }
        EmbedCommand::Serve { listen } => serve::run(listen).await,
    }
}

/// The scene on stdin.
fn given(path: &Path, overrides: &[Override]) -> Result<SceneFile, Failure> {
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| Failure::unreadable(path, &error))?;
    Ok(scene_file::read(&text, path, overrides)?)
}

fn scene(path: &Path, overrides: &[Override]) -> Result<Exit, Failure> {
    let mut file = given(path, overrides)?;
    scene_file::read_values(&mut file).map_err(SceneFileError::Invalid)?;
    let mesh = file.mesh.to_str().ok_or_else(|| {
        let message = format!("mesh: {} is not UTF-8", file.mesh.display());
        Failure::new(Exit::Invalid, message)
    })?;
    let mut scene = v1::Scene {
        mesh: mesh.to_owned(),
        ..file.scene
    };
    for (index, path) in &file.surfaces {
        let shape = (scene.obstacles.get_mut(*index)).and_then(|one| one.shape.as_mut());
        if let Some(kind) = shape.and_then(|shape| shape.kind.as_mut()) {
            scene_file::name_surface(kind, path.to_string_lossy().into_owned());
        }
    }
    write(std::iter::once(scene.encode_to_vec()))
}

fn upload(mesh: &MeshFile) -> Result<Exit, Failure> {
    for warning in &mesh.warnings {
        note(&format!("warning: {warning}\n"));
    }
    let requests = WireMesh::new(mesh)?.requests();
    write(requests.map(|request| request.encode_length_delimited_to_vec()))
}

fn surface(surface: WireSurface) -> Result<Exit, Failure> {
    let requests = surface.requests();
    write(requests.map(|request| request.encode_length_delimited_to_vec()))
}

/// Writes messages to stdout.
fn write(messages: impl Iterator<Item = Vec<u8>>) -> Result<Exit, Failure> {
    let mut stdout = std::io::stdout().lock();
    let write_all = || {
        for message in messages {
            stdout.write_all(&message)?;
        }
        stdout.flush()
    };
    write_all().map_err(|error| Failure::new(Exit::Usage, format!("stdout: {error}")))?;
    Ok(Exit::Ok)
}
