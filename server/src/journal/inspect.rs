//! A data folder that no server uses, looked at piece by piece.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::JournalError;
use super::layout::DATABASE_FILE;
use super::{PARTS, Stored, database, guarded, layout};

/// What is in a data folder.
pub(crate) struct Inspection {
    /// Whether every page of the database is as it was written.
    pub(crate) is_sound: bool,
    /// Each session by name, or why it cannot be read.
    pub(crate) sessions: Vec<(String, Result<Stored, JournalError>)>,
    /// Names of the meshes in the database.
    pub(crate) meshes: Vec<String>,
    /// Names of the surfaces of tools in the database.
    pub(crate) surfaces: Vec<String>,
    /// Digests of the states in the database.
    pub(crate) states: Vec<String>,
    /// Files of meshes, of states and of surfaces.
    pub(crate) files: [Vec<PathBuf>; 3],
    /// Bytes of everything.
    pub(crate) bytes: u64,
}

/// Looks at a folder; changes nothing but what a crash has left half done.
pub(crate) fn inspect(folder: &Path) -> Result<Inspection, JournalError> {
    layout::check(folder)?;
    let path = folder.join(DATABASE_FILE);
    let mut open = database::open(&path)?;
    let is_sound = guarded(|| Ok(open.check_integrity().unwrap_or(false))).unwrap_or(false);
    let names = guarded(|| database::names(&open))?;
    let load = |name: String| {
        let missing = || JournalError::Damaged("it is listed and not there".to_owned());
        let stored = guarded(|| database::load(&open, &name)?.ok_or_else(missing));
        (name, stored)
    };
    let sessions = names.into_iter().map(load).collect();
    let meshes = names_of(guarded(|| database::meshes(&open))?);
    let surfaces = names_of(guarded(|| database::surfaces(&open))?);
    let states = names_of(guarded(|| database::states(&open))?);
    let [of_meshes, of_states, of_surfaces] = PARTS.map(|part| list(&folder.join(part)));
    let files = [of_meshes?, of_states?, of_surfaces?];
    let all = files.iter().flatten().chain([&path]);
    let bytes = all
        .filter_map(|file| fs::metadata(file).ok())
        .map(|data| data.len())
        .sum();
    Ok(Inspection {
        is_sound,
        sessions,
        meshes,
        surfaces,
        states,
        files,
        bytes,
    })
}

fn names_of<T>(entries: Vec<(String, T)>) -> Vec<String> {
    entries.into_iter().map(|(name, _)| name).collect()
}

/// Files of a folder, which a build that stored nothing of the kind has not made.
fn list(folder: &Path) -> Result<Vec<PathBuf>, JournalError> {
    let wrong = |error: std::io::Error| JournalError::at(folder, &error);
    let mut found = Vec::new();
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(found),
        entries => entries.map_err(wrong)?,
    };
    for entry in entries {
        let path = entry.map_err(wrong)?.path();
        if path.extension().is_none() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
