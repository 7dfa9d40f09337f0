//! Meshes and surfaces that cases name: read once, handed on once, named by digest.

use std::collections::HashMap;
use std::future::Future;
use std::path::{Path, PathBuf};

use signorini_client::scene_file::SceneFile;
use signorini_client::{Client, ClientError, WireMesh, WireSurface};
use signorini_proto::v1;
use signorini_proto::v1::shape::Kind;
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

/// A file, and the bits of the tolerance with which its corners are one vertex.
type Asset = (PathBuf, Option<u64>);

/// Names of files that were handed on.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    names: Mutex<HashMap<Asset, String>>,
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
        let mesh = (mesh_key(&file), None);
        let known = names.get(&mesh).cloned();
        let name = match known {
            Some(name) => name,
            None => {
                let name = hand_on_mesh(&file, depot).await?;
                names.insert(mesh, name.clone());
                name
            }
        };
        let mut scene = file.scene;
        scene.mesh = name;
        for (index, path) in file.surfaces {
            let asset = (path, weld(&scene, index).map(f64::to_bits));
            let known = names.get(&asset).cloned();
            let name = match known {
                Some(name) => name,
                None => hand_on_surface(&scene, index, &asset.0, depot).await?,
            };
            input::name_surface(&mut scene, index, name.clone());
            names.insert(asset, name);
        }
        Ok(scene)
    }
}

/// The tolerance of the surface of an obstacle, where it has one.
fn weld(scene: &v1::Scene, obstacle: usize) -> Option<f64> {
    let shape = scene.obstacles.get(obstacle)?.shape.as_ref()?;
    match &shape.kind {
        Some(Kind::Surface(surface)) => surface.weld,
        _ => None,
    }
}

/// What tells a mesh from others: its file, or those of the bodies with their places.
fn mesh_key(file: &SceneFile) -> PathBuf {
    if file.bodies.is_empty() {
        file.mesh.clone()
    } else {
        PathBuf::from(format!("{:?}", file.bodies))
    }
}

async fn hand_on_mesh<D: Depot>(
    file: &SceneFile,
    depot: &D,
) -> Result<String, AssetFault<D::Error>> {
    let mesh = input::whole_mesh(file).map_err(AssetFault::File)?;
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
