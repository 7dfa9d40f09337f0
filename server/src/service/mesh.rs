//! `MeshService`.

mod taken;

use std::sync::Arc;

use prost::Message as _;
use signorini::mesh::{Mesh, MeshId};
use signorini_proto::v1::{self as wire, mesh_service_server::MeshService, upload_mesh_request};
use tokio_stream::wrappers::ReceiverStream;
use tonic::codegen::BoxStream;
use tonic::{Request, Response, Status, Streaming};

use super::paced::paced;
use super::{page_size, respond, streams};
use crate::convert::mesh::{self as convert, Header, Upload};
use crate::door::access::{Caller, Owners};
use crate::door::client_key::{ClientIdentity, ClientKey};
use crate::fault::Fault;
use crate::journal::Change;
use crate::registry::Registry;
use crate::registry::planning::meshes::{self, Presence};
use crate::registry::planning::{self, aside};
use crate::registry::refining::Asker;
use crate::session::Services;
use crate::uploads::store::Lease;
use taken::{Taken, next};

/// Encoded size that ends a page of meshes.
const PAGE_BYTES: usize = 1 << 20;

/// The service.
pub(crate) struct Meshes {
    pub(crate) services: Arc<Services>,
    pub(crate) registry: Arc<Registry>,
}

#[tonic::async_trait]
impl MeshService for Meshes {
    type ReadMeshStream = BoxStream<wire::ReadMeshResponse>;
    type RefineMeshStream = ReceiverStream<Result<wire::RefineMeshResponse, Status>>;

    #[tracing::instrument(skip_all)]
    async fn upload_mesh(
        &self,
        request: Request<Streaming<wire::UploadMeshRequest>>,
    ) -> Result<Response<wire::UploadMeshResponse>, Status> {
        let call = (Caller::of(&request), ClientKey::of(&request).identity);
        respond(&self.registry, self.upload(request.into_inner(), call)).await
    }

    #[tracing::instrument(skip_all)]
    async fn get_mesh(
        &self,
        request: Request<wire::GetMeshRequest>,
    ) -> Result<Response<wire::GetMeshResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let id = convert::id_from_name(&request.into_inner().name, "name")?;
            let found = planning::mesh_for(&self.services, id, &caller).await?;
            let mesh = Some(meshes::describe(&self.services, found)?);
            Ok(wire::GetMeshResponse { mesh })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn list_meshes(
        &self,
        request: Request<wire::ListMeshesRequest>,
    ) -> Result<Response<wire::ListMeshesResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, self.list(request.into_inner(), &caller)).await
    }

    #[tracing::instrument(skip_all)]
    async fn read_mesh(
        &self,
        request: Request<wire::ReadMeshRequest>,
    ) -> Result<Response<Self::ReadMeshStream>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let request = request.into_inner();
            let id = convert::id_from_name(&request.name, "name")?;
            let wanted = convert::wanted(&request.arrays)?;
            let found = planning::mesh_for(&self.services, id, &caller).await?;
            Ok(paced(convert::messages(found, &wanted)))
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn delete_mesh(
        &self,
        request: Request<wire::DeleteMeshRequest>,
    ) -> Result<Response<wire::DeleteMeshResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let id = convert::id_from_name(&name, "name")?;
            caller.note(&name);
            self.delete(id, &caller).await?;
            Ok(wire::DeleteMeshResponse {})
        })
        .await
    }

    async fn refine_mesh(
        &self,
        request: Request<wire::RefineMeshRequest>,
    ) -> Result<Response<Self::RefineMeshStream>, Status> {
        let asker = Asker {
            caller: Caller::of(&request),
            client: ClientKey::of(&request),
        };
        let request = request.into_inner();
        let told = streams::open_refine(&self.registry, &self.services, request, asker);
        Ok(Response::new(ReceiverStream::new(told)))
    }
}

