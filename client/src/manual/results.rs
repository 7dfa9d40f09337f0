//! Fields of result lines, columns, files and exit codes.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use signorini_proto::v1;

use super::page::{self, Page};
use crate::report::{results, results_csv};
use crate::terminal::exit::Exit;

fn schema() -> Value {
    serde_json::from_str(include_str!("../../result-lines.schema.json")).unwrap()
}

/// Calls `see` with every key of a definition and of what it holds, and its value.
fn walk(definition: &Value, see: &mut impl FnMut(&str, &Value)) {
    if let Value::Object(parts) = definition {
        for (key, part) in parts {
            see(key, part);
            walk(part, see);
        }
    }
    if let Value::Array(parts) = definition {
        parts.iter().for_each(|part| walk(part, see));
    }
}

/// Fields of an object and of the objects in it, without those that are defined apart.
fn fields(definition: &Value) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    walk(definition, &mut |key, part| {
        if let ("properties", Value::Object(properties)) = (key, part) {
            found.extend(properties.keys().cloned());
        }
    });
    found
}

/// The words that a field of the schema may be.
fn enumerated(definition: &Value) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    walk(definition, &mut |key, part| {
        if let ("enum", Value::Array(words)) = (key, part) {
            found.extend(words.iter().filter_map(Value::as_str).map(str::to_owned));
        }
    });
    found
}

/// The part of the page that is about a definition: its section, or a table there under a
/// line that names it.
fn part(page: &Page, name: &str) -> Page {
    let section = page.section(name, |heading| {
        page::words(heading).contains(&name.to_owned())
    });
    let mark = format!("Of `{name}s`");
    let text = match section.text.split_once(&mark) {
        Some((_, rest)) => rest.split("\nOf `").next().unwrap_or_default().to_owned(),
        None => section.text,
    };
    Page { text, ..section }
}

#[test]
fn every_field_of_a_result_line_is_on_its_page_and_no_other() {
    let (schema, page) = (schema(), Page::read("results.md"));
    let mut parts = 0;
    for (name, definition) in schema["$defs"].as_object().unwrap() {
        let known = fields(definition);
        if known.is_empty() {
            continue;
        }
        let cells = part(&page, name).first_cells();
        let told: BTreeSet<String> = cells.iter().flat_map(|cell| page::words(cell)).collect();
        assert_eq!(told, known, "{name}");
        parts += 1;
    }
    assert!(parts >= 14, "{parts}");
}

#[test]
fn every_word_of_a_result_line_is_told() {
    let words = enumerated(&schema());
    let pages = ["results.md", "does-not-converge.md", "scenes.md"].map(Page::read);
    let told: BTreeSet<String> = pages.iter().flat_map(Page::words).collect();
    let missing: Vec<&String> = words.difference(&told).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn every_column_of_the_table_is_on_the_page_and_no_other() {
    let named = || "NAME".to_owned();
    let goal = v1::GoalResult {
        bound: Some(v1::GoalBound::default()),
        derivatives: BTreeMap::from([("PARAMETER".to_owned(), 0.0)]),
        ..Default::default()
    };
    let report = v1::StepReport {
        obstacles: BTreeMap::from([(named(), v1::ObstacleResult::default())]),
        supports: BTreeMap::from([(named(), v1::SupportResult::default())]),
        probes: BTreeMap::from([(named(), v1::ProbeResult::default())]),
        fluids: BTreeMap::from([(named(), v1::FluidResult::default())]),
        goals: BTreeMap::from([(named(), goal)]),
        contacts: BTreeMap::from([(named(), v1::BodyContactResult::default())]),
        ties: BTreeMap::from([(named(), v1::TieResult::default())]),
        ..Default::default()
    };
    let known: BTreeSet<String> = results_csv::header(&report).into_iter().collect();
    let section =
        Page::read("results.md").section("columns", |heading| heading == results_csv::FILE);
    let told: BTreeSet<String> = section.first_cells().into_iter().collect();
    assert_eq!(told, known);
}

#[test]
fn every_field_of_the_files_for_paraview_is_on_the_page_and_no_other() {
    let fields = (1..).map_while(|number| v1::FieldName::try_from(number).ok());
    let mut known: BTreeSet<String> = fields.map(signorini_proto::words::field).collect();
    known.extend(results::DERIVED.map(str::to_owned));
    let page = Page::read("results.md");
    let section = page.section("fields", |heading| heading == "Files for ParaView");
    let told: BTreeSet<String> = section.first_cells().into_iter().collect();
    assert_eq!(told, known);
}

#[test]
fn every_exit_code_is_on_the_page_and_no_other() {
    let codes = [
        Exit::Ok,
        Exit::Usage,
        Exit::NotConverged,
        Exit::Invalid,
        Exit::NoServer,
        Exit::Refused,
        Exit::Deadline,
        Exit::Server,
        Exit::DiskFull,
        Exit::Restarted,
        Exit::Inaccurate,
        Exit::Interrupted,
    ];
    let known: Vec<String> = codes.iter().map(|code| (*code as u8).to_string()).collect();
    let page = Page::read("results.md");
    let section = page.section("exit codes", |heading| heading == "Exit codes");
    let rows = section
        .text
        .lines()
        .filter_map(|line| line.split('|').nth(1));
    let told = rows.map(|cell| cell.trim().to_owned());
    let told: Vec<String> = told.filter(|cell| cell.parse::<u8>().is_ok()).collect();
    assert_eq!(told, known);
}
