//! Meshes on their way into memory and the data folder, whether they were sent or made here.

use std::sync::Arc;

use signorini::mesh::{EdgeOffset, Mesh, MeshId, MeshParts};
use signorini_proto::v1 as wire;

use super::{known_mesh, store_mesh, unwritable};
use crate::convert::mesh as convert;
use crate::door::access::{Caller, Owners};
use crate::fault::Fault;
use crate::journal::Journal;
use crate::session::Services;
use crate::uploads::store::Lease;

/// Whether a mesh was stored before.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Presence {
    Before,
    New,
}

/// The mesh of arrays, its file on the disk where there is a data folder. Blocks.
///
/// # Errors
/// `MeshInvalid`; `DigestMismatch` where it is not the one that was `declared`; `Unwritable`.
pub(crate) fn made(
    (parts, offsets): (MeshParts, Vec<EdgeOffset>),
    declared: Option<MeshId>,
    journal: Option<&Journal>,
) -> Result<Mesh, Fault> {
    let invalid = |error: signorini::MeshError| Fault::MeshInvalid(error.to_string());
    let write =
        |journal: &Journal| journal.write_mesh(|put| convert::to_file(&parts, &offsets, put));
    let part = journal.map(write).transpose();
    let part = part.map_err(unwritable)?;
    let mesh = Mesh::second_order(parts, offsets).map_err(invalid)?;
    if let Some(declared) = declared.filter(|declared| *declared != mesh.id()) {
        return Err(Fault::DigestMismatch {
            declared: declared.to_string(),
            computed: mesh.id().to_string(),
        });
    }
    if let (Some(journal), Some(part)) = (journal, part) {
        let kept = journal.keep_mesh(part, mesh.id());
        kept.map_err(unwritable)?;
    }
    Ok(mesh)
}

/// Keeps a mesh that `caller` has sent or made, for which `held` bytes are taken already.
///
/// # Errors
/// `MemoryBudget`, `Unwritable`.
pub(crate) async fn keep(
    services: &Arc<Services>,
    mesh: Mesh,
    (caller, held): (&Caller, u64),
) -> Result<(Lease<Mesh>, Presence), Fault> {
    if let Some(found) = known_mesh(services, mesh.id()).await? {
        let presence = join(services, &found, caller).await?;
        return Ok((found, presence));
    }
    let owners = Owners::of(caller);
    let excess = mesh.bytes().saturating_sub(held);
    let _excess = services.store.reserve(excess)?;
    // On disk before anybody finds it.
    if let Some(journal) = &services.journal {
        store_mesh(journal, &mesh, &owners).await?;
    }
    let found = services.store.insert_mesh(mesh, owners);
    Ok((found, Presence::New))
}

/// Counts one more in who has sent a mesh that is there: new to that one, whoever had it.
async fn join(
    services: &Services,
    found: &Lease<Mesh>,
    caller: &Caller,
) -> Result<Presence, Fault> {
    let mesh = found.value();
    let Some(owners) = services.store.join(mesh.id(), caller) else {
        return Ok(Presence::Before);
    };
    if let Some(journal) = &services.journal {
        store_mesh(journal, mesh, &owners).await?;
    }
    Ok(Presence::New)
}

/// Takes the lease, which would count as a session otherwise.
pub(crate) fn describe(services: &Services, lease: Lease<Mesh>) -> Result<wire::StoredMesh, Fault> {
    let mesh = Arc::clone(lease.value());
    drop(lease);
    Ok(convert::mesh(&mesh, &services.store.mesh_use(mesh.id())?))
}
