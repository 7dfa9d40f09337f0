//! A page of the manual: its sections, tables, code spans and snippets.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Pages that are not in the folder of the manual.
const BESIDE: [&str; 5] = [
    "../../README.md",
    "../../deploy/README.md",
    "../cpp/README.md",
    "../examples/README.md",
    "../python/README.md",
];

/// A page, or a part of one.
#[derive(Clone)]
pub(super) struct Page {
    pub(super) name: String,
    pub(super) text: String,
}

/// A fenced block.
pub(super) struct Snippet {
    pub(super) language: String,
    pub(super) text: String,
}

pub(super) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("manual")
}

impl Page {
    pub(super) fn read(name: &str) -> Self {
        let path = folder().join(name);
        let text = fs::read_to_string(&path)
            .unwrap_or_else(|error| unreachable!("{}: {error}", path.display()));
        let name = name.to_owned();
        Self { name, text }
    }

    /// Every page, and what people read beside the manual.
    pub(super) fn all() -> Vec<Self> {
        let entries = fs::read_dir(folder()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
        names.extend(BESIDE.map(str::to_owned));
        names.iter().map(|name| Self::read(name)).collect()
    }

    /// What stands under the heading for which `is_meant` holds, to the next of any depth.
    pub(super) fn section(&self, what: &str, is_meant: impl Fn(&str) -> bool) -> Self {
        self.part("#", what, is_meant)
    }

    /// The same with the sections that lie deeper.
    pub(super) fn chapter(&self, what: &str, is_meant: impl Fn(&str) -> bool) -> Self {
        self.part("## ", what, is_meant)
    }

    /// What stands between headings that begin with `mark`.
    fn part(&self, mark: &str, what: &str, is_meant: impl Fn(&str) -> bool) -> Self {
        let is_heading = |line: &&str| line.starts_with(mark);
        let mut lines = self.text.lines();
        let found = lines
            .by_ref()
            .find(|line| is_heading(line) && is_meant(line.trim_start_matches('#').trim()));
        assert!(found.is_some(), "{} has no part on {what}", self.name);
        let text: Vec<&str> = lines.take_while(|line| !is_heading(line)).collect();
        Self {
            name: format!("{}, {what}", self.name),
            text: text.join("\n"),
        }
    }

    /// Text between backticks, without that of snippets.
    pub(super) fn spans(&self) -> Vec<String> {
        let prose = self.text.split("```").step_by(2);
        let spans = prose.flat_map(|part| part.split('`').skip(1).step_by(2));
        spans.map(str::to_owned).collect()
    }

    /// Words between backticks.
    pub(super) fn words(&self) -> BTreeSet<String> {
        self.spans().iter().flat_map(|span| words(span)).collect()
    }

    /// Text between backticks in the first cells of tables.
    pub(super) fn first_cells(&self) -> Vec<String> {
        let rows = self.text.lines().filter(|line| line.starts_with('|'));
        let cells = rows.filter_map(|row| row.split('|').nth(1));
        let spans = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
        spans.map(str::to_owned).collect()
    }

    pub(super) fn snippets(&self) -> Vec<Snippet> {
        let blocks = self.text.split("```").skip(1).step_by(2);
        let snippet = |block: &str| {
            let (language, text) = block.split_once('\n').unwrap_or((block, ""));
            Snippet {
                language: language.trim().to_owned(),
                text: text.to_owned(),
            }
        };
        blocks.map(snippet).collect()
    }
}

/// Names in small letters: keys, fields and the like.
pub(super) fn words(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    let words = text.split(|c| !is_part(c)).filter(|word| !word.is_empty());
    let is_name = |word: &&str| word.chars().any(|c| c.is_ascii_lowercase());
    words.filter(is_name).map(str::to_owned).collect()
}
