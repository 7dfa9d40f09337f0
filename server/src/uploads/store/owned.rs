//! Whom the meshes of the store belong to.

use signorini::mesh::MeshId;

use super::Store;
use crate::convert::mesh::name;
use crate::door::access::{Caller, Owners};
use crate::fault::Fault;

impl Store {
    /// Refuses a mesh that is not there for `caller`.
    ///
    /// # Errors
    /// `MeshNotFound`, as for one that is not there at all.
    pub(crate) fn check_owner(&self, id: MeshId, caller: &Caller) -> Result<(), Fault> {
        if self.admits(id, caller) {
            Ok(())
        } else {
            Err(Fault::MeshNotFound(name(id)))
        }
    }

    /// Whether a mesh is there for `caller`, if it is there.
    pub(crate) fn admits(&self, id: MeshId, caller: &Caller) -> bool {
        let inner = self.lock();
        inner.owners.get(&id).is_none_or(|one| one.admit(caller))
    }

    /// Counts `caller` in who has sent the mesh; all of them, where that is new.
    pub(crate) fn join(&self, id: MeshId, caller: &Caller) -> Option<Owners> {
        let mut inner = self.lock();
        let owners = inner.owners.get_mut(&id)?;
        owners.join(caller).then(|| owners.clone())
    }

    /// Takes `caller` out who deletes the mesh; the others, whose it stays.
    pub(crate) fn leave(&self, id: MeshId, caller: &Caller) -> Option<Owners> {
        let mut inner = self.lock();
        let owners = inner.owners.get_mut(&id)?;
        owners.leave(caller).then(|| owners.clone())
    }
}
