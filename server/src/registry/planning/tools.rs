//! Surfaces of tools, from memory or the data folder.
//!
//! Memory knows whose a surface is as long as it has it, the journal's entry otherwise; both
//! change together, in one turn.

use std::sync::Arc;
use std::time::SystemTime;

use prost::Message as _;
use signorini_proto::v1 as wire;

use super::{aside, damaged, unwritable};
use crate::convert::surface::{self as convert, name};
use crate::convert::uploaded::SurfacesByName;
use crate::door::access::{Caller, Owners};
use crate::door::client_key::ClientIdentity;
use crate::fault::{Fault, UploadKind};
use crate::journal::{Change, Part, StoredSurface};
use crate::session::Services;
use crate::uploads::store::{Account, Reservation};
use crate::uploads::surfaces::Stored;

/// The surfaces that a scene names.
pub(crate) async fn of_scene(
    services: &Arc<Services>,
    scene: &wire::Scene,
) -> Result<SurfacesByName, Fault> {
    let mut found = SurfacesByName::new();
    for name in convert::names(scene) {
        let digest = convert::digest_of(&name, "obstacle.shape.surface")?;
        found.insert(name, surface(services, &digest).await?.surface);
    }
    Ok(found)
}

/// Refuses a surface that is not there for `caller`.
///
/// # Errors
/// `SurfaceNotFound`.
pub(crate) async fn check(services: &Services, digest: &str, caller: &Caller) -> Result<(), Fault> {
    described(services, digest, caller).await.map(drop)
}

/// A surface as it is described to `caller`.
///
/// # Errors
/// `SurfaceNotFound`.
pub(crate) async fn described(
    services: &Services,
    digest: &str,
    caller: &Caller,
) -> Result<wire::StoredSurface, Fault> {
    match known(services, digest).await? {
        Some((described, owners)) if owners.admit(caller) => Ok(described),
        Some(_) | None => Err(Fault::SurfaceNotFound(name(digest))),
    }
}

/// All surfaces that are there for `caller`, in order of their digests.
pub(crate) async fn list(
    services: &Services,
    caller: &Caller,
) -> Result<Vec<wire::StoredSurface>, Fault> {
    let all = services.surfaces.all(caller).into_iter();
    let one = |(digest, stored): (String, Stored)| {
        convert::surface(&digest, &stored.surface, stored.created)
    };
    let mut found: Vec<_> = all.map(one).collect();
    for (name, stored) in entries(services).await? {
        let is_known = found.iter().any(|one| one.name == name);
        // One of a client that this build cannot read is not shown.
        let owners = owners_of(&name, &stored).is_ok_and(|owners| owners.admit(caller));
        if !is_known && owners {
            found.extend(read_entry(&name, &stored));
        }
    }
    found.sort_unstable_by(|one, other| one.name.cmp(&other.name));
    Ok(found)
}

/// All surfaces of the data folder that can be described.
pub(crate) async fn stored(services: &Services) -> Result<Vec<wire::StoredSurface>, Fault> {
    let all = entries(services).await?;
    let read = |(name, stored): &(String, StoredSurface)| read_entry(name, stored).ok();
    Ok(all.iter().filter_map(read).collect())
}

/// A surface that somebody has uploaded, described, and whom it belongs to; none for one whose
/// file alone is there.
pub(crate) async fn known(
    services: &Services,
    digest: &str,
) -> Result<Option<(wire::StoredSurface, Owners)>, Fault> {
    if let Some((found, owners)) = services.surfaces.owned(digest) {
        let described = convert::surface(digest, &found.surface, found.created);
        return Ok(Some((described, owners)));
    }
    let Some(journal) = services.journal.clone() else {
        return Ok(None);
    };
    let name = name(digest);
    let asked = name.clone();
    let entry = aside(move || journal.surface(&asked)).await?;
    let Some(entry) = entry.map_err(unwritable)? else {
        return Ok(None);
    };
    Ok(Some((
        read_entry(&name, &entry)?,
        owners_of(&name, &entry)?,
    )))
}

/// A surface that was uploaded.
pub(crate) struct Arrived {
    pub(crate) digest: String,
    /// Its file, unless there is no data folder or the file is there already.
    pub(crate) part: Option<Part>,
    pub(crate) stored: Stored,
    pub(crate) owners: Owners,
    pub(crate) reserved: Reservation,
}

/// Keeps a surface, on the disk before anybody finds it; the caller has the turn.
pub(crate) async fn keep(services: &Services, arrived: Arrived) -> Result<Stored, Fault> {
    let Arrived {
        digest,
        part,
        stored,
        owners,
        reserved,
    } = arrived;
    if let (Some(journal), Some(part)) = (services.journal.clone(), part) {
        let owned = digest.clone();
        let kept = aside(move || journal.keep_surface(part, &owned)).await?;
        kept.map_err(unwritable)?;
    }
    let described = convert::surface(&digest, &stored.surface, stored.created);
    enter(services, &described, &owners).await?;
    let kept = (stored, owners);
    Ok(services.surfaces.insert(digest, kept, reserved))
}

