//! The house has two wings and one hall: every `use crate::` of the library
//! follows the table below, and faer stays behind one door. No files of any crate
//! import each other in a circle. Pages lead somewhere.

mod budgets;
mod circles;
mod decisions;
mod functions;
mod manual;
mod modules;
mod rescues;
mod rooms;
mod tokens;

use std::fs;
use std::path::{Path, PathBuf};

use circles::circles;
use modules::Tree;

/// Module and what it may import, besides itself.
const ROOMS: &[(&str, &[&str])] = &[
    ("report", &[]),
    ("constants", &[]),
    ("parallel", &[]),
    ("linalg", &["parallel"]),
    ("geometry", &[]),
    ("precond", &["parallel", "linalg", "report"]),
    ("krylov", &["parallel", "linalg", "precond", "report"]),
    (
        "saddle",
        &["parallel", "linalg", "precond", "krylov", "report"],
    ),
    (
        "inequality",
        &[
            "parallel", "linalg", "precond", "krylov", "saddle", "report",
        ],
    ),
    ("element", &["geometry"]),
    ("mesh", &["element", "geometry"]),
    ("space", &["mesh", "element", "linalg", "geometry"]),
    ("fluid", &["space", "linalg", "mesh", "geometry"]),
    ("material", &["geometry"]),
    ("obstacle", &["parallel", "geometry"]),
    (
        "assembly",
        &[
            "parallel", "space", "material", "linalg", "mesh", "element", "geometry",
        ],
    ),
    (
        "contact",
        &[
            "parallel", "space", "obstacle", "linalg", "assembly", "mesh", "element", "geometry",
        ],
    ),
    (
        "pairs",
        &[
            "parallel", "contact", "space", "obstacle", "linalg", "mesh", "element", "geometry",
        ],
    ),
    (
        "ties",
        &[
            "parallel", "pairs", "contact", "space", "linalg", "mesh", "element", "geometry",
        ],
    ),
    (
        "proximity",
        &[
            "parallel", "contact", "space", "obstacle", "linalg", "assembly", "mesh", "element",
            "geometry",
        ],
    ),
];

/// Rooms of the hall in their order, and what each must not import beside all that follow it:
/// the solver reads results, results never the solver.
const HALL: &[(&str, &[&str])] = &[
    ("scene", &["results"]),
    ("calibration", &["results"]),
    ("comparisons", &["results"]),
    ("plan", &["results"]),
    ("prepare", &["results"]),
    ("model", &["results"]),
    ("sqp", &[]),
    ("stability", &[]),
    ("diagnosis", &[]),
    ("force_control", &["stability", "diagnosis"]),
    ("continuation", &[]),
    (
        "results",
        &[
            "sqp",
            "stability",
            "diagnosis",
            "force_control",
            "continuation",
        ],
    ),
    ("goals", &[]),
    ("verify", &SOLVER),
    ("refinement", &REFINEMENT),
    ("session", &[]),
    ("adapted", &REFINEMENT),
];

/// The rooms that move a state.
const SOLVER: [&str; 5] = [
    "sqp",
    "stability",
    "diagnosis",
    "force_control",
    "continuation",
];

/// What the refinement of a mesh and of a state has nothing to do with.
const REFINEMENT: [&str; 6] = [
    "sqp",
    "stability",
    "diagnosis",
    "force_control",
    "continuation",
    "results",
];

/// Root files of the crates; one whose crate is not there counts as empty.
const CRATES: &[&str] = &[
    "src/lib.rs",
    "proto/src/lib.rs",
    "server/src/lib.rs",
    "server/src/main.rs",
    "client/src/lib.rs",
    "client/src/main.rs",
    "client/bench/src/lib.rs",
    "client/bench/src/main.rs",
    "client/compare/src/lib.rs",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the folder is readable") {
        let path = entry.expect("the entry is readable").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn library() -> Vec<(String, PathBuf, String)> {
    let root = workspace().join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let relative = path.strip_prefix(&root).expect("below src");
            let first = relative.iter().next().expect("not empty").to_string_lossy();
            let room = first.trim_end_matches(".rs").to_owned();
            let text = fs::read_to_string(&path).expect("the file is readable");
            (room, relative.to_owned(), text)
        })
        .collect()
}

