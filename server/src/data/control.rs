//! Backups: of a running server through a socket in its data folder, which only the
//! folder's owner reaches, or of a folder that no server uses.
//!
//! A client of the socket chooses no name: it says `copy` or `link`, the server writes the copy
//! into its own folder and says where, and the client takes it away.

use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{fs, process};

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::UnixListener;

use crate::data::fsck::{Fsck, fsck};
use crate::journal::{
    Copying, Journal, JournalError, close_file, copy_bytes, make_folder, sync_folder,
};

const SOCKET: &str = "control";
const BACKUPS: &str = "backups";
/// What a client says that wants second names of the files.
const LINK: &str = "link\n";
/// One that says nothing, as an earlier build did, gets a copy after this time.
const SILENCE: Duration = Duration::from_secs(1);

/// Why there is no copy of a data folder.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// A folder does not serve.
    #[error(transparent)]
    Data(#[from] JournalError),
    /// The running server refused.
    #[error("the server says: {0}")]
    Refused(String),
    /// A copy cannot be written or read.
    #[error("{path}: {why}")]
    Copy {
        /// What was copied.
        path: String,
        /// What the system said.
        why: String,
    },
    /// What is to be restored has faults.
    #[error("not restored, because the backup is faulty\n{0}")]
    Faulty(Fsck),
}

fn wrong(path: &Path, why: &dyn std::fmt::Display) -> BackupError {
    BackupError::Copy {
        path: path.display().to_string(),
        why: why.to_string(),
    }
}

/// Serves backups until it is aborted.
pub(crate) async fn serve(journal: Arc<Journal>) {
    let path = journal.folder().join(SOCKET);
    // One that a killed server left; the lock on the folder says that it is ours.
    let _left = fs::remove_file(&path);
    let bound = UnixListener::bind(&path).and_then(|bound| close_file(&path).map(|()| bound));
    let listener = match bound {
        Ok(listener) => listener,
        Err(why) => {
            tracing::warn!(why = why.to_string(), "no backups of the running server");
            return;
        }
    };
    loop {
        let Ok((mut stream, _)) = listener.accept().await else {
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        // What waits to be written is in it too; a disk that is full can be copied.
        if let Err(why) = journal.store("", Vec::new()).await {
            tracing::warn!(
                why = why.to_string(),
                "the backup has what was written before"
            );
        }
        let (made, copying) = (journal.clone(), wanted(&mut stream).await);
        let made = tokio::task::spawn_blocking(move || copy(&made, copying)).await;
        let answer = match made {
            Ok(Ok(path)) => format!("ok {}\n", path.display()),
            Ok(Err(why)) => format!("error {why}\n"),
            Err(_) => "error a defect of the server\n".to_owned(),
        };
        tracing::info!(answer = answer.trim_end(), "backup");
        // A client that left may come again.
        let _left = stream.write_all(answer.as_bytes()).await;
    }
}

/// What the client of the socket says.
async fn wanted(stream: &mut tokio::net::UnixStream) -> Copying {
    let mut said = [0; LINK.len()];
    let read = tokio::time::timeout(SILENCE, stream.read_exact(&mut said)).await;
    match read {
        Ok(Ok(_)) if said == LINK.as_bytes() => Copying::Links,
        Ok(_) | Err(_) => Copying::Bytes,
    }
}

fn copy(journal: &Journal, copying: Copying) -> Result<PathBuf, JournalError> {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let backups = journal.folder().join(BACKUPS);
    make_folder(&backups)?;
    let target = backups.join(format!("{}-{}", now.as_nanos(), process::id()));
    journal.backup(&target, copying)?;
    Ok(target)
}

/// Copies the data folder `data`, of a running server or none, into `target`.
///
/// # Errors
/// [`BackupError`]; `target` is then not there.
pub fn backup(data: &Path, target: &Path, copying: Copying) -> Result<(), BackupError> {
    if target.exists() {
        return Err(wrong(target, &"exists already"));
    }
    let Ok(mut stream) = UnixStream::connect(data.join(SOCKET)) else {
        fsck(data)?;
        return Ok(Journal::copy(data, target, copying)?);
    };
    let said = match copying {
        Copying::Bytes => "copy\n",
        Copying::Links => LINK,
    };
    stream
        .write_all(said.as_bytes())
        .map_err(|error| wrong(data, &error))?;
    let mut answer = String::new();
    let mut reader = BufReader::new(stream);
    reader
        .read_line(&mut answer)
        .map_err(|error| wrong(data, &error))?;
    match answer.trim_end().split_once(' ') {
        Some(("ok", made)) => take_away(Path::new(made), target),
        Some((_, why)) => Err(BackupError::Refused(why.to_owned())),
        None => Err(BackupError::Refused("nothing".to_owned())),
    }
}

/// Makes the data folder `data`, which must not exist, from a backup without faults.
///
/// # Errors
/// [`BackupError`]; `data` is then not there.
pub fn restore(backup: &Path, data: &Path) -> Result<Fsck, BackupError> {
    let found = fsck(backup)?;
    if !found.faults.is_empty() {
        return Err(BackupError::Faulty(found));
    }
    if data.exists() {
        return Err(wrong(data, &"exists already"));
    }
    copy_whole(backup, data)?;
    // What was made is looked at, not only what it was made from.
    let made = fsck(data)?;
    if made.faults.is_empty() {
        Ok(made)
    } else {
        fs::remove_dir_all(data).map_err(|error| wrong(data, &error))?;
        Err(BackupError::Faulty(made))
    }
}

/// Moves a folder, by its bytes where it cannot get another name.
fn take_away(made: &Path, target: &Path) -> Result<(), BackupError> {
    if fs::rename(made, target).is_ok() {
        let synced = sync_folder(target).and_then(|()| sync_folder(made));
        return synced.map_err(|error| wrong(target, &error));
    }
    copy_whole(made, target)?;
    fs::remove_dir_all(made).map_err(|error| wrong(made, &error))
}

/// Copies a folder beside its place, and moves it there when the disk has it.
fn copy_whole(from: &Path, to: &Path) -> Result<(), BackupError> {
    let beside = to.with_extension("part");
    copy_folder(from, &beside)?;
    let moved = fs::rename(&beside, to).and_then(|()| sync_folder(to));
    moved.map_err(|error| wrong(to, &error))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), BackupError> {
    make_folder(to)?;
    let entries = fs::read_dir(from).map_err(|error| wrong(from, &error))?;
    for entry in entries {
        let entry = entry.map_err(|error| wrong(from, &error))?;
        let copy = to.join(entry.file_name());
        let kind = entry.file_type().map_err(|error| wrong(from, &error))?;
        if kind.is_dir() && entry.file_name() != BACKUPS {
            copy_folder(&entry.path(), &copy)?;
        } else if kind.is_file() {
            copy_bytes(&entry.path(), &copy).map_err(|error| wrong(&copy, &error))?;
        }
    }
    let synced = fs::File::open(to).and_then(|folder| folder.sync_all());
    synced.map_err(|error| wrong(to, &error))
}
