//! Whether the data folder is still where the server found it: a process goes on writing to files
//! that somebody has deleted or moved, and the next start does not find them.

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::layout::DATABASE_FILE;

/// Device and number of a file.
type Identity = (u64, u64);

/// What the last look at the folder found.
pub(crate) struct Presence {
    paths: [PathBuf; 2],
    found: [Option<Identity>; 2],
    is_gone: AtomicBool,
}

impl Presence {
    /// That of a data folder which is open.
    pub(crate) fn of(folder: &Path) -> Self {
        let paths = [folder.to_owned(), folder.join(DATABASE_FILE)];
        let found = paths.each_ref().map(|path| identity(path));
        Self {
            paths,
            found,
            is_gone: AtomicBool::new(false),
        }
    }

    /// Looks at the folder and its database; what is new, if anything: that it is gone (true) or
    /// back (false). Blocks.
    pub(crate) fn look(&self) -> Option<bool> {
        let now = self.paths.each_ref().map(|path| identity(path));
        let is_gone = now != self.found;
        let was_gone = self.is_gone.swap(is_gone, Ordering::SeqCst);
        (is_gone != was_gone).then_some(is_gone)
    }

    /// What a client is told whose update would be lost; none while the folder is there.
    pub(crate) fn lost(&self) -> Option<String> {
        let [folder, _] = &self.paths;
        let told = || {
            format!(
                "the data folder {} was deleted or moved: put it back, or start the server again",
                folder.display()
            )
        };
        self.is_gone.load(Ordering::SeqCst).then(told)
    }
}

fn identity(path: &Path) -> Option<Identity> {
    let found = std::fs::metadata(path).ok()?;
    Some((found.dev(), found.ino()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_goes_and_comes_back_is_told_once_each_time() {
        let base = std::env::temp_dir().join(format!("signorini-presence-{}", std::process::id()));
        let [folder, away] = ["data", "away"].map(|name| base.join(name));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(DATABASE_FILE), "x").unwrap();
        let presence = Presence::of(&folder);
        assert_eq!((presence.look(), presence.lost()), (None, None));
        std::fs::rename(&folder, &away).unwrap();
        assert_eq!(presence.look(), Some(true));
        assert_eq!(presence.look(), None);
        let told = presence.lost().unwrap();
        assert!(told.contains(folder.to_str().unwrap()), "{told}");
        // Another one in its place is not it.
        std::fs::create_dir(&folder).unwrap();
        assert_eq!(presence.look(), None);
        std::fs::remove_dir(&folder).unwrap();
        std::fs::rename(&away, &folder).unwrap();
        assert_eq!((presence.look(), presence.lost()), (Some(false), None));
        std::fs::remove_file(folder.join(DATABASE_FILE)).unwrap();
        assert_eq!(presence.look(), Some(true));
        std::fs::remove_dir_all(&base).unwrap();
    }
}