/// Rooms named by `crate::` outside test modules, which may look everywhere.
fn imports(text: &str) -> Vec<String> {
    let words = tokens::production(text);
    let paths = words.windows(3);
    paths
        .filter(|path| path[..2] == ["crate", "::"])
        .map(|path| path[2].clone())
        .collect()
}

/// The files of the library that a build without tests reads.
fn production() -> Vec<(String, PathBuf, String)> {
    let tree = Tree::read(&workspace().join("src/lib.rs"));
    let modules = 0..tree.uses().len();
    let read: Vec<&Path> = modules.map(|module| tree.file(module)).collect();
    let mut files = library();
    files.retain(|(_, path, _)| read.contains(&workspace().join("src").join(path).as_path()));
    files
}

fn is_test_file(path: &Path) -> bool {
    path.file_stem()
        .is_some_and(|stem| stem == "tests" || stem == "samples")
        || path.iter().any(|part| part == "tests")
}

#[test]
fn rooms_import_only_what_the_table_allows() {
    let mut faults = Vec::new();
    for (room, path, text) in library() {
        if room == "lib" || is_test_file(&path) {
            continue;
        }
        for import in imports(&text) {
            let allowed = match ROOMS.iter().find(|(name, _)| *name == room) {
                Some((_, allowed)) => import == room || allowed.contains(&import.as_str()),
                None => hall_allows(&room, &import),
            };
            if !allowed {
                faults.push(format!("{}: {room} imports {import}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Whether a room of the hall may import another: one before it that its row does not refuse,
/// and what solvers read.
fn hall_allows(room: &str, import: &str) -> bool {
    let place = |name: &str| HALL.iter().position(|(other, _)| *other == name);
    let Some(own) = place(room) else {
        return false;
    };
    let is_later = place(import).is_some_and(|other| other > own);
    !HALL[own].1.contains(&import) && (!is_later || import == "results")
}

#[test]
fn every_room_of_the_library_is_in_the_table() {
    for (room, path, _) in library() {
        let known = ROOMS.iter().chain(HALL).any(|(name, _)| *name == room);
        assert!(known || room == "lib", "{} is in no room", path.display());
    }
}

#[test]
fn only_linalg_names_faer() {
    for (room, path, text) in library() {
        let names = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .any(|line| line.contains("faer::") || line.contains("use faer"));
        assert!(!names || room == "linalg", "{} names faer", path.display());
    }
}

#[test]
fn the_library_prints_nothing_and_does_no_input_or_output() {
    for (_, path, text) in library() {
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for word in [
            "println!",
            "eprintln!",
            "std::fs",
            "std::net",
            "std::env",
            "tokio",
            "tonic",
        ] {
            let used = code
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
                .any(|line| line.contains(word));
            assert!(!used, "{} contains {word}", path.display());
        }
    }
}

fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn crates() -> impl Iterator<Item = Tree> {
    let roots = CRATES.iter().map(|root| workspace().join(root));
    roots
        .filter(|root| root.exists())
        .map(|root| Tree::read(&root))
}

/// A file's path as the tables spell it.
fn spelled(tree: &Tree, module: usize) -> String {
    let file = tree.file(module).strip_prefix(workspace());
    file.expect("below the workspace").display().to_string()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut faults = Vec::new();
    for tree in crates() {
        for circle in circles(&tree.uses()) {
            let files: Vec<String> = circle.iter().map(|one| spelled(&tree, *one)).collect();
            faults.push(files.join(" <-> "));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn no_rooms_of_a_crate_import_each_other_in_a_circle() {
    for tree in crates() {
        let (rooms, edges) = tree.rooms();
        let circles = circles(&edges);
        let named = circles.iter().map(|circle| {
            let names: Vec<&str> = circle.iter().map(|one| rooms[*one].as_str()).collect();
            names.join(" <-> ")
        });
        let named: Vec<String> = named.collect();
        assert!(named.is_empty(), "{}: {named:?}", spelled(&tree, 0));
    }
}

#[test]
fn every_decision_is_part_of_the_documentation() {
    let folder = workspace().join("src/decisions");
    let root = fs::read_to_string(workspace().join("src/lib.rs")).expect("the root is readable");
    for entry in fs::read_dir(folder).expect("the folder is readable") {
        let name = entry.expect("the entry is readable").file_name();
        let line = format!("include_str!(\"decisions/{}\")", name.display());
        assert!(root.contains(&line), "lib.rs lacks {line}");
    }
}
