//! `SessionService`.

use std::sync::Arc;
use std::time::SystemTime;

use bytes::Bytes;
use prost::Message;
use signorini::Rounding;
use signorini_proto::v1::{self as wire, session_service_server::SessionService};
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status, Streaming};

use super::paced::{Messages, paced};
use super::{page_size, respond, state, timeout};
use crate::access::{Caller, Who};
use crate::client_key::ClientKey;
use crate::convert::field::{self, Encoding};
use crate::convert::{mesh, report, step, wide};
use crate::fault::Fault;
use crate::journal::{Change, StoredSession};
use crate::planning::{self, Planned};
use crate::registry::{Claim, Claimed, Registry};
use crate::results::kept::messages;
use crate::session::{Handle, ReadRequest, Recovered, Services, SessionSpec};
use crate::states::States;
use crate::streams;

const MAXIMUM_REQUEST_ID_BYTES: usize = 64;
const MAXIMUM_SCENE_BYTES: usize = 3 << 20;

/// The service.
pub(crate) struct Sessions {
    pub(crate) services: Arc<Services>,
    pub(crate) registry: Arc<Registry>,
    pub(crate) states: States,
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
        let call = (Caller::of(&request), ClientKey::of(&request));
        respond(&self.registry, self.create(request.into_inner(), call)).await
    }

    #[tracing::instrument(skip_all)]
    async fn get_session(
        &self,
        request: Request<wire::GetSessionRequest>,
    ) -> Result<Response<wire::GetSessionResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let handle = self.registry.get(&caller, &name).await?;
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
        let caller = Caller::of(&request);
        respond(&self.registry, self.list(request.into_inner(), &caller)).await
    }

    #[tracing::instrument(skip_all)]
    async fn delete_session(
        &self,
        request: Request<wire::DeleteSessionRequest>,
    ) -> Result<Response<wire::DeleteSessionResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let handle = self.registry.get(&caller, &name).await?;
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
            caller: Caller::of(&request),
            client: ClientKey::of(&request),
            who: Who::of(request.extensions()),
            timeout: timeout::of(request.metadata()),
        };
        let answers = streams::open_solve(&self.registry, request.into_inner(), call);
        Ok(Response::new(ReceiverStream::new(answers)))
    }

    async fn watch(
        &self,
        request: Request<wire::WatchRequest>,
    ) -> Result<Response<Self::WatchStream>, Status> {
        let caller = Caller::of(&request);
        let answers = streams::open_watch(&self.registry, request.into_inner(), caller);
        Ok(Response::new(ReceiverStream::new(answers)))
    }

    #[tracing::instrument(skip_all)]
    async fn cancel_step(
        &self,
        request: Request<wire::CancelStepRequest>,
    ) -> Result<Response<wire::CancelStepResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let request = request.into_inner();
            let handle = self.registry.get(&caller, &request.name).await?;
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
        let caller = Caller::of(&request);
        respond(&self.registry, self.read(request.into_inner(), &caller)).await
    }

    #[tracing::instrument(skip_all)]
    async fn export_state(
        &self,
        request: Request<wire::ExportStateRequest>,
    ) -> Result<Response<Self::ExportStateStream>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let handle = self.registry.get(&caller, &name).await?;
            Ok(paced(state::export(handle).await?))
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn save_state(
        &self,
        request: Request<wire::SaveStateRequest>,
    ) -> Result<Response<wire::SaveStateResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let name = request.into_inner().name;
            let handle = self.registry.get(&caller, &name).await?;
            let (save, bytes) = handle.save().await?;
            let memory_bytes = wide(bytes);
            Ok(wire::SaveStateResponse { save, memory_bytes })
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn restore_state(
        &self,
        request: Request<wire::RestoreStateRequest>,
    ) -> Result<Response<wire::RestoreStateResponse>, Status> {
        let caller = Caller::of(&request);
        respond(&self.registry, async {
            let request = request.into_inner();
            let handle = self.registry.get(&caller, &request.name).await?;
            handle.restore(request.save).await?;
            Ok(wire::RestoreStateResponse {})
        })
        .await
    }

    #[tracing::instrument(skip_all)]
    async fn import_state(
        &self,
        request: Request<Streaming<wire::ImportStateRequest>>,
    ) -> Result<Response<wire::ImportStateResponse>, Status> {
        let caller = Caller::of(&request);
        let account = self.services.account(ClientKey::of(&request).identity);
        respond(&self.registry, async {
            self.registry.check_open()?;
            let reservation = self.services.store.reserve_for(account, 0)?;
            let kept = (&self.states, caller.name());
            let inbound = (request.into_inner(), reservation);
            let made = state::import(&self.services, kept, inbound).await?;
            caller.note(&made.state);
            Ok(made)
        })
        .await
    }
}

