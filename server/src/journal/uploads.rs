//! What clients have uploaded, meshes and surfaces of tools: a file each, and an entry that
//! describes it and says whose it is.
//!
//! The file comes before its entry and goes after it: one whose file alone is there was not
//! acknowledged, and is nobody's.

use std::io;
use std::path::PathBuf;

use signorini::mesh::MeshId;

use super::error::JournalError;
use super::files::Part;
use super::record::{StoredMesh, StoredSurface};
use super::{Journal, database, files};

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
        Part::write(&self.folder().join("meshes"), fill)
    }

    /// Writes the bytes of a surface beside its place: they may turn out to be none. Blocks.
    pub(crate) fn write_surface(&self, fill: impl FnOnce(&mut Put<'_>) -> Written) -> MadePart {
        Part::write(&self.folder().join("surfaces"), fill)
    }

    /// Gives a mesh its place. Blocks.
    pub(crate) fn keep_mesh(&self, part: Part, id: MeshId) -> Result<(), JournalError> {
        part.keep(&self.mesh_file(id))
    }

    /// Gives a surface its place. Blocks.
    pub(crate) fn keep_surface(&self, part: Part, digest: &str) -> Result<(), JournalError> {
        part.keep(&self.surface_file(digest))
    }

    fn mesh_file(&self, id: MeshId) -> PathBuf {
        self.folder().join("meshes").join(id.to_string())
    }

    /// The digest is one that this server has computed, or found in its form.
    fn surface_file(&self, digest: &str) -> PathBuf {
        self.folder().join("surfaces").join(digest)
    }
}