impl Meshes {
    async fn upload(
        &self,
        mut inbound: Streaming<wire::UploadMeshRequest>,
        (caller, client): (Caller, ClientIdentity),
    ) -> Result<wire::UploadMeshResponse, Fault> {
        use upload_mesh_request::Part;
        self.registry.check_open()?;
        let mut taken = Taken::new(&self.services, client)?;
        let Some(Part::Header(header)) = next(&mut inbound, taken.end()).await? else {
            return Err(Fault::request("header", "must be the first message"));
        };
        let header = Header::new(header)?;
        let id = header.id;
        if let Some(id) = id
            && let Ok(found) = planning::mesh_for(&self.services, id, &caller).await
        {
            caller.note(&convert::name(id));
            return self.uploaded(found, Presence::Before);
        }
        taken.expect(&header)?;
        let mut upload = Upload::new(header);
        while let Some(part) = next(&mut inbound, taken.end()).await? {
            match part {
                Part::Chunk(chunk) => {
                    taken.grow(chunk.data.len() as u64)?;
                    upload.push(&chunk)?;
                }
                Part::Header(_) => {
                    return Err(Fault::request("header", "must be the first message only"));
                }
            }
        }
        let journal = self.services.journal.clone();
        let mesh = aside(move || {
            let arrays = upload.finish()?;
            meshes::made(arrays, id, journal.as_deref())
        });
        let mesh = mesh.await??;
        caller.note(&convert::name(mesh.id()));
        let kept = meshes::keep(&self.services, mesh, (&caller, taken.bytes())).await?;
        self.uploaded(kept.0, kept.1)
    }

    /// Drops a mesh that no session uses, awake or not, from memory and disk; for a client
    /// alone where others have sent it too.
    async fn delete(&self, id: MeshId, caller: &Caller) -> Result<(), Fault> {
        let found = planning::mesh_for(&self.services, id, caller).await?;
        if let Some(others) = self.services.store.leave(id, caller) {
            return match &self.services.journal {
                Some(journal) => planning::store_mesh(journal, found.value(), &others).await,
                None => Ok(()),
            };
        }
        drop(found);
        let name = convert::name(id);
        let sessions = self.registry.asleep_on(&name);
        if sessions > 0 {
            return Err(Fault::MeshInUse { name, sessions });
        }
        self.services.store.delete_mesh(id)?;
        let Some(journal) = self.services.journal.clone() else {
            return Ok(());
        };
        let dropped = journal.store("", vec![Change::DropMesh(name)]).await;
        dropped.map_err(planning::unwritable)?;
        let drop = move || journal.drop_mesh(id);
        aside(drop).await?.map_err(planning::unwritable)
    }

    fn uploaded(
        &self,
        mesh: Lease<Mesh>,
        presence: Presence,
    ) -> Result<wire::UploadMeshResponse, Fault> {
        Ok(wire::UploadMeshResponse {
            mesh: Some(meshes::describe(&self.services, mesh)?),
            already_present: presence == Presence::Before,
        })
    }

    async fn list(
        &self,
        request: wire::ListMeshesRequest,
        caller: &Caller,
    ) -> Result<wire::ListMeshesResponse, Fault> {
        let size = page_size(request.page_size)?;
        let after = match request.page_token.as_str() {
            "" => None,
            token => Some(convert::id_from_name(token, "page_token")?),
        };
        let found = self.services.store.meshes(caller, after, size);
        let found: Vec<_> = found
            .iter()
            .map(|(mesh, uses)| convert::mesh(mesh, uses))
            .collect();
        let page = (request.page_token.as_str(), size);
        let found = self.with_stored(found, page, caller).await?;
        let (mut meshes, mut bytes) = (Vec::new(), 0);
        for mesh in found.iter().cloned() {
            bytes += mesh.encoded_len();
            meshes.push(mesh);
            if bytes > PAGE_BYTES {
                break;
            }
        }
        let more = meshes.len() == size || meshes.len() < found.len();
        let last = meshes.last().filter(|_| more).map(|mesh| mesh.name.clone());
        Ok(wire::ListMeshesResponse {
            meshes,
            next_page_token: last.unwrap_or_default(),
        })
    }

    /// Meshes in memory with those that only the data folder has, in order of their names.
    async fn with_stored(
        &self,
        mut found: Vec<wire::StoredMesh>,
        (after, size): (&str, usize),
        caller: &Caller,
    ) -> Result<Vec<wire::StoredMesh>, Fault> {
        let Some(journal) = self.services.journal.clone() else {
            return Ok(found);
        };
        let stored = aside(move || journal.meshes()).await?;
        for (name, mesh) in stored.map_err(planning::unwritable)? {
            let is_new = name.as_str() > after && found.iter().all(|one| one.name != name);
            let owners = Owners::from_stored(&mesh.owners);
            let is_shown = is_new && owners.is_ok_and(|owners| owners.admit(caller));
            if let (true, Ok(mesh)) = (is_shown, wire::StoredMesh::decode(mesh.described)) {
                found.push(mesh);
            }
        }
        found.sort_unstable_by(|one, other| one.name.cmp(&other.name));
        found.truncate(size);
        Ok(found)
    }
}
