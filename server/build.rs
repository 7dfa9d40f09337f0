//! Records the commit of a release build for `signorini_build_info` and the log.
//!
//! From `SIGNORINI_COMMIT` (a build without its repository, such as a container's),
//! else from what cargo puts into a published package, else from git. Other builds
//! record none: they would be built anew with every commit.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-env-changed=SIGNORINI_COMMIT");
    println!("cargo:rerun-if-changed=build.rs");
    let commit = named().or_else(|| match std::env::var("PROFILE").as_deref() {
        Ok("release") => published().or_else(of_git),
        _ => None,
    });
    let commit = commit.unwrap_or_else(|| "unknown".to_owned());
    println!("cargo:rustc-env=SIGNORINI_COMMIT={commit}");
}

fn named() -> Option<String> {
    let named = std::env::var("SIGNORINI_COMMIT").ok()?;
    (!named.trim().is_empty()).then(|| short(&named))
}

/// The commit in the file that cargo adds to packages.
fn published() -> Option<String> {
    let text = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, rest) = text.split_once("\"sha1\": \"")?;
    rest.split('"').next().map(short)
}

fn of_git() -> Option<String> {
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["rev-parse", "HEAD"]).map(|commit| short(&commit))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Twelve characters of a hash, which is what people compare.
fn short(commit: &str) -> String {
    let plain = commit.chars().filter(char::is_ascii_alphanumeric);
    plain.take(12).collect()
}
