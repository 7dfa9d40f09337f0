//! What servers share in a folder: meshes and surfaces of tools under their digests, each with its
//! entry, which says whose it is.
//!
//! The entry comes after its file: what has an entry is whole.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use prost::Message;

use super::error::JournalError;
use super::record::{opened, sealed};
use super::{Journal, files};

/// The folder, where there is one.
#[derive(Default)]
pub(super) struct Shared(Option<PathBuf>);

impl Journal {
    /// Shares uploads with other servers in `folder`; with nobody where that is empty.
    ///
    /// # Errors
    /// [`JournalError`] for a folder that cannot be used.
    pub(crate) fn sharing(mut self, folder: &Path) -> Result<Self, JournalError> {
        if !folder.as_os_str().is_empty() {
            for part in ["meshes", "surfaces"] {
                files::make_folder(&folder.join(part))?;
            }
            self.shared = Shared(Some(folder.to_owned()));
        }
        Ok(self)
    }

    /// Gives an upload, whose file is in this folder, to the others. Blocks.
    ///
    /// # Errors
    /// [`JournalError::Unwritable`].
    pub(crate) fn share(
        &self,
        (part, digest): (&str, &str),
        entry: &impl Message,
    ) -> Result<(), JournalError> {
        let Some(folder) = self.shared.0.as_ref().map(|folder| folder.join(part)) else {
            return Ok(());
        };
        let there = folder.join(digest);
        if !there.exists() {
            let own = self.folder().join(part).join(digest);
            if let Some(bytes) = files::read(&own)? {
                write(&there, &bytes)?;
            }
        }
        write(&folder.join(format!("{digest}.entry")), &sealed(entry))
    }

    /// The bytes of an upload that another server has. Blocks.
    pub(super) fn shared_file(
        &self,
        part: &str,
        digest: &str,
    ) -> Result<Option<Vec<u8>>, JournalError> {
        match &self.shared.0 {
            Some(folder) => read(&folder.join(part).join(digest)),
            None => Ok(None),
        }
    }

    /// The entry of one. Blocks.
    pub(super) fn shared_entry<M: Message + Default>(
        &self,
        name: &str,
    ) -> Result<Option<M>, JournalError> {
        let (Some(folder), true) = (&self.shared.0, is_plain(name)) else {
            return Ok(None);
        };
        let found = read(&folder.join(format!("{name}.entry")))?;
        found.map(|bytes| opened(&bytes, name)).transpose()
    }
}

/// A file of the folder; none where it is not in it. A folder that is not there, unmounted say, has
/// not said so.
fn read(path: &Path) -> Result<Option<Vec<u8>>, JournalError> {
    let found = files::read(path)?;
    let folder = path.parent().unwrap_or(path);
    if found.is_none() && !folder.is_dir() {
        Err(JournalError::Unwritable(format!(
            "{}: is not there",
            folder.display()
        )))
    } else {
        Ok(found)
    }
}

/// Whether a name is one of a digest in a part: no other reaches the file system.
fn is_plain(name: &str) -> bool {
    let digest = ["meshes/", "surfaces/"]
        .iter()
        .find_map(|part| name.strip_prefix(part));
    digest.is_some_and(|digest| digest.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// Writes a file beside its place under a name that no other server takes, then gives it its own.
fn write(path: &Path, bytes: &[u8]) -> Result<(), JournalError> {
    let mut part = path.as_os_str().to_owned();
    part.push(format!(".{:016x}", random()));
    let part = PathBuf::from(part);
    let written = fs::write(&part, bytes)
        .and_then(|()| File::open(&part)?.sync_all())
        .and_then(|()| fs::rename(&part, path))
        .and_then(|()| files::sync_folder(path));
    written.map_err(|error| JournalError::Unwritable(format!("{}: {error}", path.display())))
}

/// Random keys of the standard hasher.
fn random() -> u64 {
    use std::hash::{BuildHasher as _, Hasher as _, RandomState};
    RandomState::new().build_hasher().finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::StoredMesh;
    use crate::watch::metrics::Metrics;

    #[test]
    fn a_folder_that_is_not_there_has_not_said_that_a_mesh_is_not() {
        let name = format!("signorini-shared-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        // Of an earlier process of the same number.
        drop(fs::remove_dir_all(&folder));
        let (own, store) = (folder.join("data"), folder.join("store"));
        let journal = Journal::open(&own, &Metrics::new().unwrap()).unwrap();
        let journal = journal.sharing(&store).unwrap();
        let entry = || journal.shared_entry::<StoredMesh>("meshes/0a");
        assert_eq!(entry().unwrap(), None);
        fs::remove_dir_all(&store).unwrap();
        assert!(matches!(entry(), Err(JournalError::Unwritable(_))));
        let file = journal.shared_file("meshes", "0a");
        assert!(matches!(file, Err(JournalError::Unwritable(_))));
        journal.close();
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_mesh_of_another_server_is_kept_in_the_own_folder_once_it_is_used() {
        let name = format!("signorini-shared-own-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        // Of an earlier process of the same number.
        drop(fs::remove_dir_all(&folder));
        let store = folder.join("store");
        let open = |own: &str| {
            let journal = Journal::open(&folder.join(own), &Metrics::new().unwrap()).unwrap();
            journal.sharing(&store).unwrap()
        };
        let id = signorini::mesh::MeshId::from_bytes([7; 32]);
        let (first, second) = (open("first"), open("second"));
        let part = first.write_mesh(|put| put(b"mesh")).unwrap();
        first.keep_mesh(part, id).unwrap();
        let entry = StoredMesh::default();
        first.share(("meshes", &id.to_string()), &entry).unwrap();
        let found = second.read_mesh(id).unwrap().unwrap();
        second.have_mesh(id, &found);
        // All of it is there without the shared folder.
        fs::remove_dir_all(&store).unwrap();
        assert_eq!(second.read_mesh(id).unwrap().as_deref(), Some(&b"mesh"[..]));
        assert_eq!(second.meshes().unwrap(), [(format!("meshes/{id}"), entry)]);
        first.close();
        second.close();
        fs::remove_dir_all(&folder).unwrap();
    }
}
