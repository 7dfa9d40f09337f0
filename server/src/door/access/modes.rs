//! Files that others than their owner may read or change, though they say who comes in.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use crate::config::Config;

/// What nobody but the owner may: all of others, and to write of the group, which may be that of
/// a server that reads a key.
const LOOSE: u32 = 0o027;

/// A sentence for each token file and key whose mode lets others in.
pub(crate) fn loose(config: &Config) -> Vec<String> {
    let tls = config.tls_files();
    let key = tls.as_ref().map(|files| ("tls_key", files.key.as_path()));
    let tokens = config.token_file().map(|file| ("tokens", file));
    let told = |(key, file): (&str, &Path)| {
        // One that cannot be looked at is told where it is read.
        let mode = std::fs::metadata(file).ok()?.permissions().mode() & 0o777;
        let (file, wanted) = (file.display(), mode & !LOOSE);
        (mode & LOOSE != 0).then(|| {
            format!(
                "{key}: {file} has the mode {mode:04o}: others than its owner may read or change \
                 it; `chmod {wanted:o} {file}`"
            )
        })
    };
    tokens.into_iter().chain(key).filter_map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_others_may_read_or_change_are_told_with_what_to_do() {
        let folder = std::env::temp_dir().join(format!("signorini-modes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("tokens.toml");
        std::fs::write(&path, "").unwrap();
        let config = Config {
            tokens: path.display().to_string(),
            ..Config::embedded()
        };
        let with = |mode| {
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(&path, permissions).unwrap();
            loose(&config).pop()
        };
        for good in [0o600, 0o400, 0o640] {
            assert_eq!(with(good), None, "{good:o}");
        }
        for bad in [0o666, 0o644, 0o660, 0o604, 0o602] {
            let told = with(bad).unwrap();
            let cure = format!("chmod {:o}", bad & 0o750);
            assert!(told.contains("tokens: ") && told.contains(&cure), "{told}");
        }
        assert!(loose(&Config::embedded()).is_empty());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
