//! The bench, on its smallest meshes.
#![cfg(all(feature = "embedded", feature = "bench"))]

use std::path::Path;

use crate::common::{Run, folder, run};

/// Rows of a table by the names of its columns.
struct Table {
    titles: csv::StringRecord,
    records: Vec<csv::StringRecord>,
}

impl Table {
    fn read(folder: &Path) -> Self {
        let mut reader = csv::Reader::from_path(folder.join("bench.csv")).unwrap();
        let titles = reader.headers().unwrap().clone();
        let records = reader.records().map(Result::unwrap).collect();
        Self { titles, records }
    }

    fn text(&self, row: usize, title: &str) -> &str {
        let column = self.titles.iter().position(|name| name == title);
        &self.records[row][column.unwrap_or_else(|| panic!("a column {title}"))]
    }

    fn number(&self, row: usize, title: &str) -> f64 {
        self.text(row, title).parse().unwrap()
    }
}

fn bench(folder: &Path, more: &[&str]) -> Run {
    let out = [
        "bench",
        "--quick",
        "--repeats",
        "1",
        "--out",
        folder.to_str().unwrap(),
    ];
    run(out.into_iter().chain(more.iter().copied()))
}

#[test]
fn a_quick_bench_shows_errors_that_fall_with_the_mesh() {
    let folder = folder("bench_quick");
    let run = bench(
        &folder,
        &[
            "--scene",
            "A1m",
            "--levels",
            "n4,n2",
            "--tolerances",
            "1e-6",
        ],
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = Table::read(&folder);
    assert_eq!(table.records.len(), 2);
    assert_eq!(
        (table.text(0, "level"), table.text(1, "level")),
        ("n2", "n4")
    );
    for error in ["displacement_l2", "displacement_h1", "pressure_l2"] {
        let title = format!("error_{error}");
        assert!(table.number(0, &title) > table.number(1, &title), "{error}");
    }
    // (2 n + 1)^3 nodes of three components, (n + 1)^3 pressures.
    assert_eq!(table.text(1, "unknowns_displacement"), "2187");
    assert_eq!(table.text(1, "unknowns_pressure"), "125");
    assert_eq!(table.text(0, "outcome"), "converged");
    assert!(table.number(0, "seconds_median") > 0.0);
    assert_eq!(table.text(0, "error_force"), "");
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    for text in [
        "A1m: error of the pressure (L2 norm) against time",
        "every case met its tolerance",
        "instruction set",
        "In short",
        "NGSolve two-level",
        "commit ",
    ] {
        assert!(page.contains(text), "{text}");
    }
    for outside in ["<script", "<link", "src=\"http", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    let figure = std::fs::read_to_string(folder.join("A1m-displacement_l2-seconds.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.contains("<polyline"));
}

#[test]
fn the_cube_that_the_bench_writes_is_that_of_other_codes() {
    let folder = folder("bench_cube");
    let run = bench(
        &folder,
        &[
            "--scene",
            "cube-bend",
            "--levels",
            "n6",
            "--tolerances",
            "1e-11",
        ],
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = Table::read(&folder);
    let energy = table.number(0, "value_strain_energy");
    assert!((energy / 1.113336140715 - 1.0).abs() < 1e-10, "{energy}");
    assert_eq!(table.text(0, "unknowns_displacement"), "6591");
    assert_eq!(table.text(0, "unknowns_pressure"), "343");
}

#[test]
fn contact_is_compared_with_its_limit_and_peers_stand_beside() {
    let folder = folder("bench_contact");
    let peers = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/benches/peers/peers.csv"
    );
    let run = bench(
        &folder,
        &[
            "--scene",
            "hertz-plane",
            "--levels",
            "l1,l2",
            "--peers",
            peers,
        ],
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = Table::read(&folder);
    assert_eq!(table.records.len(), 4, "two meshes, two tolerances");
    for row in 0..4 {
        let coarse = table.text(row, "level") == "l1";
        let error = table.number(row, "error_force");
        assert_eq!(error > 0.02, coarse, "{error}");
    }
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains("NGSolve active set"));
    assert!(page.contains("About the other solvers"));
}

#[test]
fn a_study_says_what_follows_from_its_rows() {
    let folder = folder("bench_study");
    let run = bench(&folder, &["--study", "p1-solver", "--levels", "n6"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = Table::read(&folder);
    let converged = |row: &usize| table.text(*row, "outcome") == "converged";
    let rows = (0..table.records.len()).filter(converged).count();
    assert!(rows >= 3, "the default, the factor and multigrid");
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    for text in [
        "P1 by a factor, multigrid or IC-CG?",
        "<td class=\"text\">n6</td><td class=\"text\">6934</td>",
        "<th>over the first choice</th>",
        "sparse Cholesky",
        "The experiments that the method comes from",
        "elasticity",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let figure = folder.join("study-p1-solver-cube-bend-applications.svg");
    assert!(
        std::fs::read_to_string(figure)
            .unwrap()
            .contains("algebraic multigrid")
    );
    let run = bench(&folder, &["--study", "chess"]);
    assert!(
        run.stderr.contains("known: element, saddle"),
        "{}",
        run.stderr
    );
}

#[test]
fn extreme_cases_are_judged_by_what_is_known_of_them() {
    let folder = folder("bench_extremes");
    let run = bench(&folder, &["--study", "extremes"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let mut reader = csv::Reader::from_path(folder.join("extremes.csv")).unwrap();
    let records: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert!(records.len() >= 30, "{}", records.len());
    for record in &records {
        // The fifth field is the verdict; quick rows are those that hold.
        assert_eq!(&record[4], "right", "{record:?}");
    }
    // Everything that a row ran on is there to be run again.
    assert!(folder.join("extremes").join("far-wall.toml").exists());
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    for text in [
        "Stiff and extreme cases: what holds, and what does not?",
        "known without this solver",
        "enclosed_volume",
        "NGSolve Pardiso: compared with",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let figure = std::fs::read_to_string(folder.join("study-extremes.svg")).unwrap();
    assert!(figure.contains("relative error"), "{figure}");
}

#[test]
fn methods_that_fail_are_shown_and_tried_once() {
    let folder = folder("bench_refused");
    let run = bench(
        &folder,
        &[
            "--scene",
            "cube-bend",
            "--levels",
            "n2,n3",
            "--tolerances",
            "1e-6",
            "--method",
            "auto",
            "--method",
            "saddle=uzawa-dance",
        ],
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let table = Table::read(&folder);
    let outcomes: Vec<_> = (0..table.records.len())
        .map(|row| table.text(row, "outcome"))
        .collect();
    assert_eq!(
        outcomes
            .iter()
            .filter(|outcome| **outcome == "converged")
            .count(),
        2
    );
    assert_eq!(
        outcomes
            .iter()
            .filter(|outcome| **outcome == "refused")
            .count(),
        1
    );
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains("uzawa-dance"));
    assert!(page.contains("the program refuses this method"));
    assert!(!page.contains("every case met its tolerance"));
}

#[test]
fn a_run_beyond_its_limit_is_a_failure_in_the_table() {
    let folder = folder("bench_limit");
    let run = bench(
        &folder,
        &[
            "--scene",
            "A1m",
            "--levels",
            "n34",
            "--tolerances",
            "1e-8",
            "--run-limit",
            "1",
        ],
    );
    // The only case failed: there is nothing to compare.
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    let table = Table::read(&folder);
    assert_eq!(table.text(0, "outcome"), "time_limit");
    let page = std::fs::read_to_string(folder.join("index.html")).unwrap();
    assert!(page.contains("time limit"));
}

#[test]
fn meshes_that_are_not_there_are_named() {
    let folder = folder("bench_missing");
    let run = bench(&folder, &["--scene", "hertz-sphere", "--levels", "l7"]);
    assert_eq!(run.code, Some(4));
    assert!(run.stderr.contains("mesh indent_l7.msh"), "{}", run.stderr);
    assert!(run.stderr.contains("--meshes DIR"), "{}", run.stderr);
    let run = bench(&folder, &["--scene", "A1m", "--levels", "l1"]);
    assert_eq!(run.code, Some(2));
    let run = bench(&folder, &["--scene", "A2"]);
    assert!(
        run.stderr.contains("known: A1m, cube-bend"),
        "{}",
        run.stderr
    );
    assert_eq!(run.code, Some(2));
}
