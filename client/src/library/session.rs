//! Sessions of the service: create, look at, delete, and plans.

use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::time::Duration;

use signorini_proto::v1;

use crate::library::breaks::again;
use crate::library::connect::{Client, answer, planned};
use crate::library::error::ClientError;
use crate::library::mesh::missing;

/// What a new session shall be.
#[derive(Clone, Debug, Default)]
pub struct NewSession {
    /// The problem, with its `mesh` named.
    pub scene: v1::Scene,
    /// Identifier of the session; empty: one of [`session_id`].
    pub session_id: String,
    /// Time to live since the last call; `None`: the server's default.
    pub ttl: Option<Duration>,
    /// What a broken connection means for the step that runs, for streams that
    /// do not say it themselves.
    pub on_disconnect: v1::DisconnectPolicy,
}

pub(crate) fn resource(session: &str) -> String {
    if session.starts_with("sessions/") {
        session.to_owned()
    } else {
        format!("sessions/{session}")
    }
}

/// A new identifier of a session. The client chooses it, so that whatever belongs to the session
/// can say so before there is one: see [`Client::of_session`].
pub fn session_id() -> String {
    // Random keys of the standard hasher: enough for names nobody guesses by accident.
    format!("s{:016x}", RandomState::new().build_hasher().finish())
}

impl Client {
    /// Plans a scene without creating anything.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SCENE_INVALID`, `UNSUPPORTED_COMBINATION`, `MESH_NOT_FOUND`.
    pub async fn plan(&self, scene: v1::Scene) -> Result<v1::Plan, ClientError> {
        self.planned(v1::CreateSessionRequest {
            scene: Some(scene),
            ..Default::default()
        })
        .await
    }

    /// The same with the solver's constants.
    ///
    /// # Errors
    /// As [`Client::plan`].
    pub async fn plan_with_constants(&self, scene: v1::Scene) -> Result<v1::Plan, ClientError> {
        self.planned(v1::CreateSessionRequest {
            scene: Some(scene),
            constants: true,
            ..Default::default()
        })
        .await
    }

    /// The plan that answers `request`, which creates nothing.
    async fn planned(
        &self,
        mut request: v1::CreateSessionRequest,
    ) -> Result<v1::Plan, ClientError> {
        request.validate_only = true;
        let plan = || async { planned(self.sessions().create_session(request.clone())).await };
        let response = again(plan).await?.into_inner();
        response.plan.ok_or_else(|| missing("the plan"))
    }

    /// Creates a session; its preparation starts after the answer.
    ///
    /// # Errors
    /// As [`Client::plan`], and `MEMORY_BUDGET`, `SESSION_EXISTS`.
    pub async fn create_session(
        &self,
        new: NewSession,
    ) -> Result<(v1::Session, v1::Plan), ClientError> {
        let ttl = new.ttl.map(prost_types::Duration::try_from).transpose();
        let id = Some(new.session_id).filter(|id| !id.is_empty());
        let request = v1::CreateSessionRequest {
            scene: Some(new.scene),
            session_id: id.unwrap_or_else(session_id),
            // What is asked for again because its answer was lost is made once.
            request_id: session_id(),
            ttl: ttl
                .map_err(|_| ClientError::Protocol("the time to live is too long".to_owned()))?,
            on_disconnect: new.on_disconnect.into(),
            ..Default::default()
        };
        let create = || async {
            let mut sessions = self.sessions_of(&request.session_id);
            planned(sessions.create_session(request.clone())).await
        };
        let response = again(create).await?.into_inner();
        let session = response.session.ok_or_else(|| missing("the session"))?;
        let plan = response.plan.ok_or_else(|| missing("the plan"))?;
        Ok((session, plan))
    }

    /// A session by its identifier or name.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`, `SESSION_EXPIRED`.
    pub async fn get_session(&self, session: &str) -> Result<v1::Session, ClientError> {
        let request = v1::GetSessionRequest {
            name: resource(session),
        };
        let get = || async {
            let mut sessions = self.sessions_of(session);
            answer(sessions.get_session(request.clone())).await
        };
        let response = again(get).await?.into_inner();
        response.session.ok_or_else(|| missing("the session"))
    }

    /// All sessions, in order of their names.
    ///
    /// # Errors
    /// [`ClientError::Refused`].
    pub async fn list_sessions(&self) -> Result<Vec<v1::Session>, ClientError> {
        let mut sessions = Vec::new();
        let mut page_token = String::new();
        loop {
            let request = v1::ListSessionsRequest {
                page_size: 0,
                page_token,
            };
            let list = || async { answer(self.sessions().list_sessions(request.clone())).await };
            let page = again(list).await?.into_inner();
            sessions.extend(page.sessions);
            page_token = page.next_page_token;
            if page_token.is_empty() {
                return Ok(sessions);
            }
        }
    }

    /// Cancels what runs and forgets the session.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`.
    pub async fn delete_session(&self, session: &str) -> Result<(), ClientError> {
        let request = v1::DeleteSessionRequest {
            name: resource(session),
        };
        let mut tries = 0;
        let delete = || {
            tries += 1;
            async {
                let mut sessions = self.sessions_of(session);
                answer(sessions.delete_session(request.clone())).await
            }
        };
        match again(delete).await {
            // An earlier try did it, and its answer was lost.
            Err(error) if tries > 1 && error.is_reason("SESSION_NOT_FOUND") => Ok(()),
            outcome => outcome.map(drop),
        }
    }

    /// Cancels a step from any connection (0: the one that runs); the answer is
    /// the sequence that is being cancelled, 0 when there is none.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`.
    pub async fn cancel_step(&self, session: &str, sequence: i64) -> Result<i64, ClientError> {
        let request = v1::CancelStepRequest {
            name: resource(session),
            sequence,
        };
        let cancel = || async {
            let mut sessions = self.sessions_of(session);
            answer(sessions.cancel_step(request.clone())).await
        };
        let response = again(cancel).await?.into_inner();
        Ok(response.sequence)
    }
}
