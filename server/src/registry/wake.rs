//! A session out of the data folder: planned again, its history at hand.

use std::sync::Arc;
use std::time::SystemTime;

use prost::Message as _;
use signorini_proto::v1 as wire;

use crate::convert::{report, step};
use crate::door::client_key::{ClientIdentity, ClientKey};
use crate::door::client_name::ClientName;
use crate::fault::Fault;
use crate::journal::{Change, JournalError, Listed, Stored};
use crate::registry::planning::{self, aside, unwritable};
use crate::session::{Recovered, Services, SessionSpec};
use crate::uploads::store::Account;

/// What the session `name` starts from.
///
/// # Errors
/// `SessionNotFound` where there is none, `SessionDamaged` for one that cannot be read,
/// and what a new session of the same scene is refused for.
pub(crate) async fn spec(services: &Arc<Services>, name: &str) -> Result<SessionSpec, Fault> {
    let stored = load(services, name).await?;
    let damaged = |_| Fault::SessionDamaged {
        name: name.to_owned(),
        why: "its request cannot be read".to_owned(),
    };
    let request = wire::CreateSessionRequest::decode(stored.session.request.clone());
    let mut request = request.map_err(damaged)?;
    let scene = request.scene.take().unwrap_or_default();
    let created = stored
        .session
        .created
        .and_then(|time| SystemTime::try_from(time).ok());
    let client = owner_of(&stored.session.owner).map(ClientIdentity::Named);
    // It was let in when it was made: counted, and never refused for that.
    let account = Account {
        client: client.unwrap_or(ClientIdentity::Unknown),
        most: u64::MAX,
    };
    let recovered = Recovered::new(name, stored);
    let recovered = recovered.inspect_err(|_| services.metrics.damaged("session"))?;
    let kept = Arc::new(scene.clone());
    let planned = planning::plan(services, scene).await?;
    let plan_report = report::plan(planned.plan.report());
    let own_bytes = planning::own_bytes(&kept, &plan_report);
    let result_bytes = planning::result_bytes(&planned);
    let taken = planning::reserve(&services.store, &planned, (own_bytes, account))?;
    let ttl = step::duration(request.ttl.as_ref(), "ttl")?;
    Ok(SessionSpec {
        name: name.to_owned(),
        lease: services.lease(name)?,
        reservation: taken.reservation,
        prepared: taken.prepared,
        own_bytes,
        result_bytes,
        plan: Arc::new(planned.plan),
        plan_report,
        scene: kept,
        client: ClientKey::UNKNOWN,
        on_disconnect: request.on_disconnect(),
        mesh: planned.mesh,
        output: planned.request.output,
        ttl: ttl.unwrap_or_else(|| services.config.ttl()),
        created: created.unwrap_or_else(SystemTime::now),
        recovered: Some(Box::new(recovered)),
    })
}

async fn load(services: &Arc<Services>, name: &str) -> Result<Stored, Fault> {
    let missing = || Fault::SessionNotFound(name.to_owned());
    let journal = services.journal.clone().ok_or_else(missing)?;
    // What the actor before has handed over is on disk after this, or lost; a disk that
    // takes nothing can still be read.
    if let Err(why) = journal.store(name, vec![Change::Begin]).await {
        tracing::warn!(
            why = why.to_string(),
            "a session wakes that cannot be written"
        );
    }
    let wanted = name.to_owned();
    let loaded = aside(move || journal.load(&wanted)).await?;
    let found = loaded.map_err(|error| match error {
        JournalError::Damaged(why) => {
            services.metrics.damaged("session");
            tracing::error!(name, why, "a session in the data folder is damaged");
            let name = name.to_owned();
            Fault::SessionDamaged { name, why }
        }
        JournalError::Elsewhere(name) => {
            let owner = String::new();
            Fault::SessionElsewhere { name, owner }
        }
        JournalError::Folder { .. }
        | JournalError::InUse(_)
        | JournalError::Version { .. }
        | JournalError::Unwritable(_) => unwritable(error),
    });
    found?.ok_or_else(missing)
}

/// Whom a session of the data folder belongs to; none where everybody may see it.
pub(crate) fn owner(listed: &Listed) -> Option<ClientName> {
    owner_of(&listed.session.owner)
}

/// A name that this version does not know is somebody's all the same.
fn owner_of(stored: &str) -> Option<ClientName> {
    match stored {
        "" => None,
        name => Some(name.parse().unwrap_or(ClientName::UNREADABLE)),
    }
}

/// How a list describes a session that only the data folder has.
pub(crate) fn described(name: &str, listed: &Listed) -> wire::Session {
    wire::Session {
        name: name.to_owned(),
        state: wire::SessionState::Asleep.into(),
        scene_name: listed.session.scene_name.clone(),
        mesh: listed.session.mesh.clone(),
        create_time: listed.session.created,
        last_accepted_sequence: listed.accepted,
        last_finished_sequence: listed.finished,
        first_retained_sequence: listed.first,
        ..Default::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_whose_owner_cannot_be_read_is_not_everybodys() {
        assert_eq!(owner_of(""), None);
        assert_eq!(owner_of("line-1"), Some("line-1".parse().unwrap()));
        for unknown in ["a b", "-x", &"a".repeat(40)] {
            assert_eq!(owner_of(unknown), Some(ClientName::UNREADABLE));
        }
    }
}
