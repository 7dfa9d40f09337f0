//! Meshes and surfaces that cases name: read once, handed on once, named by digest.

use std::collections::HashMap;
use std::future::Future;
use std::path::{Path, PathBuf};

use signorini_client::scene_file::SceneFile;
use signorini_client::{Client, ClientError, WireMesh, WireSurface};
use signorini_proto::v1;
use tokio::sync::Mutex;

use crate::arguments::input;
use crate::terminal::exit::Failure;

/// What takes meshes and surfaces.
pub(crate) trait Depot {
    /// Why it did not take one.
    type Error: From<ClientError>;

    /// Takes a mesh.
    fn mesh(&self, mesh: WireMesh) -> impl Future<Output = Result<(), Self::Error>> + Send;

    /// Takes a surface.
    fn surface(&self, surface: WireSurface)
    -> impl Future<Output = Result<(), Self::Error>> + Send;
}

/// A server.
impl Depot for Client {
    type Error = ClientError;

    async fn mesh(&self, mesh: WireMesh) -> Result<(), ClientError> {
        self.upload_mesh(mesh).await.map(|_| ())
    }

    async fn surface(&self, surface: WireSurface) -> Result<(), ClientError> {
        self.upload_surface(surface).await
    }
}

/// Why a scene has no names for its files.
#[derive(Debug)]
pub(crate) enum AssetFault<E> {
    /// A file that cannot be used.
    File(Failure),
    /// What was to take it did not.
    Depot(E),
}

/// Names of files that were handed on.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    names: Mutex<HashMap<PathBuf, String>>,
}

impl Assets {
    /// Forgets all: whoever took them has lost some.
    pub(crate) async fn forget(&self) {
        self.names.lock().await.clear();
    }

    /// The scene of a case, its mesh and surfaces named by digest and handed on.
    pub(crate) async fn name<D: Depot>(
        &self,
        file: SceneFile,
        depot: &D,
    ) -> Result<v1::Scene, AssetFault<D::Error>> {
        // One task reads a file, the others wait for its name.
        let mut names = self.names.lock().await;
        let mut scene = file.scene;
        scene.mesh = match names.get(&file.mesh) {
            Some(name) => name.clone(),
            None => {
                let name = hand_on_mesh(&file.mesh, depot).await?;
                names.insert(file.mesh, name.clone());
                name
            }
        };
        for (index, path) in file.surfaces {
            let known = names.get(&path).cloned();
            let name = match known {
                Some(name) => name,
                None => hand_on_surface(&scene, index, &path, depot).await?,
            };
            input::name_surface(&mut scene, index, name.clone());
            names.insert(path, name);
        }
        Ok(scene)
    }
}

async fn hand_on_mesh<D: Depot>(path: &Path, depot: &D) -> Result<String, AssetFault<D::Error>> {
    let mesh = input::load_mesh(path).map_err(AssetFault::File)?;
    let wire = WireMesh::new(&mesh).map_err(|error| AssetFault::Depot(error.into()))?;
    drop(mesh);
    let name = wire.name();
    depot.mesh(wire).await.map_err(AssetFault::Depot)?;
    Ok(name)
}

async fn hand_on_surface<D: Depot>(
    scene: &v1::Scene,
    index: usize,
    path: &Path,
    depot: &D,
) -> Result<String, AssetFault<D::Error>> {
    let wire = input::wire_surface(scene, index, path).map_err(AssetFault::File)?;
    let name = wire.name();
    depot.surface(wire).await.map_err(AssetFault::Depot)?;
    Ok(name)
}
