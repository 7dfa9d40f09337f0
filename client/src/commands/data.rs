//! `backup`, `restore`, `fsck` and `doctor`: the data folder of a server, and the machine under it.

use std::path::Path;

use signorini_server::{BackupError, Copying, JournalError};

use crate::terminal::exit::{Exit, Failure};
use crate::terminal::stdout;

pub(super) fn backup(data: &Path, target: &Path, copying: Copying) -> Result<Exit, Failure> {
    signorini_server::backup(data, target, copying).map_err(failure)?;
    stdout::print(&format!("{}\n", target.display()))?;
    Ok(Exit::Ok)
}

pub(super) fn restore(backup: &Path, data: &Path) -> Result<Exit, Failure> {
    let restored = signorini_server::restore(backup, data).map_err(failure)?;
    stdout::print(&restored.to_string())?;
    Ok(Exit::Ok)
}

pub(super) fn fsck(folder: &Path) -> Result<Exit, Failure> {
    let wrong = |error: JournalError| Failure::new(exit_of(&error), error.to_string());
    let found = signorini_server::fsck(folder).map_err(wrong)?;
    stdout::print(&found.to_string())?;
    Ok(if found.faults.is_empty() {
        Exit::Ok
    } else {
        Exit::Server
    })
}

pub(super) fn doctor(folder: &Path, proxy: Option<&Path>) -> Result<Exit, Failure> {
    let found = signorini_server::doctor(folder, proxy);
    stdout::print(&found.to_string())?;
    Ok(if found.is_fit() {
        Exit::Ok
    } else {
        Exit::Server
    })
}

/// A faulty backup and a server that refuses are faults of theirs; the rest is a folder
/// that was named wrongly or cannot be written.
fn failure(error: BackupError) -> Failure {
    let exit = match &error {
        BackupError::Refused(_) | BackupError::Faulty(_) => Exit::Server,
        BackupError::Data(error) => exit_of(error),
        BackupError::Copy { .. } => Exit::Usage,
    };
    Failure::new(exit, error.to_string())
}

/// A damaged folder is a fault of its own, like those that `fsck` lists.
fn exit_of(error: &JournalError) -> Exit {
    match error {
        JournalError::Damaged(_) => Exit::Server,
        JournalError::Elsewhere(_)
        | JournalError::Folder { .. }
        | JournalError::InUse(_)
        | JournalError::Version { .. }
        | JournalError::Unwritable(_) => Exit::Usage,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_folder_is_no_wrong_usage() {
        let damaged = JournalError::Damaged("no journal".to_owned());
        assert_eq!(exit_of(&damaged), Exit::Server);
        let taken = JournalError::InUse("data".to_owned());
        assert_eq!(exit_of(&taken), Exit::Usage);
    }
}
