//! Meshes and surfaces in the object store: the messages of their upload, each after its
//! length, under the name of the digest.

use std::io::Cursor;

use async_nats::jetstream::object_store::{InfoErrorKind, ObjectStore};
use bytes::Bytes;
use prost::Message;
use signorini_client::{Client, ClientError, WireMesh, WireSurface};
use signorini_proto::v1;
use tokio::io::AsyncReadExt as _;

use super::{Queue, broken};
use crate::studies::assets::Depot;
use crate::terminal::exit::Failure;

/// Bytes of an object that a worker takes.
const MOST_BYTES: u64 = 16 << 30;

impl Depot for Queue {
    type Error = Failure;

    async fn mesh(&self, mesh: WireMesh) -> Result<(), Failure> {
        put(&self.assets, mesh.name(), mesh.requests()).await
    }

    async fn surface(&self, surface: WireSurface) -> Result<(), Failure> {
        put(&self.assets, surface.name(), surface.requests()).await
    }
}

async fn put<M: Message>(
    store: &ObjectStore,
    name: String,
    messages: impl Iterator<Item = M> + Send,
) -> Result<(), Failure> {
    match store.info(&name).await {
        Ok(_) => return Ok(()),
        Err(error) if error.kind() == InfoErrorKind::NotFound => {}
        Err(error) => return Err(broken(error)),
    }
    let parts = messages.map(|message| message.encode_length_delimited_to_vec());
    let bytes: Vec<u8> = parts.flatten().collect();
    let put = store.put(name.as_str(), &mut Cursor::new(bytes)).await;
    put.map(|_| ()).map_err(broken)
}

/// Why a worker's server does not have what a case names.
pub(super) enum Fault {
    /// The object store does not give it.
    Store,
    /// The server does not take it.
    Server(ClientError),
}

/// Gives a server all that a scene names.
pub(super) async fn supply(queue: &Queue, client: &Client, scene: &v1::Scene) -> Result<(), Fault> {
    let bytes = get(&queue.assets, &scene.mesh)
        .await
        .map_err(|_| Fault::Store)?;
    let uploaded = client.upload_mesh_messages(messages(bytes)).await;
    uploaded.map_err(Fault::Server)?;
    for name in surfaces(scene) {
        let bytes = get(&queue.assets, name).await.map_err(|_| Fault::Store)?;
        let uploaded = client.upload_surface_messages(messages(bytes)).await;
        uploaded.map_err(Fault::Server)?;
    }
    Ok(())
}

/// Names of the surfaces of a scene.
fn surfaces(scene: &v1::Scene) -> impl Iterator<Item = &str> {
    let shapes = scene.obstacles.iter().filter_map(|one| one.shape.as_ref());
    let kinds = shapes.filter_map(|shape| shape.kind.as_ref());
    kinds.filter_map(signorini_client::scene_file::surface_name)
}

async fn get(store: &ObjectStore, name: &str) -> Result<Bytes, Failure> {
    let mut object = store.get(name).await.map_err(broken)?;
    let size = object.info().size as u64;
    if size > MOST_BYTES {
        return Err(broken(format!("{name} has {size} bytes")));
    }
    let mut bytes = Vec::new();
    object.read_to_end(&mut bytes).await.map_err(broken)?;
    Ok(bytes.into())
}

/// Messages after their lengths, up to the first that is none: the server sees what is
/// missing.
fn messages<M: Message + Default>(mut bytes: Bytes) -> impl Iterator<Item = M> {
    std::iter::from_fn(move || {
        if bytes.is_empty() {
            None
        } else {
            M::decode_length_delimited(&mut bytes).ok()
        }
    })
}
