//! From a scene to what a session starts with: mesh, tools, plan and memory.

pub(crate) mod meshes;
pub(crate) mod tools;

use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use prost::Message as _;
use signorini::mesh::{Mesh, MeshId};
use signorini::plan::Plan;
use signorini::prepare::Prepared;
use signorini_proto::v1 as wire;

use crate::convert::mesh::{self as convert, MeshUse};
use crate::convert::scene::{self, SceneRequest};
use crate::convert::surface;
use crate::door::access::{Caller, Owners};
use crate::fault::{Fault, UploadKind};
use crate::journal::{Change, Journal, JournalError, StoredMesh};
use crate::session::Services;
use crate::uploads::store::{Account, Lease, Reservation, Store};

/// Memory of a decoded message over its encoded size, about.
const OWN_FACTOR: u64 = 4;

/// A scene with its mesh and its plan.
pub(crate) struct Planned {
    pub(crate) request: SceneRequest,
    pub(crate) mesh: Lease<Mesh>,
    pub(crate) plan: Plan,
}

/// Memory taken for a session.
pub(crate) struct Taken {
    pub(crate) reservation: Arc<Mutex<Reservation>>,
    pub(crate) prepared: Option<Lease<Prepared>>,
}

/// Checks and plans a scene on its mesh.
pub(crate) async fn plan(services: &Arc<Services>, message: wire::Scene) -> Result<Planned, Fault> {
    let surfaces = tools::of_scene(services, &message).await?;
    let request = scene::scene(message, &surfaces)?;
    let mesh = mesh(services, request.mesh).await?;
    // A plan numbers the mesh and finds its surfaces: about the mesh once more.
    let _memory = services.store.reserve(mesh.value().bytes())?;
    let compared = services.config.compared.clone();
    let planned = aside(move || {
        let plan = request.plan(mesh.value(), &compared)?;
        Ok::<_, Fault>(Planned {
            request,
            mesh,
            plan,
        })
    });
    planned.await?
}

/// About what the fields of one result take, bytes.
pub(crate) fn result_bytes(planned: &Planned) -> u64 {
    let fields = planned.request.output.fields.len() as u64;
    8 * fields * planned.plan.report().unknowns.displacement
}

/// Bytes that a session's messages take.
pub(crate) fn own_bytes(scene: &wire::Scene, plan: &wire::Plan) -> u64 {
    OWN_FACTOR * (scene.encoded_len() + plan.encoded_len()) as u64
}

/// Refuses a scene with a mesh or a surface that is not there for `caller`.
///
/// # Errors
/// `MeshNotFound` and `SurfaceNotFound`; other faults of the scene are found by [`plan`].
pub(crate) async fn check_uploads(
    services: &Arc<Services>,
    scene: &wire::Scene,
    caller: &Caller,
) -> Result<(), Fault> {
    if caller.sees_all() {
        return Ok(());
    }
    if let Ok(id) = convert::id_from_name(&scene.mesh, "mesh")
        && mesh(services, id).await.is_ok()
    {
        services.store.check_owner(id, caller)?;
    }
    for name in surface::names(scene) {
        let digest = surface::digest_of(&name, "obstacle.shape.surface")?;
        tools::check(services, &digest, caller).await?;
    }
    Ok(())
}

/// Takes the memory that is predicted for a first step, with one result, less what another session has
/// prepared, and keeps that from being dropped.
pub(crate) fn reserve(
    store: &Arc<Store>,
    planned: &Planned,
    (own_bytes, account): (u64, Account),
) -> Result<Taken, Fault> {
    let prepared = store.hold_prepared(&planned.plan.key());
    let there = prepared.as_ref().map_or(0, |lease| lease.value().bytes());
    let result = result_bytes(planned);
    let predicted = planned.plan.first_bytes().saturating_sub(there);
    let bytes = predicted.saturating_add(result + own_bytes);
    let reservation = store.reserve_for(account, bytes)?;
    Ok(Taken {
        reservation: Arc::new(Mutex::new(reservation)),
        prepared,
    })
}

