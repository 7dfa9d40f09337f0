//! `CreateSession`: from a request to a session that is planned, paid for and on disk.

use std::sync::Arc;
use std::time::SystemTime;

use prost::Message;
use signorini::Rounding;
use signorini_proto::v1 as wire;

use super::Sessions;
use crate::convert::scene::take_accuracy;
use crate::convert::{mesh, report, step};
use crate::door::access::Caller;
use crate::door::client_key::{ClientIdentity, ClientKey};
use crate::fault::Fault;
use crate::journal::{Change, StoredSave, StoredSession};
use crate::registry::planning::{self, Planned};
use crate::registry::{Claim, Claimed};
use crate::session::{Handle, Recovered, SessionSpec};

const MAXIMUM_REQUEST_ID_BYTES: usize = 64;
const MAXIMUM_SCENE_BYTES: usize = 3 << 20;

impl Sessions {
    /// Makes a session, or a plan alone.
    pub(super) async fn create(
        &self,
        mut request: wire::CreateSessionRequest,
        (caller, client): (Caller, ClientKey),
    ) -> Result<wire::CreateSessionResponse, Fault> {
        self.registry.check_open()?;
        check_request(&request)?;
        self.check_queue(client.identity)?;
        let ttl = step::duration(request.ttl.as_ref(), "ttl")?;
        let missing = || Fault::request("scene", "is required");
        let on_disconnect = request.on_disconnect();
        let from_state = self.imported_state(&mut request).await?;
        let asked = self
            .services
            .journal
            .as_ref()
            .map(|_| request.encode_to_vec());
        let mut scene = request.scene.ok_or_else(missing)?;
        planning::check_uploads(&self.services, &scene, &caller).await?;
        if request.validate_only {
            if scene.accuracy.iter().any(|one| !one.targets.is_empty()) {
                // The plan of the mesh that `RefineMesh` begins with.
                take_accuracy(&mut scene)?;
            }
            let plan = self.plan(scene, client.identity).await?.plan;
            let mut plan = report::plan(plan.report());
            if request.constants {
                plan.constants = report::constants();
            }
            return Ok(wire::CreateSessionResponse {
                session: None,
                plan: Some(plan),
            });
        }
        // Before planning, so that a repeat meanwhile finds this request.
        let claimed = self.registry.claim(
            (&caller, client.identity),
            &request.session_id,
            &request.request_id,
        );
        let claim = match claimed.await? {
            Claimed::Made(handle) => return created(&handle).await,
            Claimed::New(claim) => claim,
        };
        let kept = Arc::new(scene.clone());
        let planned = self.plan(scene, client.identity).await?;
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
            lease: self.services.lease(claim.name())?,
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
    async fn plan(&self, message: wire::Scene, client: ClientIdentity) -> Result<Planned, Fault> {
        let _turn = self.services.gates.plans.turn(client).await;
        planning::plan(&self.services, message).await
    }

    /// Refuses a client that has too much waiting already.
    fn check_queue(&self, client: ClientIdentity) -> Result<(), Fault> {
        let limit = self.services.config.maximum_queued;
        if self.services.solvers.waiting(client) < limit {
            Ok(())
        } else {
            Err(Fault::QueueFull { limit })
        }
    }

    /// The imported state that a request starts from; its scene becomes the request's
    /// where that has none.
    async fn imported_state(
        &self,
        request: &mut wire::CreateSessionRequest,
    ) -> Result<Option<StoredSave>, Fault> {
        if request.from_state.is_empty() {
            return Ok(None);
        }
        let journal = self.services.journal.as_ref();
        let found = self.states.get(journal, &request.from_state).await;
        let found = found.inspect_err(|fault| {
            if let Fault::UploadDamaged { kind, .. } = fault {
                self.services.metrics.damaged(kind.name());
            }
        })?;
        if request.scene.is_none() {
            let scene = wire::Scene::decode(found.scene);
            let wrong = |_| Fault::StateInvalid("the state names no scene".to_owned());
            request.scene = Some(scene.map_err(wrong)?);
        }
        Ok(Some(StoredSave {
            state: found.state,
            since: found.since,
        }))
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
}

/// Where a session starts that goes on from the state of another one.
fn start(planned: &Planned, from: StoredSave) -> Result<Box<Recovered>, Fault> {
    let checked = signorini::Session::check_import(&planned.plan, &from.state, Rounding::Same);
    checked.map_err(|error| Fault::StateInvalid(error.to_string()))?;
    Recovered::at(from).map(Box::new)
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
