//! The house has two wings and one hall: every `use crate::` of the library
//! follows the table below, and faer stays behind one door.

use std::fs;
use std::path::{Path, PathBuf};

/// Module and what it may import, besides itself.
const ROOMS: &[(&str, &[&str])] = &[
    ("report", &[]),
    ("linalg", &[]),
    ("geometry", &[]),
    ("precond", &["linalg", "report"]),
    ("krylov", &["linalg", "precond", "report"]),
    ("saddle", &["linalg", "precond", "krylov", "report"]),
    (
        "inequality",
        &["linalg", "precond", "krylov", "saddle", "report"],
    ),
    ("mesh", &["geometry"]),
    ("element", &["mesh", "geometry"]),
    ("space", &["mesh", "element", "linalg", "geometry"]),
    ("material", &["geometry"]),
    ("obstacle", &["geometry"]),
    (
        "assembly",
        &["space", "material", "linalg", "mesh", "element", "geometry"],
    ),
    (
        "contact",
        &[
            "space", "obstacle", "linalg", "assembly", "mesh", "element", "geometry",
        ],
    ),
];

/// Rooms of the hall import everything below; plan and scene not the loop.
const HALL: &[(&str, &[&str])] = &[
    ("scene", &["plan", "sqp"]),
    ("plan", &["sqp"]),
    ("sqp", &[]),
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
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
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
    let code: String = text
        .split("#[cfg(test)]")
        .next()
        .unwrap_or_default()
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .map(|line| format!("{line}\n"))
        .collect();
    code.match_indices("crate::")
        .map(|(position, matched)| {
            let rest = &code[position + matched.len()..];
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .collect()
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
                None => match HALL.iter().find(|(name, _)| *name == room) {
                    Some((_, refused)) => !refused.contains(&import.as_str()),
                    None => false,
                },
            };
            if !allowed {
                faults.push(format!("{}: {room} imports {import}", path.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
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
