//! The manual, the contract and the library know the same names of methods, and the manual
//! every cause and warning.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use signorini::report::{Cause, WarningKind};
use signorini::scene::{
    Choice, ContactMethod, ContactSpace, DisplacementMethod, ElementKind, ErrorEstimate,
    MetricKind, Named, OnInstability, P1Solver, ReportScope, ResponseMethod, SaddleMethod,
    StabilityCheck,
};

/// A key of `[solver]` and its names, `auto` among them.
type List = (&'static str, BTreeSet<String>);

fn list<T: Named>(key: &'static str) -> List {
    (key, Choice::<T>::names().map(str::to_owned).collect())
}

fn lists() -> [List; 12] {
    [
        list::<ContactMethod>("contact"),
        list::<MetricKind>("contact_metric"),
        list::<ContactSpace>("contact_space"),
        list::<DisplacementMethod>("displacement_preconditioner"),
        list::<ElementKind>("element"),
        list::<ErrorEstimate>("error_estimate"),
        list::<P1Solver>("p1_solver"),
        list::<SaddleMethod>("saddle"),
        list::<StabilityCheck>("stability"),
        list::<OnInstability>("on_instability"),
        list::<ResponseMethod>("response"),
        list::<ReportScope>("report"),
    ]
}

fn text(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(path).expect("the file is readable")
}

/// Words between backticks.
fn quoted(text: &str) -> BTreeSet<String> {
    text.split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

/// The row of a table that begins with `key`, without that key.
fn row<'a>(page: &'a str, key: &str) -> Option<&'a str> {
    let start = format!("| `{key}` |");
    let mut lines = page.lines();
    lines.find_map(|line| line.strip_prefix(start.as_str()))
}

#[test]
fn the_table_of_methods_in_the_manual_has_every_name() {
    let page = text("client/manual/scenes.md");
    for (key, mut names) in lists() {
        // The setting without a row of methods is listed with those that are no methods.
        let listed: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let words = format!("`{key}` ({})", listed.join(", "));
        if page.contains(&words) {
            continue;
        }
        names.remove("auto");
        let row = row(&page, key).unwrap_or_else(|| panic!("{key} has no row"));
        assert_eq!(quoted(row), names, "{key}");
    }
}

/// Words between backticks in the first cells of a table.
fn first_cells(page: &str) -> Vec<String> {
    let rows = page.lines().filter(|line| line.starts_with('|'));
    let cells = rows.filter_map(|row| row.split('|').nth(1));
    cells.flat_map(quoted).collect()
}

#[test]
fn every_cause_and_every_warning_has_a_row_in_the_manual() {
    let page = text("client/manual/does-not-converge.md");
    let (causes, rest) = page.split_once("\n## ").expect("a section");
    let (warnings, _) = rest.split_once("\n## ").expect("another one");
    let mut told = [causes, warnings].map(first_cells);
    told.iter_mut().for_each(|names| names.sort());
    let mut known = [
        Cause::ALL.map(Cause::name).to_vec(),
        WarningKind::ALL.map(WarningKind::name).to_vec(),
    ];
    // A cause of the server, which the library does not know.
    known[0].push("server_time_limit");
    known.iter_mut().for_each(|names| names.sort_unstable());
    assert_eq!(told[0], known[0]);
    assert_eq!(told[1], known[1]);
}

/// The comment above the field `key` of the solver options.
fn comment(contract: &str, key: &str) -> String {
    let (_, options) = contract
        .split_once("message SolverOptions {")
        .expect("the message");
    let field = format!("string {key} = ");
    let lines: Vec<&str> = options.lines().map(str::trim).collect();
    let end = lines
        .iter()
        .position(|line| line.starts_with(&field))
        .expect("the field");
    let above = lines[..end].iter().rev();
    let mut comment: Vec<&str> = above
        .copied()
        .take_while(|line| line.starts_with("//"))
        .collect();
    comment.reverse();
    comment.join("\n")
}

#[test]
fn the_contract_names_every_method_and_no_other() {
    let contract = text("proto/signorini/v1/scene.proto");
    for (key, names) in lists() {
        assert_eq!(quoted(&comment(&contract, key)), names, "{key}");
    }
}
