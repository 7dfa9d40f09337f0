//! `SurfaceService`.

use std::sync::Arc;
use std::time::{Duration, Instant};

use signorini_proto::v1::{
    self as wire, surface_service_server::SurfaceService, upload_surface_request::Part,
};
use tonic::{Request, Response, Status, Streaming};

use super::respond;
use crate::access::Caller;
use crate::client_key::ClientKey;
use crate::convert::surface::{self as convert, Upload};
use crate::fault::Fault;
use crate::planning::aside;
use crate::registry::Registry;
use crate::session::Services;
use crate::store::Account;
use crate::surfaces::Stored;
use crate::transport;

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
            let found = self.services.surfaces.get_for(&caller, &digest)?;
            let surface = Some(convert::surface(&digest, &found.surface, found.created));
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
            let all = self.services.surfaces.all(&caller);
            let one = |(digest, stored): &(String, Stored)| {
                convert::surface(digest, &stored.surface, stored.created)
            };
            let surfaces = all.iter().map(one).collect();
            Ok(wire::ListSurfacesResponse { surfaces })
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
            self.services.surfaces.delete(&caller, &digest)?;
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
        let Some(Part::Header(header)) = next(&mut inbound).await? else {
            return Err(Fault::request("header", "must be the first message"));
        };
        let mut upload = Upload::new(header)?;
        let surfaces = &self.services.surfaces;
        if let Some(digest) = &upload.digest
            && let Ok(found) = surfaces.get_for(caller, digest)
        {
            caller.note(&convert::name(digest));
            return Ok(answer(digest, &found, true));
        }
        let predicted = (account, upload.predicted_bytes());
        let reserved = surfaces.reserve(&self.services.store, predicted)?;
        let end = Instant::now() + LONGEST;
        while let Some(part) = next(&mut inbound).await? {
            if Instant::now() > end {
                let text = format!("took longer than {} seconds", LONGEST.as_secs());
                return Err(Fault::request("upload", text));
            }
            match part {
                Part::Chunk(chunk) => upload.push(&chunk)?,
                Part::Header(_) => {
                    return Err(Fault::request("header", "must be the first message only"));
                }
            }
        }
        let (digest, surface) = aside(move || upload.finish()).await??;
        caller.note(&convert::name(&digest));
        let stored = surfaces.insert(caller, digest.clone(), surface, reserved);
        Ok(answer(&digest, &stored, false))
    }
}

fn answer(digest: &str, stored: &Stored, already_present: bool) -> wire::UploadSurfaceResponse {
    wire::UploadSurfaceResponse {
        surface: Some(convert::surface(digest, &stored.surface, stored.created)),
        already_present,
    }
}

async fn next(inbound: &mut Streaming<wire::UploadSurfaceRequest>) -> Result<Option<Part>, Fault> {
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