/// Tells the journal, if there is one, of a surface whose file is on the disk.
pub(crate) async fn enter(
    services: &Services,
    described: &wire::StoredSurface,
    owners: &Owners,
) -> Result<(), Fault> {
    let Some(journal) = &services.journal else {
        return Ok(());
    };
    let stored = StoredSurface {
        described: described.encode_to_vec().into(),
        owners: owners.stored(),
    };
    let (sharing, entry) = (Arc::clone(journal), stored.clone());
    let digest = described.name.trim_start_matches("surfaces/").to_owned();
    let shared = aside(move || sharing.share(("surfaces", &digest), &entry)).await?;
    shared.map_err(unwritable)?;
    let change = Change::Surface(described.name.clone(), stored);
    journal.store("", vec![change]).await.map_err(unwritable)
}

/// Drops a surface that no session uses, from memory and disk; the caller has the turn.
///
/// # Errors
/// `SurfaceInUse`.
pub(crate) async fn drop_surface(services: &Services, digest: &str) -> Result<(), Fault> {
    services.surfaces.remove(digest)?;
    let Some(journal) = services.journal.clone() else {
        return Ok(());
    };
    let dropped = vec![Change::DropSurface(name(digest))];
    journal.store("", dropped).await.map_err(unwritable)?;
    let digest = digest.to_owned();
    let dropped = aside(move || journal.drop_surface(&digest)).await?;
    dropped.map_err(unwritable)
}

/// A surface, from memory or its file.
///
/// # Errors
/// `SurfaceNotFound`.
pub(crate) async fn surface(services: &Arc<Services>, digest: &str) -> Result<Stored, Fault> {
    let missing = match services.surfaces.get(digest) {
        Ok(found) => return Ok(found),
        Err(missing) => missing,
    };
    let Some(journal) = services.journal.clone() else {
        return Err(missing);
    };
    let _turn = services.surfaces.turn().await;
    // Another may have read it meanwhile.
    if let Ok(found) = services.surfaces.get(digest) {
        return Ok(found);
    }
    let (services, digest) = (Arc::clone(services), digest.to_owned());
    let read = move || {
        let entry = journal.surface(&name(&digest)).map_err(unwritable)?;
        let bytes = journal.read_surface(&digest).map_err(unwritable)?;
        match (entry, bytes) {
            (Some(entry), Some(bytes)) => {
                let found = read_file(&services, &digest, &entry, &bytes)?;
                journal.have_surface(&digest, &bytes);
                Ok(found)
            }
            // A file alone was not acknowledged, as one of a mesh.
            (None, _) => Err(missing),
            // It is dropped in a turn of its own.
            (Some(_), None) => Err(damaged_surface(&services, &digest, "its file is gone")),
        }
    };
    aside(read).await?
}

/// A surface out of its file, taken into memory.
fn read_file(
    services: &Services,
    digest: &str,
    entry: &StoredSurface,
    bytes: &[u8],
) -> Result<Stored, Fault> {
    let name = name(digest);
    let owners = owners_of(&name, entry)?;
    let described = read_entry(&name, entry).ok();
    // It was let in when it was uploaded: counted, and never refused for that.
    let account = Account {
        client: owners
            .first()
            .map_or(ClientIdentity::Unknown, ClientIdentity::Named),
        most: u64::MAX,
    };
    let wrong = |why: Fault| damaged_surface(services, digest, &why.to_string());
    let predicted = convert::bytes_of_file(bytes).map_err(wrong)?;
    let predicted = predicted.saturating_add(bytes.len() as u64);
    let surfaces = &services.surfaces;
    let reserved = surfaces.reserve(&services.store, (account, predicted))?;
    let (found, surface) = convert::from_file(bytes).map_err(wrong)?;
    if found != digest {
        let why = "its file holds another surface";
        return Err(damaged_surface(services, digest, why));
    }
    let stored = Stored {
        surface,
        created: created(described.as_ref()),
    };
    Ok(surfaces.insert(found, (stored, owners), reserved))
}

fn damaged_surface(services: &Services, digest: &str, why: &str) -> Fault {
    damaged(services, UploadKind::Surface, (&name(digest), why))
}

async fn entries(services: &Services) -> Result<Vec<(String, StoredSurface)>, Fault> {
    let Some(journal) = services.journal.clone() else {
        return Ok(Vec::new());
    };
    let found = aside(move || journal.surfaces()).await?;
    found.map_err(unwritable)
}

/// When a surface came that may be known already.
pub(crate) fn created(described: Option<&wire::StoredSurface>) -> SystemTime {
    let time = described.and_then(|one| SystemTime::try_from(one.create_time?).ok());
    time.unwrap_or_else(SystemTime::now)
}

fn owners_of(name: &str, stored: &StoredSurface) -> Result<Owners, Fault> {
    Owners::from_stored(&stored.owners)
        .map_err(|owner| Fault::Unwritable(format!("`{name}` has the owner \"{owner}\"")))
}

fn read_entry(name: &str, stored: &StoredSurface) -> Result<wire::StoredSurface, Fault> {
    wire::StoredSurface::decode(stored.described.clone())
        .map_err(|_| Fault::Unwritable(format!("the entry of `{name}` cannot be read")))
}