impl Sessions {
    async fn create(
        &self,
        mut request: wire::CreateSessionRequest,
        (caller, client): (Caller, ClientKey),
    ) -> Result<wire::CreateSessionResponse, Fault> {
        self.registry.check_open()?;
        check_request(&request)?;
        self.check_queue(client)?;
        let ttl = step::duration(request.ttl.as_ref(), "ttl")?;
        let missing = || Fault::request("scene", "is required");
        let on_disconnect = request.on_disconnect();
        let from_state = self.imported_state(&mut request).await?;
        let asked = self
            .services
            .journal
            .as_ref()
            .map(|_| request.encode_to_vec());
        let scene = request.scene.ok_or_else(missing)?;
        planning::check_uploads(&self.services, &scene, &caller).await?;
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
            .claim(&caller, &request.session_id, &request.request_id);
        let claim = match claimed.await? {
            Claimed::Made(handle) => return created(&handle).await,
            Claimed::New(claim) => claim,
        };
        let kept = Arc::new(scene.clone());
        let planned = self.plan(scene, client).await?;
        let plan_report = report::plan(planned.plan.report());
        let own_bytes = planning::own_bytes(&kept, &plan_report);
        let result_bytes = planning::result_bytes(&planned);
        let account = self.services.account(client.identity);
        let taken = planning::reserve(&self.services.store, &planned, (own_bytes, account))?;
        let recovered = from_state.map(|state| start(&planned, state)).transpose()?;
        let asked = asked.map(|request| (request, &caller));
        self.store(&claim, asked, &planned, recovered.as_deref())
            .await?;
        let spec = SessionSpec {
            name: claim.name().to_owned(),
            reservation: taken.reservation,
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
            recovered,
        };
        created(&claim.start(spec)).await
    }

    /// A plan, when it is this client's turn.
    async fn plan(&self, message: wire::Scene, client: ClientKey) -> Result<Planned, Fault> {
        let _turn = self.services.gates.plans.turn(client).await;
        planning::plan(&self.services, message).await
    }

    /// Refuses a client that has too much waiting already.
    fn check_queue(&self, client: ClientKey) -> Result<(), Fault> {
        let limit = self.services.config.maximum_queued;
        match self.services.solvers.waiting(client) < limit {
            true => Ok(()),
            false => Err(Fault::QueueFull { limit }),
        }
    }

    /// The imported state that a request starts from; its scene becomes the request's
    /// where that has none.
    async fn imported_state(
        &self,
        request: &mut wire::CreateSessionRequest,
    ) -> Result<Option<Bytes>, Fault> {
        if request.from_state.is_empty() {
            return Ok(None);
        }
        let journal = self.services.journal.as_ref();
        let found = self.states.get(journal, &request.from_state).await?;
        if request.scene.is_none() {
            let scene = wire::Scene::decode(found.scene);
            let wrong = |_| Fault::StateInvalid("the state names no scene".to_owned());
            request.scene = Some(scene.map_err(wrong)?);
        }
        Ok(Some(found.state))
    }

    /// Puts a new session on disk, before anybody hears of it.
    async fn store(
        &self,
        claim: &Claim,
        request: Option<(Vec<u8>, &Caller)>,
        planned: &Planned,
        recovered: Option<&Recovered>,
    ) -> Result<(), Fault> {
        let (Some(journal), Some((request, caller))) = (&self.services.journal, request) else {
            return Ok(());
        };
        let session = StoredSession {
            request: request.into(),
            created: Some(SystemTime::now().into()),
            mesh: mesh::name(planned.mesh.value().id()),
            scene_name: planned.plan.report().name,
            owner: caller
                .name()
                .map_or_else(String::new, |name| name.to_string()),
        };
        let mut changes = vec![Change::Begin, Change::Delete, Change::Session(session)];
        let start = recovered.and_then(|one| one.checkpoint.clone());
        changes.extend(start.map(Change::Checkpoint));
        let stored = journal.store(claim.name(), changes).await;
        stored.map_err(planning::unwritable)
    }

    async fn list(
        &self,
        request: wire::ListSessionsRequest,
        caller: &Caller,
    ) -> Result<wire::ListSessionsResponse, Fault> {
        let size = page_size(request.page_size)?;
        let found = self.registry.list(caller, &request.page_token, size);
        let asleep = self.registry.list_asleep(caller, &request.page_token, size);
        let mut sessions = asleep;
        let mut names: Vec<String> = found.iter().map(|(name, _)| name.clone()).collect();
        names.extend(sessions.iter().map(|one| one.name.clone()));
        names.sort_unstable();
        let last = names.get(size - 1).cloned();
        for (_, handle) in &found {
            // One that ended meanwhile is left out.
            if let Ok(session) = handle.list().await {
                sessions.push(wire::Session {
                    plan: None,
                    ..session
                });
            }
        }
        if let Some(last) = &last {
            sessions.retain(|one| one.name <= *last);
        }
        sessions.sort_unstable_by(|one, other| one.name.cmp(&other.name));
        let next_page_token = last.unwrap_or_default();
        Ok(wire::ListSessionsResponse {
            sessions,
            next_page_token,
        })
    }

    async fn read(
        &self,
        request: wire::ReadStepRequest,
        caller: &Caller,
    ) -> Result<Messages<wire::ReadStepResponse>, Fault> {
        let handle = self.registry.get(caller, &request.name).await?;
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
        Ok(paced(all.map(|message| wire::ReadStepResponse {
            message: Some(message),
        })))
    }
}

/// Where a session starts that goes on from the state of another one.
fn start(planned: &Planned, state: Bytes) -> Result<Box<Recovered>, Fault> {
    let checked = signorini::Session::check_import(&planned.plan, &state, Rounding::Same);
    checked.map_err(|error| Fault::StateInvalid(error.to_string()))?;
    Ok(Box::new(Recovered::at(state)))
}

fn check_request(request: &wire::CreateSessionRequest) -> Result<(), Fault> {
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
