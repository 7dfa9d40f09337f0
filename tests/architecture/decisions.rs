//! Decisions say whether they hold, and name what is there.

use std::fs;
use std::path::Path;

use super::workspace;

/// What the third line of a decision begins with.
const STATUS: [&str; 3] = ["**Holds", "**Replaced by decision", "**Open"];

/// What stands behind the name of something that is no more.
const GONE: &str = ", deleted";

fn pages() -> Vec<(String, String)> {
    let entries = fs::read_dir(workspace().join("src/decisions")).expect("the folder is readable");
    let paths = entries.map(|entry| entry.expect("the entry is readable").path());
    let mut pages: Vec<(String, String)> = paths
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy();
            let text = fs::read_to_string(&path).expect("the page is readable");
            (name.into_owned(), text)
        })
        .collect();
    pages.sort();
    pages
}

#[test]
fn every_decision_says_whether_it_holds() {
    let pages = pages();
    let says = |text: &str| {
        let status = text.lines().nth(2).unwrap_or_default();
        STATUS.iter().any(|word| status.starts_with(word))
    };
    let silent = pages.iter().filter(|(_, text)| !says(text));
    let silent: Vec<&str> = silent.map(|(name, _)| name.as_str()).collect();
    assert!(silent.is_empty(), "{silent:?}");
}

/// Spans between backticks, each with whether it is marked as gone.
fn spans(page: &str) -> Vec<(&str, bool)> {
    let prose = page.split("```").step_by(2);
    prose
        .flat_map(|part| {
            let pieces: Vec<&str> = part.split('`').collect();
            let spans = (1..pieces.len()).step_by(2).map(move |at| {
                let after = pieces.get(at + 1).copied().unwrap_or_default();
                (pieces[at], after.starts_with(GONE))
            });
            spans.collect::<Vec<_>>()
        })
        .collect()
}

/// Whether the file that `span` names is there; none where it names no file of ours.
fn has_file(span: &str) -> Option<bool> {
    let (first, _) = span.split_once('/')?;
    let ours = ["client", "deploy", "proto", "server", "src", "tests"];
    let is_path = span
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
    (ours.contains(&first) && is_path).then(|| workspace().join(span).exists())
}

/// Whether the library has the module and the names in it that `span` says; none where it
/// does not begin with a room.
pub(crate) fn has_item(span: &str) -> Option<bool> {
    let parts: Vec<&str> = span.split("::").collect();
    let mut at = workspace().join("src");
    if parts.len() < 2 || !at.join(parts[0]).is_dir() {
        return None;
    }
    let modules = parts.iter().take_while(|part| {
        let next = at.join(part);
        let is_module = next.is_dir() || next.with_extension("rs").exists();
        at = if is_module { next } else { at.clone() };
        is_module
    });
    let rest = &parts[modules.count()..];
    let text = module_text(&at);
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    let words: Vec<&str> = words.collect();
    Some(rest.iter().all(|name| words.contains(name)))
}

/// What the files of the module at `path` say.
fn module_text(path: &Path) -> String {
    let mut text = fs::read_to_string(path.with_extension("rs")).unwrap_or_default();
    if path.is_dir() {
        let mut files = Vec::new();
        super::sources(path, &mut files);
        text.extend(
            files
                .iter()
                .filter_map(|file| fs::read_to_string(file).ok()),
        );
    }
    text
}

#[test]
fn decisions_name_what_is_there_or_say_that_it_is_gone() {
    let (mut faults, mut count) = (Vec::new(), 0);
    for (name, text) in &pages() {
        for (span, is_gone) in spans(text) {
            let Some(is_there) = has_file(span).or_else(|| has_item(span)) else {
                continue;
            };
            count += 1;
            if is_there == is_gone {
                faults.push(format!("{name}: `{span}`"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count >= 30, "{count}");
}
