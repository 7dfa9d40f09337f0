//! The files of a crate as modules, and which file uses what another one defines.
//!
//! Paths are followed through `mod.rs`: a name that it only passes on belongs to
//! the file that defines it. A file may use whatever the modules that it lies in
//! define, and a `mod.rs` may pass on what its own files define; neither counts.
//! A module written out in a file, `mod name { .. }`, reads its names as a module of
//! its own; what it uses counts for its file.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::tokens;

/// Names that pass from file to file before a path counts as lost.
const LONGEST_WAY: usize = 16;

struct Import {
    path: Vec<String>,
    /// Its name here; `None` for a glob.
    name: Option<String>,
    is_public: bool,
}

struct Module {
    file: PathBuf,
    /// The module whose file this is: another one's if it is written out in that file.
    home: usize,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    imports: Vec<Import>,
    /// Paths written out where they are used.
    paths: Vec<Vec<String>>,
}

/// The modules of one crate; the first is its root.
pub(crate) struct Tree(Vec<Module>);

impl Tree {
    /// Reads the crate whose root is the file `root`, without its tests.
    pub(crate) fn read(root: &Path) -> Self {
        let mut tree = Self(Vec::new());
        tree.add(Source::read(root), None);
        tree
    }

    /// Files of the modules, by their numbers.
    pub(crate) fn file(&self, module: usize) -> &Path {
        &self.0[module].file
    }

    /// For each module the modules that define what its file uses; nothing for one that
    /// has no file of its own.
    pub(crate) fn uses(&self) -> Vec<BTreeSet<usize>> {
        let mut uses = vec![BTreeSet::new(); self.0.len()];
        for module in 0..self.0.len() {
            let home = self.0[module].home;
            let used = self.used(module).into_iter();
            let files = used.map(|used| self.0[used].home);
            uses[home].extend(files.filter(|file| *file != home));
        }
        uses
    }

    /// Names of the modules below the root, each with all that lies in it, and for
    /// each the others that it uses.
    pub(crate) fn rooms(&self) -> (Vec<String>, Vec<BTreeSet<usize>>) {
        let (names, tops): (Vec<String>, Vec<usize>) =
            self.0[0].children.clone().into_iter().unzip();
        let room = |module| tops.iter().position(|top| self.is_inside(module, *top));
        let mut edges = vec![BTreeSet::new(); tops.len()];
        for (module, used) in self.uses().into_iter().enumerate() {
            let Some(from) = room(module) else { continue };
            let targets = used.into_iter().filter_map(room);
            edges[from].extend(targets.filter(|to| *to != from));
        }
        (names, edges)
    }

    fn add(&mut self, source: Source, parent: Option<usize>) -> usize {
        let number = self.0.len();
        let (words, inner) = written_out(&source.words);
        self.0.push(Module {
            home: parent
                .filter(|_| source.is_inline)
                .map_or(number, |parent| self.0[parent].home),
            file: source.file.clone(),
            parent,
            children: BTreeMap::new(),
            imports: imports(&words),
            paths: paths(&words),
        });
        let files = declared(&words)
            .into_iter()
            .map(|name| (source.child(&name), name));
        let inner = inner
            .into_iter()
            .map(|(name, words)| (source.inline(&name, words), name));
        for (child, name) in files.chain(inner) {
            let child = self.add(child, Some(number));
            self.0[number].children.insert(name, child);
        }
        number
    }

    fn used(&self, module: usize) -> BTreeSet<usize> {
        let own = &self.0[module];
        let imported = own.imports.iter().filter_map(|import| {
            let target = self.resolve(module, &import.path, LONGEST_WAY)?;
            let passed_on = import.is_public && self.is_inside(target, module);
            (!passed_on).then_some(target)
        });
        let written = own.paths.iter().filter_map(|path| {
            let first = path.first()?;
            let known = ["crate", "self", "super"].contains(&first.as_str())
                || own.children.contains_key(first);
            known.then(|| self.resolve(module, path, LONGEST_WAY))?
        });
        let all = imported.chain(written);
        all.filter(|target| !self.is_inside(module, *target))
            .collect()
    }

    /// Whether `inner` is `outer` or lies below it.
    fn is_inside(&self, inner: usize, outer: usize) -> bool {
        inner == outer
            || self.0[inner]
                .parent
                .is_some_and(|parent| self.is_inside(parent, outer))
    }

