//! `MeshService`.

use std::future::Future;
use std::sync::Arc;
use std::time::Duration;

use prost::Message as _;
use signorini::mesh::{Mesh, MeshId};
use signorini_proto::v1::{self as wire, mesh_service_server::MeshService, upload_mesh_request};
use tokio::time::Instant;
use tonic::codegen::BoxStream;
use tonic::{Request, Response, Status, Streaming};

use super::{page_size, respond};
use crate::client_key::{ClientIdentity, ClientKey};
use crate::convert::mesh::{self as convert, Header, Upload};
use crate::fault::Fault;
use crate::gates::UploadShare;
use crate::journal::{Change, Journal};
use crate::planning::{self, aside};
use crate::registry::Registry;
use crate::session::Services;
use crate::store::{Lease, Reservation};
use crate::transport;

/// Time that every upload has; one that sends nothing for so long gives its memory back.
const IDLE: Duration = Duration::from_secs(60);

/// An upload slower than this after that time counts as abandoned.
const LEAST_BYTES_PER_SECOND: u64 = 64 << 10;
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

    #[tracing::instrument(skip_all)]
    async fn upload_mesh(
        &self,
        request: Request<Streaming<wire::UploadMeshRequest>>,
    ) -> Result<Response<wire::UploadMeshResponse>, Status> {
        let client = ClientKey::of(&request).identity;
        respond(&self.registry, self.upload(request.into_inner(), client)).await
    }

    #[tracing::instrument(skip_all)]
    async fn get_mesh(
        &self,
        request: Request<wire::GetMeshRequest>,
    ) -> Result<Response<wire::GetMeshResponse>, Status> {
        respond(&self.registry, async {
            let id = convert::id_from_name(&request.into_inner().name, "name")?;
            let mesh = Some(self.describe(planning::mesh(&self.services, id).await?)?);
            Ok(wire::GetMeshResponse { mesh })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn list_meshes(
        &self,
        request: Request<wire::ListMeshesRequest>,
    ) -> Result<Response<wire::ListMeshesResponse>, Status> {
        respond(&self.registry, self.list(request.into_inner())).await
    }

    #[tracing::instrument(skip_all)]
    async fn read_mesh(
        &self,
        request: Request<wire::ReadMeshRequest>,
    ) -> Result<Response<Self::ReadMeshStream>, Status> {
        respond(&self.registry, async {
            let request = request.into_inner();
            let id = convert::id_from_name(&request.name, "name")?;
            let wanted = convert::wanted(&request.arrays)?;
            let messages = convert::messages(planning::mesh(&self.services, id).await?, &wanted);
            let stream: Self::ReadMeshStream = Box::pin(tokio_stream::iter(messages.map(Ok)));
            Ok(stream)
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn delete_mesh(
        &self,
        request: Request<wire::DeleteMeshRequest>,
    ) -> Result<Response<wire::DeleteMeshResponse>, Status> {
        respond(&self.registry, async {
            let id = convert::id_from_name(&request.into_inner().name, "name")?;
            self.delete(id).await?;
            Ok(wire::DeleteMeshResponse {})
        })
        .await
    }
}

impl Meshes {
    async fn upload(
        &self,
        mut inbound: Streaming<wire::UploadMeshRequest>,
        client: ClientIdentity,
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
            && let Ok(found) = planning::mesh(&self.services, id).await
        {
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
        let mesh = aside(move || build(upload, id, journal.as_deref())).await??;
        if let Ok(found) = planning::mesh(&self.services, mesh.id()).await {
            return self.uploaded(found, Presence::Before);
        }
        let _excess = self.reserve_excess(&mesh, taken.bytes())?;
        // On disk before anybody finds it.
        if let Some(journal) = &self.services.journal {
            planning::store_mesh(journal, &mesh).await?;
        }
        self.uploaded(self.services.store.insert_mesh(mesh), Presence::New)
    }

    /// Drops a mesh that no session uses, awake or not, from memory and disk.
    async fn delete(&self, id: MeshId) -> Result<(), Fault> {
        let name = convert::name(id);
        let sessions = self.registry.asleep_on(&name);
        if sessions > 0 {
            return Err(Fault::MeshInUse { name, sessions });
        }
        drop(planning::mesh(&self.services, id).await?);
        self.services.store.delete_mesh(id)?;
        let Some(journal) = self.services.journal.clone() else {
            return Ok(());
        };
        let dropped = journal.store("", vec![Change::DropMesh(name)]).await;
        dropped.map_err(planning::unwritable)?;
        let drop = move || journal.drop_mesh(id);
        aside(drop).await?.map_err(planning::unwritable)
    }

    /// Takes what a mesh needs beyond its prediction, if anything.
    fn reserve_excess(&self, mesh: &Mesh, taken: u64) -> Result<Option<Reservation>, Fault> {
        match mesh.bytes().saturating_sub(taken) {
            0 => Ok(None),
            excess => self.services.store.reserve(excess).map(Some),
        }
    }

    fn uploaded(
        &self,
        mesh: Lease<Mesh>,
        presence: Presence,
    ) -> Result<wire::UploadMeshResponse, Fault> {
        Ok(wire::UploadMeshResponse {
            mesh: Some(self.describe(mesh)?),
            already_present: presence == Presence::Before,
        })
    }

    /// Takes the lease, which would count as a session otherwise.
    fn describe(&self, lease: Lease<Mesh>) -> Result<wire::StoredMesh, Fault> {
        let mesh = Arc::clone(lease.value());
        drop(lease);
        Ok(convert::mesh(
            &mesh,
            &self.services.store.mesh_use(mesh.id())?,
        ))
    }

    async fn list(
        &self,
        request: wire::ListMeshesRequest,
    ) -> Result<wire::ListMeshesResponse, Fault> {
        let size = page_size(request.page_size)?;
        let after = match request.page_token.as_str() {
            "" => None,
            token => Some(convert::id_from_name(token, "page_token")?),
        };
        let found = self.services.store.meshes(after, size);
        let found: Vec<_> = found
            .iter()
            .map(|(mesh, uses)| convert::mesh(mesh, uses))
            .collect();
        let found = self.with_stored(found, (&request.page_token, size)).await?;
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
    ) -> Result<Vec<wire::StoredMesh>, Fault> {
        let Some(journal) = self.services.journal.clone() else {
            return Ok(found);
        };
        let stored = aside(move || journal.meshes()).await?;
        for (name, mesh) in stored.map_err(planning::unwritable)? {
            let is_new = name.as_str() > after && found.iter().all(|one| one.name != name);
            if let (true, Ok(mesh)) = (is_new, wire::StoredMesh::decode(mesh.described)) {
                found.push(mesh);
            }
        }
        found.sort_unstable_by(|one, other| one.name.cmp(&other.name));
        found.truncate(size);
        Ok(found)
    }
}

/// Whether an uploaded mesh was stored before.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Presence {
    Before,
    New,
}

/// What an upload has taken of the budget: as much as its chunks that have come are of
/// all, held until the mesh itself is counted.
struct Taken {
    reservation: Reservation,
    share: UploadShare,
    begun: Instant,
    received: u64,
    /// Of the arrays on the wire, and of the upload with the mesh made of it.
    announced: u64,
    predicted: u64,
}

impl Taken {
    fn new(services: &Services, client: ClientIdentity) -> Result<Self, Fault> {
        Ok(Self {
            reservation: services.store.reserve(0)?,
            share: services.gates.uploads.begin(client),
            begun: Instant::now(),
            received: 0,
            announced: 0,
            predicted: 0,
        })
    }

    /// Refuses at once what can never fit.
    fn expect(&mut self, header: &Header) -> Result<(), Fault> {
        (self.announced, self.predicted) = (header.array_bytes(), header.predicted_bytes());
        self.take(self.predicted)?;
        self.take(0)
    }

    fn take(&mut self, bytes: u64) -> Result<(), Fault> {
        self.share.grow(bytes)?;
        self.reservation.claim(bytes)
    }

    /// Takes the part of a chunk before it is stored.
    fn grow(&mut self, bytes: u64) -> Result<(), Fault> {
        self.received = self.received.saturating_add(bytes);
        let part = u128::from(self.predicted) * u128::from(self.received);
        let part = part / u128::from(self.announced.max(1));
        // More than was announced is refused where it is stored.
        let part = u64::try_from(part).unwrap_or(u64::MAX).min(self.predicted);
        self.take(part)
    }

    /// When the upload has become too slow: it has a minute, and more for what has come.
    fn end(&self) -> Instant {
        self.begun + IDLE + Duration::from_secs(self.received / LEAST_BYTES_PER_SECOND)
    }

    fn bytes(&self) -> u64 {
        self.reservation.bytes()
    }
}

async fn next(
    inbound: &mut Streaming<wire::UploadMeshRequest>,
    end: Instant,
) -> Result<Option<upload_mesh_request::Part>, Fault> {
    let broken = |status: Status| {
        transport::fault_of_stream(&status)
            .unwrap_or_else(|| Fault::request("upload", status.message()))
    };
    match by(end, inbound.message()).await?.map_err(broken)? {
        None => Ok(None),
        Some(message) => message.part.map(Some).ok_or_else(|| {
            Fault::unsupported("upload", "a message that this version does not know")
        }),
    }
}

/// The outcome of `arrival`, if it comes before an upload counts as abandoned.
async fn by<T>(end: Instant, arrival: impl Future<Output = T>) -> Result<T, Fault> {
    let arrived = tokio::time::timeout_at(end, arrival).await;
    arrived.map_err(|_| {
        let text = format!(
            "came slower than {LEAST_BYTES_PER_SECOND} bytes a second after its first {} seconds",
            IDLE.as_secs()
        );
        Fault::request("upload", text)
    })
}

/// The mesh of an upload, its file on the disk where there is a data folder.
fn build(
    upload: Upload,
    declared: Option<MeshId>,
    journal: Option<&Journal>,
) -> Result<Mesh, Fault> {
    let invalid = |error: signorini::MeshError| Fault::MeshInvalid(error.to_string());
    let (parts, offsets) = upload.finish()?;
    let write =
        |journal: &Journal| journal.write_part(|put| convert::to_file(&parts, &offsets, put));
    let part = journal.map(write).transpose();
    let part = part.map_err(planning::unwritable)?;
    let mesh = Mesh::second_order(parts, offsets).map_err(invalid)?;
    if let Some(declared) = declared.filter(|declared| *declared != mesh.id()) {
        return Err(Fault::DigestMismatch {
            declared: declared.to_string(),
            computed: mesh.id().to_string(),
        });
    }
    if let (Some(journal), Some(part)) = (journal, part) {
        let kept = journal.keep_mesh(part, mesh.id());
        kept.map_err(planning::unwritable)?;
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_upload_that_goes_silent_ends_with_a_reason() {
        let silent = std::future::pending::<()>();
        let fault = by(Instant::now(), silent).await.unwrap_err();
        assert!(matches!(fault, Fault::RequestInvalid(_)), "{fault}");
    }
}