/// A mesh by its identity, from memory or the data folder. One whose file alone is there is on its
/// way, or was not acknowledged: whoever read it would take it for one that others find too.
pub(crate) async fn mesh(services: &Arc<Services>, id: MeshId) -> Result<Lease<Mesh>, Fault> {
    let missing = match services.store.mesh(id) {
        Ok(mesh) => return Ok(mesh),
        Err(missing) => missing,
    };
    let Some(journal) = services.journal.clone() else {
        return Err(missing);
    };
    let services = Arc::clone(services);
    aside(move || {
        let Some(owners) = owners(&journal, id)? else {
            return Err(missing);
        };
        let wrong = |why: &str| damaged(&services, UploadKind::Mesh, (&convert::name(id), why));
        match journal.read_mesh(id).map_err(unwritable)? {
            Some(bytes) => {
                let mesh = checked(&services.store, id, &bytes)?;
                let mesh = mesh.map_err(|why| wrong(&why))?;
                journal.have_mesh(id, &bytes);
                drop(services.store.reserve(mesh.bytes())?);
                Ok(services.store.insert_mesh(mesh, owners))
            }
            // Deleted meanwhile, or gone.
            None if journal
                .mesh(&convert::name(id))
                .map_err(unwritable)?
                .is_none() =>
            {
                Err(missing)
            }
            None => Err(wrong("its file is gone")),
        }
    })
    .await?
}

/// Tells of an upload that is not as it was written, and counts it.
pub(crate) fn damaged(services: &Services, kind: UploadKind, (name, why): (&str, &str)) -> Fault {
    services.metrics.damaged(kind.name());
    tracing::error!(name, why, "an upload in the data folder is damaged");
    Fault::UploadDamaged {
        kind,
        name: name.to_owned(),
        why: why.to_owned(),
    }
}

/// As [`mesh`], of one that may not be there.
pub(crate) async fn known_mesh(
    services: &Arc<Services>,
    id: MeshId,
) -> Result<Option<Lease<Mesh>>, Fault> {
    match mesh(services, id).await {
        Err(Fault::MeshNotFound(_) | Fault::UploadDamaged { .. }) => Ok(None),
        found => found.map(Some),
    }
}

/// As [`mesh`], if it is there for `caller`.
///
/// # Errors
/// `MeshNotFound`, as for one that is not there at all.
pub(crate) async fn mesh_for(
    services: &Arc<Services>,
    id: MeshId,
    caller: &Caller,
) -> Result<Lease<Mesh>, Fault> {
    let found = mesh(services, id).await?;
    services.store.check_owner(id, caller)?;
    Ok(found)
}

/// Whom a mesh of the data folder belongs to; none for one that has no entry.
fn owners(journal: &Journal, id: MeshId) -> Result<Option<Owners>, Fault> {
    let name = convert::name(id);
    let stored = journal.mesh(&name).map_err(unwritable)?;
    let owners = stored.map(|stored| Owners::from_stored(&stored.owners));
    owners
        .transpose()
        .map_err(|owner| Fault::Unwritable(format!("`{name}` has the owner \"{owner}\"")))
}

/// A mesh out of its file, or what is wrong with that.
///
/// # Errors
/// `MemoryBudget`.
fn checked(store: &Arc<Store>, id: MeshId, bytes: &[u8]) -> Result<Result<Mesh, String>, Fault> {
    let _reservation = store.reserve(2 * bytes.len() as u64)?;
    Ok(match convert::from_file(bytes) {
        Ok(mesh) if mesh.id() == id => Ok(mesh),
        Ok(_) => Err("its file holds another mesh".to_owned()),
        Err(why) => Err(why.to_string()),
    })
}

/// Tells the journal of a mesh whose file is on the disk, and whom it belongs to.
pub(crate) async fn store_mesh(
    journal: &Arc<Journal>,
    mesh: &Mesh,
    owners: &Owners,
) -> Result<(), Fault> {
    let now = SystemTime::now();
    let uses = MeshUse {
        sessions: 0,
        created: now,
        used: now,
    };
    let described = convert::mesh(mesh, &uses).encode_to_vec().into();
    let owners = owners.stored();
    let stored = StoredMesh { described, owners };
    let (sharing, entry, digest) = (Arc::clone(journal), stored.clone(), mesh.id().to_string());
    let shared = aside(move || sharing.share(("meshes", &digest), &entry)).await?;
    shared.map_err(unwritable)?;
    let change = Change::Mesh(convert::name(mesh.id()), stored);
    journal.store("", vec![change]).await.map_err(unwritable)
}

/// What a client hears when the data folder refuses something.
pub(crate) fn unwritable(error: JournalError) -> Fault {
    Fault::Unwritable(error.to_string())
}

/// Runs a short computation off the threads that serve connections.
pub(crate) async fn aside<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Fault> {
    let span = tracing::Span::current();
    let done = tokio::task::spawn_blocking(move || span.in_scope(work)).await;
    done.map_err(|error| {
        tracing::error!(said = error.to_string(), "a request panicked");
        Fault::Internal
    })
}