    /// The module that defines what `path` names in the module `from`; none for
    /// another crate's.
    fn resolve(&self, from: usize, path: &[String], way: usize) -> Option<usize> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.walk(0, rest, way),
            "self" => self.walk(from, rest, way),
            "super" => self.walk(self.0[from].parent?, rest, way),
            name if self.0[from].children.contains_key(name) => self.walk(from, path, way),
            name => self.follow(from, name, rest, way),
        }
    }

    fn walk(&self, mut at: usize, path: &[String], way: usize) -> Option<usize> {
        for (index, name) in path.iter().enumerate() {
            if name == "super" {
                at = self.0[at].parent?;
            } else if let Some(child) = self.0[at].children.get(name) {
                at = *child;
            } else {
                let passed_on = self.follow(at, name, &path[index + 1..], way);
                return passed_on.or(Some(at));
            }
        }
        Some(at)
    }

    /// The way of a `name` that the module `at` imports.
    fn follow(&self, at: usize, name: &str, rest: &[String], way: usize) -> Option<usize> {
        let named = |import: &&Import| import.name.as_deref() == Some(name);
        let import = self.0[at].imports.iter().find(named)?;
        let path: Vec<String> = import.path.iter().chain(rest).cloned().collect();
        self.resolve(at, &path, way.checked_sub(1)?)
    }
}

/// The words of a module and where those that it declares have their files.
struct Source {
    file: PathBuf,
    folder: PathBuf,
    words: Vec<String>,
    /// Whether it is written out in the file of another one.
    is_inline: bool,
}

impl Source {
    fn read(file: &Path) -> Self {
        let text = fs::read_to_string(file).expect("the module's file is readable");
        let folder = file.parent().expect("a file lies in a folder");
        let stem = file.file_stem().expect("a file has a name");
        Self {
            file: file.to_owned(),
            folder: match stem.to_str() {
                Some("lib" | "main" | "mod") => folder.to_owned(),
                _ => folder.join(stem),
            },
            words: tokens::production(&text),
            is_inline: false,
        }
    }

    /// The source of `mod name;`.
    fn child(&self, name: &str) -> Self {
        let flat = self.folder.join(format!("{name}.rs"));
        if flat.exists() {
            Self::read(&flat)
        } else {
            Self::read(&self.folder.join(name).join("mod.rs"))
        }
    }

    /// The source of `mod name { words }`.
    fn inline(&self, name: &str, words: Vec<String>) -> Self {
        Self {
            file: self.file.clone(),
            folder: self.folder.join(name),
            words,
            is_inline: true,
        }
    }
}

/// The words outside the modules that are written out, and those modules: name and words.
fn written_out(words: &[String]) -> (Vec<String>, Vec<(String, Vec<String>)>) {
    let (mut own, mut inner, mut at) = (Vec::new(), Vec::new(), 0);
    while at < words.len() {
        let is_module = words[at] == "mod" && words.get(at + 2).is_some_and(|word| word == "{");
        if is_module {
            let end = closing_brace(words, at + 2);
            inner.push((words[at + 1].clone(), words[at + 3..end].to_vec()));
            at = end + 1;
        } else {
            own.push(words[at].clone());
            at += 1;
        }
    }
    (own, inner)
}

/// Place of the brace that closes the one at `open`.
fn closing_brace(words: &[String], open: usize) -> usize {
    let mut depth = 0_usize;
    for (at, word) in words.iter().enumerate().skip(open) {
        match word.as_str() {
            "{" => depth += 1,
            "}" if depth == 1 => return at,
            "}" => depth -= 1,
            _ => {}
        }
    }
    words.len()
}

/// Names of modules with files of their own.
fn declared(words: &[String]) -> Vec<String> {
    let three = words.windows(3);
    three
        .filter(|three| three[0] == "mod" && three[2] == ";")
        .map(|three| three[1].clone())
        .collect()
}

fn imports(words: &[String]) -> Vec<Import> {
    let mut found = Vec::new();
    for at in import_starts(words) {
        let is_public = at > 0 && ["pub", ")"].contains(&words[at - 1].as_str());
        let mut names = Vec::new();
        branch(words, at + 1, &[], &mut names);
        found.extend(names.into_iter().map(|(path, name)| Import {
            path,
            name,
            is_public,
        }));
    }
    found
}

/// Places of the word `use`, those of captured lifetimes left out.
fn import_starts(words: &[String]) -> impl Iterator<Item = usize> {
    let next = |at: usize| words.get(at + 1).map(String::as_str);
    (0..words.len()).filter(move |at| words[*at] == "use" && next(*at) != Some("<"))
}

type Named = (Vec<String>, Option<String>);

