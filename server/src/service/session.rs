//! `SessionService`.

mod create;

use std::sync::Arc;

use signorini_proto::v1::{self as wire, session_service_server::SessionService};
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status, Streaming};

use super::paced::{Messages, paced};
use super::{page_size, respond, state, timeout};
use crate::convert::field::{self, Encoding};
use crate::convert::wide;
use crate::data::states::States;
use crate::door::access::{Caller, Who};
use crate::door::client_key::ClientKey;
use crate::fault::Fault;
use crate::registry::Registry;
use crate::results::kept::messages;
use crate::service::streams;
use crate::session::{ReadRequest, Services};

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
        let created = Box::pin(self.create(request.into_inner(), call));
        respond(&self.registry, created).await
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
        let wanted = if fields.is_empty() {
            answer.output
        } else {
            fields
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
