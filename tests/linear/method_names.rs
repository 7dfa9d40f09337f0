//! The README, the contract and the library know the same names of methods.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use signorini::scene::{
    Choice, ContactMethod, ContactSpace, DisplacementMethod, ElementKind, ErrorEstimate,
    MetricKind, Named, OnInstability, P1Solver, SaddleMethod, StabilityCheck,
};

/// A key of `[solver]` and its names, `auto` among them.
type List = (&'static str, BTreeSet<String>);

fn list<T: Named>(key: &'static str) -> List {
    (key, Choice::<T>::names().map(str::to_owned).collect())
}

fn lists() -> [List; 10] {
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
fn row<'a>(readme: &'a str, key: &str) -> Option<&'a str> {
    let start = format!("| `{key}` |");
    let mut lines = readme.lines();
    lines.find_map(|line| line.strip_prefix(start.as_str()))
}

#[test]
fn the_table_of_methods_in_the_readme_has_every_name() {
    let readme = text("README.md");
    for (key, mut names) in lists() {
        // The setting without a row is listed with those that are no methods.
        let Some(row) = row(&readme, key) else {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            let words = format!("`{key}` ({})", names.join(", "));
            assert!(readme.contains(&words), "{words}");
            continue;
        };
        names.remove("auto");
        assert_eq!(quoted(row), names, "{key}");
    }
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
