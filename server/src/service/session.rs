//! `SessionService`.

use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use prost::Message;
use signorini::plan::Plan;
use signorini::prepare::Prepared;
use signorini_proto::v1::{self as wire, session_service_server::SessionService};
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};
use tonic::{Request, Response, Status, Streaming};

use super::{aside, page_size, respond, timeout};
use crate::client_key::ClientKey;
use crate::convert::field::{self, Encoding};
use crate::convert::scene::SceneRequest;
use crate::convert::surface::SurfacesByName;
use crate::convert::{report, scene, step, surface};
use crate::fault::Fault;
use crate::registry::{Claimed, Registry};
use crate::results::kept::messages;
use crate::session::{Handle, ReadRequest, Services, SessionSpec};
use crate::store::{Lease, Reservation};
use crate::streams;

const MAXIMUM_REQUEST_ID_BYTES: usize = 64;
const MAXIMUM_SCENE_BYTES: usize = 3 << 20;
/// Memory of a decoded message over its encoded size, about.
const OWN_FACTOR: u64 = 4;

type Messages<T> = Pin<Box<dyn Stream<Item = Result<T, Status>> + Send>>;

/// The service.
pub(crate) struct Sessions {
    pub(crate) services: Arc<Services>,
    pub(crate) registry: Arc<Registry>,
}

#[tonic::async_trait]
impl SessionService for Sessions {
    type SolveStream = ReceiverStream<Result<wire::SolveResponse, Status>>;
    type WatchStream = ReceiverStream<Result<wire::WatchResponse, Status>>;
    type ReadStepStream = Messages<wire::ReadStepResponse>;
    type ExportStateStream = Messages<wire::ExportStateResponse>;

    #[tracing::instrument(skip_all)]
    async fn create_session(
        &self,
        request: Request<wire::CreateSessionRequest>,
    ) -> Result<Response<wire::CreateSessionResponse>, Status> {
        let client = ClientKey::of(&request);
        respond(&self.registry, self.create(request.into_inner(), client)).await
    }

