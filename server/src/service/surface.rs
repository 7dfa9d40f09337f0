//! `SurfaceService`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use signorini_proto::v1::{
    self as wire, surface_service_server::SurfaceService, upload_surface_request,
};
use tonic::codegen::BoxStream;
use tonic::{Request, Response, Status, Streaming};

use super::paced::paced;
use super::respond;
use crate::convert::surface::{self as convert, Upload};
use crate::convert::uploaded::Surface;
use crate::door::access::{Caller, Owners};
use crate::door::client_key::ClientKey;
use crate::door::transport;
use crate::fault::Fault;
use crate::journal::{Journal, Part};
use crate::registry::Registry;
use crate::registry::planning::tools::{self, Arrived};
use crate::registry::planning::{aside, unwritable};
use crate::session::Services;
use crate::uploads::store::Account;
use crate::uploads::surfaces::{MOST, Stored};
use upload_surface_request::Part as Sent;

/// An upload that sends nothing for so long gives its memory back.
const IDLE: Duration = Duration::from_secs(60);
/// An upload that takes longer counts as abandoned.
const LONGEST: Duration = Duration::from_secs(600);

/// The service.
pub(crate) struct SurfaceDoor {
    pub(crate) services: Arc<Services>,
    pub(crate) registry: Arc<Registry>,
}

#[tonic::async_trait]
impl SurfaceService for SurfaceDoor {
    type ReadSurfaceStream = BoxStream<wire::ReadSurfaceResponse>;

    #[tracing::instrument(skip_all)]
    async fn upload_surface(
        &self,
        request: Request<Streaming<wire::UploadSurfaceRequest>>,
    ) -> Result<Response<wire::UploadSurfaceResponse>, Status> {
        let caller = Caller::of(&request);
        let account = self.services.account(ClientKey::of(&request).identity);
        let upload = self.upload(request.into_inner(), (&caller, account));
        respond(&self.registry, upload).await
    }

    #[tracing::instrument(skip_all)]
    async fn get_surface(
        &self,
        request: Request<wire::GetSurfaceRequest>,
    ) -> Result<Response<wire::GetSurfaceResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let digest = convert::digest_of(&request.into_inner().name, "name")?;
            let surface = Some(tools::described(&self.services, &digest, &caller).await?);
            Ok(wire::GetSurfaceResponse { surface })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn list_surfaces(
        &self,
        request: Request<wire::ListSurfacesRequest>,
    ) -> Result<Response<wire::ListSurfacesResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let surfaces = tools::list(&self.services, &caller).await?;
            Ok(wire::ListSurfacesResponse { surfaces })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn read_surface(
        &self,
        request: Request<wire::ReadSurfaceRequest>,
    ) -> Result<Response<Self::ReadSurfaceStream>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let digest = convert::digest_of(&request.into_inner().name, "name")?;
            tools::check(&self.services, &digest, &caller).await?;
            match tools::surface(&self.services, &digest).await?.surface {
                Surface::Triangulated(surface) => Ok(paced(convert::messages(surface, digest))),
                Surface::Heights(_) | Surface::Distances(_) => {
                    let text = "names a grid: triangulations alone are sent back";
                    Err(Fault::unsupported("name", text))
                }
            }
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn delete_surface(
        &self,
        request: Request<wire::DeleteSurfaceRequest>,
    ) -> Result<Response<wire::DeleteSurfaceResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let digest = convert::digest_of(&name, "name")?;
            caller.note(&name);
            self.delete(&digest, &caller).await?;
            Ok(wire::DeleteSurfaceResponse {})
        })
        .await
    }
}