/// Reads one branch of an import; gives the place behind it.
fn branch(words: &[String], mut at: usize, stem: &[String], found: &mut Vec<Named>) -> usize {
    let mut path = stem.to_vec();
    loop {
        match words[at].as_str() {
            "{" => {
                at += 1;
                while words[at] != "}" {
                    at = branch(words, at, &path, found);
                    at += usize::from(words[at] == ",");
                }
                return at + 1;
            }
            "*" => {
                found.push((path, None));
                return at + 1;
            }
            "::" => {}
            "self" if !path.is_empty() => {}
            "as" => {
                found.push((path, Some(words[at + 1].clone())));
                return at + 2;
            }
            "," | "}" | ";" => {
                let name = path.last().cloned();
                found.push((path, name));
                return at;
            }
            name => path.push(name.to_owned()),
        }
        at += 1;
    }
}

/// Paths of two names and more outside imports.
fn paths(words: &[String]) -> Vec<Vec<String>> {
    let is_name = |word: &str| word.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let word = |at: usize| words.get(at).map_or("", String::as_str);
    let mut found = Vec::new();
    let mut at = 0;
    while at < words.len() {
        if word(at) == "use" && word(at + 1) != "<" {
            at += words[at..].iter().take_while(|word| *word != ";").count();
        }
        // The path of `pub(in path)` uses nothing.
        if !is_name(word(at)) || word(at + 1) != "::" || at > 1 && words[at - 2..at] == ["(", "in"]
        {
            at += 1;
            continue;
        }
        let mut path = vec![word(at).to_owned()];
        while word(at + 1) == "::" && is_name(word(at + 2)) {
            path.push(word(at + 2).to_owned());
            at += 2;
        }
        found.push(path);
        at += 1;
    }
    found
}

/// Writes a crate into a folder of its own and reads it.
fn example(name: &str, files: &[(&str, &str)]) -> Tree {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    for (name, text) in files {
        let file = root.join(name);
        fs::create_dir_all(file.parent().expect("a folder")).expect("the folder can be made");
        fs::write(file, text).expect("the file can be written");
    }
    Tree::read(&root.join("lib.rs"))
}

/// A crate in which `a` uses `b` through the root, `b` uses `c`'s child, and the
/// child what `c` and the root define.
#[test]
fn uses_are_followed_to_the_file_that_defines_a_name() {
    let files = [
        (
            "lib.rs",
            "mod a; mod b; mod c; pub use b::B as Other; struct Root;",
        ),
        ("a.rs", "use crate::{Other, c::Deep}; use std::fmt;"),
        ("b.rs", "pub struct B; fn f() { crate::c::child::g(); }"),
        ("c/mod.rs", "mod child; pub use child::Deep; struct Own;"),
        (
            "c/child.rs",
            "use super::Own; use crate::Root; pub struct Deep;",
        ),
    ];
    let tree = example("uses", &files);
    let [a, b, child] = ["a.rs", "b.rs", "c/child.rs"].map(|name| {
        let has_name = |module: &usize| tree.file(*module).ends_with(name);
        (0..files.len()).find(has_name).expect("the file is read")
    });
    let uses = tree.uses();
    assert_eq!(uses[a], BTreeSet::from([b, child]));
    assert_eq!(uses[b], BTreeSet::from([child]));
    assert!(uses[child].is_empty());
    assert_eq!(tree.rooms().1[0], BTreeSet::from([1, 2]));
}

/// Two files in a circle, where a module written out in one of them takes its names from
/// that file: read as the file's own import, its `super` would be the root.
#[test]
fn modules_written_out_are_modules_of_their_own() {
    let files = [
        ("lib.rs", "mod rows; mod batches;"),
        (
            "rows.rs",
            "use super::batches::Batch; pub struct Row; mod fast { use super::{Batch, Row}; }",
        ),
        ("batches.rs", "use super::rows::Row; pub struct Batch;"),
    ];
    let uses = example("inline", &files).uses();
    assert_eq!(uses, [[].into(), [3].into(), [].into(), [1].into()]);
    assert_eq!(super::circles(&uses), [BTreeSet::from([1, 3])]);
}

/// What only a module written out uses counts for its file.
#[test]
fn uses_of_modules_written_out_are_those_of_their_file() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        (
            "a.rs",
            "mod deep { mod deeper { use crate::b::B; } pub(super) struct D; } use deep::D;",
        ),
        ("b.rs", "pub struct B;"),
    ];
    let tree = example("deep", &files);
    assert_eq!(tree.uses()[1], BTreeSet::from([4]));
    assert_eq!(tree.rooms().1, [[1].into(), [].into()]);
}
