//! What clients have uploaded, meshes and surfaces of tools: a file each, and an entry that
//! describes it and says whose it is.
//!
//! The file comes before its entry and goes after it: one whose file alone is there was not
//! acknowledged, and is nobody's.

use std::io;
use std::path::{Path, PathBuf};

use signorini::mesh::MeshId;

use super::error::JournalError;
use super::files::Part;
use super::record::{StoredMesh, StoredSurface};
use super::{Change, Journal, database, files};

/// Takes the next bytes of a file.
type Put<'a> = dyn FnMut(&[u8]) -> Written + 'a;
type Written = io::Result<()>;
type MadePart = Result<Part, JournalError>;

impl Journal {
    /// One stored mesh. Blocks.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub(crate) fn mesh(&self, name: &str) -> Result<Option<StoredMesh>, JournalError> {
        match self.database.with(|open| database::mesh(open, name))? {
            Some(found) => Ok(Some(found)),
            None => self.shared_entry(name),
        }
    }

    /// The stored meshes. Blocks.
    pub(crate) fn meshes(&self) -> Result<Vec<(String, StoredMesh)>, JournalError> {
        self.database.with(database::meshes)
    }

    /// One stored surface. Blocks.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub(crate) fn surface(&self, name: &str) -> Result<Option<StoredSurface>, JournalError> {
        match self.database.with(|open| database::surface(open, name))? {
            Some(found) => Ok(Some(found)),
            None => self.shared_entry(name),
        }
    }

    /// The stored surfaces. Blocks.
    pub(crate) fn surfaces(&self) -> Result<Vec<(String, StoredSurface)>, JournalError> {
        self.database.with(database::surfaces)
    }

    /// The bytes of a mesh's file; none where there is no such file. Blocks.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn read_mesh(&self, id: MeshId) -> Result<Option<Vec<u8>>, JournalError> {
        match files::read(&self.mesh_file(id))? {
            Some(bytes) => Ok(Some(bytes)),
            None => self.shared_file("meshes", &id.to_string()),
        }
    }

    /// Keeps a mesh that another server of the fleet has sent in this folder, too, so that its
    /// backups need no other; what the disk refuses is read from there again. Blocks.
    pub(crate) fn have_mesh(&self, id: MeshId, bytes: &[u8]) {
        let (path, name) = (self.mesh_file(id), format!("meshes/{id}"));
        let entry = |stored| Change::Mesh(name.clone(), stored);
        self.have((&path, bytes), || Ok(self.shared_entry(&name)?.map(entry)));
    }

    /// As [`Journal::have_mesh`], of a surface. Blocks.
    pub(crate) fn have_surface(&self, digest: &str, bytes: &[u8]) {
        let (path, name) = (self.surface_file(digest), format!("surfaces/{digest}"));
        let entry = |stored| Change::Surface(name.clone(), stored);
        self.have((&path, bytes), || Ok(self.shared_entry(&name)?.map(entry)));
    }

    fn have(
        &self,
        (path, bytes): (&Path, &[u8]),
        entry: impl FnOnce() -> Result<Option<Change>, JournalError>,
    ) {
        if path.exists() {
            return;
        }
        let kept = entry().and_then(|entry| match entry {
            // The file before its entry.
            Some(entry) => files::write(path, bytes).and_then(|()| self.write_now(vec![entry])),
            None => Ok(()),
        });
        if let Err(why) = kept {
            tracing::warn!(
                why = why.to_string(),
                "an upload stays in the shared folder alone"
            );
        }
    }

    /// As [`Journal::read_mesh`], of a surface.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn read_surface(&self, digest: &str) -> Result<Option<Vec<u8>>, JournalError> {
        match files::read(&self.surface_file(digest))? {
            Some(bytes) => Ok(Some(bytes)),
            None => self.shared_file("surfaces", digest),
        }
    }

    /// Drops the file of a mesh. Blocks.
    pub(crate) fn drop_mesh(&self, id: MeshId) -> Result<(), JournalError> {
        files::remove(&self.mesh_file(id))
    }

    /// Drops the file of a surface. Blocks.
    pub(crate) fn drop_surface(&self, digest: &str) -> Result<(), JournalError> {
        files::remove(&self.surface_file(digest))
    }

    /// Writes the bytes of a mesh beside its place, which is not known yet. Blocks.
    pub(crate) fn write_mesh(&self, fill: impl FnOnce(&mut Put<'_>) -> Written) -> MadePart {
        self.disk()
            .told(Part::write(&self.folder().join("meshes"), fill))
    }

    /// Writes the bytes of a surface beside its place: they may turn out to be none. Blocks.
    pub(crate) fn write_surface(&self, fill: impl FnOnce(&mut Put<'_>) -> Written) -> MadePart {
        self.disk()
            .told(Part::write(&self.folder().join("surfaces"), fill))
    }

    /// Gives a mesh its place. Blocks.
    pub(crate) fn keep_mesh(&self, part: Part, id: MeshId) -> Result<(), JournalError> {
        self.disk().told(part.keep(&self.mesh_file(id)))
    }

    /// Gives a surface its place. Blocks.
    pub(crate) fn keep_surface(&self, part: Part, digest: &str) -> Result<(), JournalError> {
        self.disk().told(part.keep(&self.surface_file(digest)))
    }

    fn mesh_file(&self, id: MeshId) -> PathBuf {
        self.folder().join("meshes").join(id.to_string())
    }

    /// The digest is one that this server has computed, or found in its form.
    fn surface_file(&self, digest: &str) -> PathBuf {
        self.folder().join("surfaces").join(digest)
    }
}
