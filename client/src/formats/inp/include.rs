//! Files that a deck includes (`*INCLUDE, INPUT=`, `*NODE, INPUT=`, ...), put where they are named.
//!
//! A name is a path below the folder of the deck: neither absolute nor with `..`. Depth and the
//! size of all together are bounded, and no file includes itself. Where each line came from is
//! kept, so that faults are told with their file.

use std::path::{Component, Path};

use super::cards::{Cards, Keyword};
use super::error::{InpError, InpFault};

/// Files within files, at most.
const DEEPEST: usize = 8;
/// Bytes of all files that a deck includes, at most.
const MOST: usize = 8 << 30;
/// Files that are included, at most, those that are twice counted twice.
const MOST_FILES: usize = 1000;
/// Keywords whose files hold parts of a mesh.
const READ: [&str; 6] = ["INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"];

/// Reads a file beside the deck by its name; what is wrong where it cannot.
pub type ReadBeside<'r> = dyn FnMut(&Path) -> Result<Vec<u8>, String> + 'r;

/// Lines of one file that stand one after another.
struct Stretch {
    /// The first line in the text, from 1.
    at: usize,
    /// Index of the file; none of the deck.
    file: Option<usize>,
    /// The same line in its file, from 1.
    line: usize,
}

/// The file that a keyword of a mesh names.
pub(super) fn file_of(keyword: &Keyword) -> Option<&str> {
    let name = keyword.value("INPUT")?;
    READ.contains(&keyword.name.as_str()).then_some(name)
}

/// A deck with what it includes.
#[derive(Default)]
pub(super) struct Expanded {
    pub(super) bytes: Vec<u8>,
    lines: usize,
    stretches: Vec<Stretch>,
    files: Vec<String>,
    /// Bytes of the files.
    size: usize,
}

impl Expanded {
    /// The text of a deck and of its files.
    pub(super) fn of(deck: &[u8], read: &mut ReadBeside<'_>) -> Result<Self, InpError> {
        let mut expanded = Self::default();
        expanded.add(deck, &mut Vec::new(), read)?;
        Ok(expanded)
    }

    /// Adds a file, the last of `open`, those that it is within before it.
    fn add(
        &mut self,
        bytes: &[u8],
        open: &mut Vec<usize>,
        read: &mut ReadBeside<'_>,
    ) -> Result<(), InpError> {
        let mut cards = Cards::new(bytes);
        let (mut from, mut line) = (0, 1);
        while let Some(keyword) = cards.keyword() {
            let Some(name) = file_of(&keyword) else {
                continue;
            };
            let (end, next) = (cards.taken(), cards.line + 1);
            // The keyword of an inclusion is no keyword of the deck, that of nodes is.
            let to = if keyword.name == "INCLUDE" {
                keyword.start
            } else {
                end
            };
            self.push(
                bytes.get(from..to).unwrap_or_default(),
                line,
                open.last().copied(),
            );
            (from, line) = (end, next);
            let content = self.read(name, open, read).map_err(|said| {
                let file = name.to_owned();
                let mut error = keyword.error(InpFault::NotIncluded { file, said });
                error.file = open.last().and_then(|at| self.files.get(*at)).cloned();
                error
            })?;
            self.size += content.len();
            self.files.push(name.to_owned());
            open.push(self.files.len() - 1);
            self.add(&content, open, read)?;
            open.pop();
        }
        self.push(
            bytes.get(from..).unwrap_or_default(),
            line,
            open.last().copied(),
        );
        Ok(())
    }

    /// The content of a file; what is wrong with it.
    fn read(
        &self,
        name: &str,
        open: &[usize],
        read: &mut ReadBeside<'_>,
    ) -> Result<Vec<u8>, String> {
        let mut around = open.iter().filter_map(|at| self.files.get(*at));
        if around.any(|file| file == name) {
            return Err("it includes itself".to_owned());
        }
        if open.len() >= DEEPEST {
            return Err(format!("files are within files {DEEPEST} deep already"));
        }
        if self.files.len() >= MOST_FILES {
            return Err(format!("{MOST_FILES} files are included already"));
        }
        let path = beside(name)
            .ok_or("its name must be a path beside the deck, neither absolute nor with ..")?;
        let content = read(path)?;
        if self.size + content.len() > MOST {
            return Err(format!("the files have more than {MOST} bytes in all"));
        }
        Ok(content)
    }

    /// Adds whole lines of a file, the first of which has this number there.
    fn push(&mut self, bytes: &[u8], line: usize, file: Option<usize>) {
        let at = self.lines + 1;
        self.stretches.push(Stretch { at, file, line });
        self.bytes.extend(bytes);
        if !bytes.is_empty() && !bytes.ends_with(b"\n") {
            self.bytes.push(b'\n');
        }
        let breaks = bytes.iter().filter(|byte| **byte == b'\n').count();
        let is_cut = !bytes.is_empty() && !bytes.ends_with(b"\n");
        self.lines += breaks + usize::from(is_cut);
    }

    /// A fault with the file and the line there.
    pub(super) fn located(&self, mut error: InpError) -> InpError {
        if let Some(line) = error.line {
            let after = self.stretches.partition_point(|stretch| stretch.at <= line);
            if let Some(stretch) = after.checked_sub(1).and_then(|at| self.stretches.get(at)) {
                error.line = Some(stretch.line + line - stretch.at);
                error.file = stretch.file.and_then(|at| self.files.get(at)).cloned();
            }
        }
        error
    }
}

/// The path of a name that lies below the folder of the deck.
fn beside(name: &str) -> Option<&Path> {
    let path = Path::new(name);
    let is_below = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    let foreign = name.contains(['\\', ':', '\0']);
    (!name.is_empty() && !foreign && path.components().all(is_below)).then_some(path)
}
