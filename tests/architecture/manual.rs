//! Pages lead somewhere: links, anchors, files and tests that they name exist; the README is
//! short.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Lines of the README: two minutes of a person in a hurry.
const README_LINES: usize = 120;

/// Folders of what was built, and of other programs.
const ELSEWHERE: [&str; 5] = ["build", "dist", "results", "target", "venv"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the folder is readable") {
        let path = entry.expect("the entry is readable").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            if !ELSEWHERE.contains(&name.as_str()) && !name.starts_with('.') {
                pages(&path, found);
            }
        } else if name.ends_with(".md") {
            found.push(path);
        }
    }
}

/// Every page but those of built packages.
fn all_pages() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["client", "deploy", "proto", "server", "tests"] {
        pages(&root().join(folder), &mut found);
    }
    found.push(root().join("README.md"));
    found
}

/// Pages that describe the program, and nothing that is made by running it.
fn manual() -> Vec<PathBuf> {
    let is_manual = |path: &PathBuf| {
        let path = path.strip_prefix(root()).expect("below the root");
        path.starts_with("client/manual") || path == Path::new("README.md")
    };
    all_pages().into_iter().filter(is_manual).collect()
}

/// Text without fenced blocks.
fn prose(page: &str) -> String {
    page.split("```").step_by(2).collect()
}

/// Where the links of a page lead, pictures included.
fn links(page: &str) -> Vec<String> {
    let prose = prose(page);
    let targets = prose.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split_once(')'));
    let targets = targets.map(|(target, _)| target.to_owned());
    targets.filter(|target| !target.contains("://")).collect()
}

/// The anchor of a heading, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    let text: String = heading.trim().to_lowercase().chars().filter(kept).collect();
    text.replace(' ', "-")
}

fn anchors(page: &str) -> BTreeSet<String> {
    let prose = prose(page);
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| anchor(line.trim_start_matches('#')))
        .collect()
}

/// Text between backticks.
fn spans(page: &str) -> Vec<String> {
    let prose = prose(page);
    prose
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_readme_is_short() {
    let lines = text(&root().join("README.md")).lines().count();
    assert!(lines <= README_LINES, "{lines}");
}

#[test]
fn every_link_leads_to_a_file_and_a_heading_of_it() {
    let mut count = 0;
    for path in all_pages() {
        let page = text(&path);
        for link in links(&page) {
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => path.clone(),
                file => path.parent().expect("a folder").join(file),
            };
            assert!(target.exists(), "{}: {link}", path.display());
            let has = heading.is_empty() || anchors(&text(&target)).contains(heading);
            assert!(has, "{}: {link} has no such heading", path.display());
            count += 1;
        }
    }
    assert!(count >= 60, "{count}");
}

/// The path that a span is, if it is one below the root.
fn named_file(span: &str) -> Option<PathBuf> {
    let (first, _) = span.split_once('/')?;
    let is_ours = ["client", "deploy", "proto", "server", "src", "tests", ".ci"].contains(&first);
    let is_path = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    // Capitals stand for something.
    let is_itself = span.to_lowercase() == span.replace("README", "readme");
    let is_one = is_ours && is_itself && span.chars().all(is_path);
    is_one.then(|| root().join(span))
}

#[test]
fn every_file_that_the_manual_names_exists() {
    let mut count = 0;
    for path in manual() {
        for span in spans(&text(&path)) {
            // A command of the folder with its arguments.
            let file = span.split(' ').next().and_then(named_file);
            if let Some(file) = file {
                assert!(file.exists(), "{}: {span}", path.display());
                count += 1;
            }
        }
    }
    assert!(count >= 20, "{count}");
}

#[test]
fn every_page_of_the_manual_is_in_its_index() {
    let index = text(&root().join("client/manual/README.md"));
    let links = links(&index);
    for path in manual().iter().filter(|path| !path.ends_with("README.md")) {
        let name = path.file_name().expect("a name").to_string_lossy();
        assert!(links.iter().any(|link| *link == name), "{name}");
    }
}

#[test]
fn every_test_that_the_verification_names_is_there() {
    let page = text(&root().join("client/manual/verification.md"));
    let mut count = 0;
    for span in spans(&page).iter().filter(|span| span.contains("::")) {
        let parts: Vec<&str> = span.split("::").collect();
        let [program, module, name] = parts[..] else {
            panic!("{span} is no program::module::test");
        };
        let file = format!("tests/{program}/{module}.rs");
        let places = [root().join(&file), root().join("client").join(&file)];
        let place = places.iter().find(|path| path.exists());
        let source = text(place.unwrap_or_else(|| panic!("{span} names no file")));
        let definition = format!("#[test]\nfn {name}() {{");
        assert!(source.contains(&definition), "{span}");
        count += 1;
    }
    // Every row of a table of cases names its test.
    let rows = page
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| case"));
    let without = rows.filter(|row| !row.contains("::"));
    let without: Vec<&str> = without.collect();
    assert!(without.is_empty(), "{without:?}");
    assert!(count >= 40, "{count}");
}