impl SurfaceDoor {
    async fn upload(
        &self,
        mut inbound: Streaming<wire::UploadSurfaceRequest>,
        (caller, account): (&Caller, Account),
    ) -> Result<wire::UploadSurfaceResponse, Fault> {
        self.registry.check_open()?;
        let Some(Sent::Header(header)) = next(&mut inbound).await? else {
            return Err(Fault::request("header", "must be the first message"));
        };
        let mut upload = Upload::new(header)?;
        if let Some(digest) = &upload.digest
            && let Ok(found) = tools::described(&self.services, digest, caller).await
            // One whose file is damaged is mended by what comes.
            && tools::surface(&self.services, digest).await.is_ok()
        {
            caller.note(&found.name);
            return Ok(answer(found, true));
        }
        let predicted = (account, upload.predicted_bytes());
        let surfaces = &self.services.surfaces;
        let reserved = surfaces.reserve(&self.services.store, predicted)?;
        let end = Instant::now() + LONGEST;
        while let Some(part) = next(&mut inbound).await? {
            if Instant::now() > end {
                let text = format!("took longer than {} seconds", LONGEST.as_secs());
                return Err(Fault::request("upload", text));
            }
            match part {
                Sent::Chunk(chunk) => upload.push(&chunk)?,
                Sent::Header(_) => {
                    return Err(Fault::request("header", "must be the first message only"));
                }
            }
        }
        let journal = self.services.journal.clone();
        let (digest, surface, part) = aside(move || build(upload, journal.as_deref())).await??;
        caller.note(&convert::name(&digest));
        let _turn = surfaces.turn().await;
        let (described, mut owners) = match tools::known(&self.services, &digest).await? {
            Some((described, owners)) => (Some(described), owners),
            None => (None, Owners::of(caller)),
        };
        // Nothing new for one whose it is.
        let _new = owners.join(caller);
        let stored = Stored {
            surface,
            created: tools::created(described.as_ref()),
        };
        let arrived = Arrived {
            digest: digest.clone(),
            part,
            stored,
            owners,
            reserved,
        };
        let stored = tools::keep(&self.services, arrived).await?;
        self.make_place().await?;
        let surface = convert::surface(&digest, &stored.surface, stored.created);
        Ok(answer(surface, false))
    }

    /// Drops a surface that no session uses, awake or not; for a client alone where others
    /// have sent it too.
    async fn delete(&self, digest: &str, caller: &Caller) -> Result<(), Fault> {
        let _turn = self.services.surfaces.turn().await;
        let known = tools::known(&self.services, digest).await?;
        let known = known.filter(|(_, owners)| owners.admit(caller));
        let (described, mut owners) =
            known.ok_or_else(|| Fault::SurfaceNotFound(convert::name(digest)))?;
        if owners.leave(caller) {
            tools::enter(&self.services, &described, &owners).await?;
            self.services.surfaces.give(digest, owners);
            return Ok(());
        }
        match self.registry.asleep_with(&described.name) {
            0 => tools::drop_surface(&self.services, digest).await,
            _ => Err(Fault::SurfaceInUse(described.name)),
        }
    }

    /// Drops the oldest of the data folder that no session uses where there are too many.
    async fn make_place(&self) -> Result<(), Fault> {
        let mut stored = tools::stored(&self.services).await?;
        let mut beyond = stored.len().saturating_sub(MOST);
        stored.sort_by_key(age);
        // The newest is the one that came just now.
        stored.pop();
        for one in stored {
            if beyond == 0 {
                break;
            }
            if self.registry.asleep_with(&one.name) > 0 {
                continue;
            }
            match tools::drop_surface(&self.services, &one.digest).await {
                Err(Fault::SurfaceInUse(_)) => {}
                outcome => outcome.map(|()| beyond -= 1)?,
            }
        }
        Ok(())
    }
}

/// Orders surfaces by when they came.
fn age(surface: &wire::StoredSurface) -> (i64, i32) {
    let time = surface.create_time.unwrap_or_default();
    (time.seconds, time.nanos)
}

/// The surface of an upload with its digest, and its file on the disk, which has no name yet.
fn build(
    upload: Upload,
    journal: Option<&Journal>,
) -> Result<(String, Surface, Option<Part>), Fault> {
    let whole = upload.finish()?;
    let write = |journal: &Journal| journal.write_surface(|put| convert::to_file(&whole, put));
    let part = journal.map(write).transpose();
    let part = part.map_err(unwritable)?;
    let digest = whole.digest.clone();
    Ok((digest, whole.surface()?, part))
}

fn answer(surface: wire::StoredSurface, already_present: bool) -> wire::UploadSurfaceResponse {
    wire::UploadSurfaceResponse {
        surface: Some(surface),
        already_present,
    }
}

async fn next(inbound: &mut Streaming<wire::UploadSurfaceRequest>) -> Result<Option<Sent>, Fault> {
    let broken = |status: Status| {
        transport::fault_of_stream(&status)
            .unwrap_or_else(|| Fault::request("upload", status.message()))
    };
    let silent = |_| {
        let text = format!("nothing came for {} seconds", IDLE.as_secs());
        Fault::request("upload", text)
    };
    let arrived = tokio::time::timeout(IDLE, inbound.message()).await;
    match arrived.map_err(silent)?.map_err(broken)? {
        None => Ok(None),
        Some(message) => message.part.map(Some).ok_or_else(|| {
            Fault::unsupported("upload", "a message that this version does not know")
        }),
    }
}