    #[tracing::instrument(skip_all)]
    async fn get_session(
        &self,
        request: Request<wire::GetSessionRequest>,
    ) -> Result<Response<wire::GetSessionResponse>, Status> {
        respond(&self.registry, async {
            let handle = self.registry.get(&request.into_inner().name)?;
            let mut session = handle.describe().await?;
            session.scene = Some(handle.scene());
            let session = Some(session);
            Ok(wire::GetSessionResponse { session })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn list_sessions(
        &self,
        request: Request<wire::ListSessionsRequest>,
    ) -> Result<Response<wire::ListSessionsResponse>, Status> {
        respond(&self.registry, self.list(request.into_inner())).await
    }

    #[tracing::instrument(skip_all)]
    async fn delete_session(
        &self,
        request: Request<wire::DeleteSessionRequest>,
    ) -> Result<Response<wire::DeleteSessionResponse>, Status> {
        respond(&self.registry, async {
            let handle = self.registry.get(&request.into_inner().name)?;
            handle.delete().await?;
            handle.ended().await;
            Ok(wire::DeleteSessionResponse {})
        })
        .await
    }

    async fn solve(
        &self,
        request: Request<Streaming<wire::SolveRequest>>,
    ) -> Result<Response<Self::SolveStream>, Status> {
        // Answered before anything is read: a client may wait for the headers.
        let call = streams::Call {
            client: ClientKey::of(&request),
            timeout: timeout::of(request.metadata()),
        };
        let answers = streams::open_solve(&self.registry, request.into_inner(), call);
        Ok(Response::new(ReceiverStream::new(answers)))
    }

    async fn watch(
        &self,
        request: Request<wire::WatchRequest>,
    ) -> Result<Response<Self::WatchStream>, Status> {
        let answers = streams::open_watch(&self.registry, request.into_inner());
        Ok(Response::new(ReceiverStream::new(answers)))
    }

    #[tracing::instrument(skip_all)]
    async fn cancel_step(
        &self,
        request: Request<wire::CancelStepRequest>,
    ) -> Result<Response<wire::CancelStepResponse>, Status> {
        respond(&self.registry, async {
            let request = request.into_inner();
            let handle = self.registry.get(&request.name)?;
            let sequence = handle.cancel(request.sequence).await?;
            Ok(wire::CancelStepResponse { sequence })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn read_step(
        &self,
        request: Request<wire::ReadStepRequest>,
    ) -> Result<Response<Self::ReadStepStream>, Status> {
        respond(&self.registry, self.read(request.into_inner())).await
    }

    async fn export_state(
        &self,
        _request: Request<wire::ExportStateRequest>,
    ) -> Result<Response<Self::ExportStateStream>, Status> {
        respond(&self.registry, async { Err(checkpoints("export_state")) }).await
    }

    async fn import_state(
        &self,
        _request: Request<Streaming<wire::ImportStateRequest>>,
    ) -> Result<Response<wire::ImportStateResponse>, Status> {
        respond(&self.registry, async { Err(checkpoints("import_state")) }).await
    }
}

fn checkpoints(path: &str) -> Fault {
    Fault::unsupported(path, "checkpoints come in a later version")
}

/// Memory taken for a session.
struct Taken {
    reservation: Reservation,
    prepared: Option<Lease<Prepared>>,
}

/// A scene with its mesh and its plan.
struct Planned {
    request: SceneRequest,
    mesh: Lease<signorini::mesh::Mesh>,
    plan: Plan,
}

impl Sessions {
    async fn create(
        &self,
        request: wire::CreateSessionRequest,
        client: ClientKey,
    ) -> Result<wire::CreateSessionResponse, Fault> {
        self.registry.check_open()?;
        check_request(&request)?;
        self.check_queue(client)?;
        let ttl = step::duration(request.ttl.as_ref(), "ttl")?;
        let missing = || Fault::request("scene", "is required");
        let on_disconnect = request.on_disconnect();
        let scene = request.scene.ok_or_else(missing)?;
        if request.validate_only {
            let plan = self.plan(scene, client).await?.plan;
            return Ok(wire::CreateSessionResponse {
                session: None,
                plan: Some(report::plan(plan.report())),
            });
        }
        // Before planning, so that a repeat meanwhile finds this request.
        let claimed = self
            .registry
            .claim(&request.session_id, &request.request_id);
        let claim = match claimed.await? {
            Claimed::Made(handle) => return created(&handle).await,
            Claimed::New(claim) => claim,
        };
        let kept = Arc::new(scene.clone());
        let planned = self.plan(scene, client).await?;
        let plan_report = report::plan(planned.plan.report());
        let own_bytes = OWN_FACTOR * (kept.encoded_len() + plan_report.encoded_len()) as u64;
        let result_bytes = result_bytes(&planned);
        let taken = self.reserve(&planned, own_bytes + result_bytes)?;
        let spec = SessionSpec {
            name: claim.name().to_owned(),
            reservation: Arc::new(Mutex::new(taken.reservation)),
            prepared: taken.prepared,
            own_bytes,
            result_bytes,
            plan: Arc::new(planned.plan),
            plan_report,
            scene: kept,
            client,
            on_disconnect,
            mesh: planned.mesh,
            output: planned.request.output,
            ttl: ttl.unwrap_or_else(|| self.services.config.ttl()),
            created: SystemTime::now(),
        };
        created(&claim.start(spec)).await
    }

    async fn plan(&self, message: wire::Scene, client: ClientKey) -> Result<Planned, Fault> {
        let surfaces = self.surfaces(&message)?;
        let request = scene::scene(message, &surfaces)?;
        let mesh = self.services.store.mesh(request.mesh)?;
        let _turn = self.services.gates.plans.turn(client).await;
        // A plan numbers the mesh and finds its surfaces: about the mesh once more.
        let _memory = self.services.store.reserve(mesh.value().bytes())?;
        let planned = aside(move || {
            let plan = request.plan(mesh.value())?;
            Ok::<_, Fault>(Planned {
                request,
                mesh,
                plan,
            })
        });
        planned.await?
    }

    /// The surfaces that a scene names.
    fn surfaces(&self, scene: &wire::Scene) -> Result<SurfacesByName, Fault> {
        let one = |name: String| {
            let digest = surface::digest_of(&name, "obstacle.shape.surface")?;
            Ok((name, self.services.surfaces.get(&digest)?.surface))
        };
        surface::names(scene).into_iter().map(one).collect()
    }

    /// Refuses a client that has too much waiting already.
    fn check_queue(&self, client: ClientKey) -> Result<(), Fault> {
        let limit = self.services.config.maximum_queued;
        match self.services.solvers.waiting(client) < limit {
            true => Ok(()),
            false => Err(Fault::QueueFull { limit }),
        }
    }

    /// Takes the predicted memory with one result, less what another session has
    /// prepared, and keeps that from being dropped.
    fn reserve(&self, planned: &Planned, beside: u64) -> Result<Taken, Fault> {
        let (store, report) = (&self.services.store, planned.plan.report());
        let prepared = store.hold_prepared(&planned.plan.key());
        let there = prepared.as_ref().map_or(0, |lease| lease.value().bytes());
        let predicted = report.predicted_bytes.saturating_sub(there);
        let reservation = store.reserve(predicted.saturating_add(beside))?;
        Ok(Taken {
            reservation,
            prepared,
        })
    }

    async fn list(
        &self,
        request: wire::ListSessionsRequest,
    ) -> Result<wire::ListSessionsResponse, Fault> {
        let size = page_size(request.page_size)?;
        let found = self.registry.list(&request.page_token, size);
        let last = found
            .last()
            .filter(|_| found.len() == size)
            .map(|(name, _)| name.clone());
        let mut sessions = Vec::with_capacity(found.len());
        for (_, handle) in &found {
            // One that ended meanwhile is left out.
            if let Ok(session) = handle.list().await {
                sessions.push(wire::Session {
                    plan: None,
                    ..session
                });
            }
        }
        let next_page_token = last.unwrap_or_default();
        Ok(wire::ListSessionsResponse {
            sessions,
            next_page_token,
        })
    }

    async fn read(
        &self,
        request: wire::ReadStepRequest,
    ) -> Result<Messages<wire::ReadStepResponse>, Fault> {
        let handle = self.registry.get(&request.name)?;
        let fields = field::names(&request.fields, "fields")?;
        let encoding: Encoding = field::encoding(request.element_type)?;
        let (sequence, increment) = (request.sequence, request.increment);
        let answer = handle
            .read(ReadRequest {
                sequence,
                increment,
            })
            .await?;
        let wanted = match fields.is_empty() {
            true => answer.output,
            false => fields,
        };
        let all = answer.results.into_iter().flat_map(move |result| {
            let (finished, chunks) = messages(&result, &wanted, encoding);
            let first = wire::read_step_response::Message::StepFinished(finished);
            std::iter::once(first).chain(chunks.map(wire::read_step_response::Message::Field))
        });
        let responses = all.map(|message| wire::ReadStepResponse {
            message: Some(message),
        });
        Ok(Box::pin(tokio_stream::iter(responses).map(Ok)))
    }
}

/// About what the fields of one result take, bytes.
fn result_bytes(planned: &Planned) -> u64 {
    let fields = planned.request.output.fields.len() as u64;
    8 * fields * planned.plan.report().unknowns.displacement
}

fn check_request(request: &wire::CreateSessionRequest) -> Result<(), Fault> {
    if !request.from_state.is_empty() {
        return Err(checkpoints("from_state"));
    }
    if request.request_id.len() > MAXIMUM_REQUEST_ID_BYTES {
        return Err(Fault::request("request_id", "is longer than 64 bytes"));
    }
    let bytes = request.scene.as_ref().map_or(0, Message::encoded_len);
    if bytes > MAXIMUM_SCENE_BYTES {
        return Err(Fault::MessageLimit {
            what: format!("scene of {bytes} bytes"),
            limit: MAXIMUM_SCENE_BYTES as u64,
        });
    }
    Ok(())
}

async fn created(handle: &Handle) -> Result<wire::CreateSessionResponse, Fault> {
    let session = handle.describe().await?;
    let plan = session.plan.clone();
    let session = Some(session);
    Ok(wire::CreateSessionResponse { session, plan })
}
