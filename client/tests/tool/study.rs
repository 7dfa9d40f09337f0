//! Studies: every case once, whatever ends the process or a case.
#![cfg(feature = "embedded")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::process::{Process, serve, start};
use crate::common::{Run, example, folder, run};

/// A study of the small sphere on a block, in a folder of its own.
struct Place(PathBuf);

impl Place {
    /// Depths from 0.02 to 0.05, so many, and what else varies.
    fn new(test: &str, depths: usize, more: &str) -> Self {
        let folder = folder(&format!("study_{test}"));
        let scene = fs::read_to_string(example("hertz-sphere.toml")).unwrap();
        let mesh = example("meshes/indent_l1.msh");
        let scene = scene.replace("meshes/indent_l3.msh", mesh.to_str().unwrap());
        fs::write(folder.join("scene.toml"), scene.replace("1e-10", "1e-6")).unwrap();
        let study = format!(
            "scene = \"scene.toml\"\n[[grid]]\nkey = \"step.0.obstacle.ball.translation.2\"\n\
             from = -0.05\nto = -0.02\ncount = {depths}\n[[result]]\nname = \"force\"\n\
             of = \"obstacles.ball.force.z\"\n{more}"
        );
        fs::write(folder.join("study.toml"), study).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    fn run(&self, more: &[&str]) -> Run {
        self.run_to(&self.path("out.csv"), more)
    }

    fn run_to(&self, out: &str, more: &[&str]) -> Run {
        let study = self.path("study.toml");
        let arguments = ["study", &study, "--out", out, "--workers", "2"];
        run(arguments.into_iter().chain(more.iter().copied()))
    }

    fn start(&self, more: &[&str]) -> Process {
        let (study, out) = (self.path("study.toml"), self.path("out.csv"));
        let arguments = ["study", &study, "--out", &out, "--workers", "2"];
        start(arguments.into_iter().chain(more.iter().copied()))
    }

    /// Rows of the table, by columns.
    fn table(&self) -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(self.0.join("out.csv")).unwrap();
        reader.deserialize().map(Result::unwrap).collect()
    }

    /// Lines of the log that are whole and have this key.
    fn logged(&self, key: &str) -> usize {
        let text = fs::read_to_string(self.0.join("out.csv.log")).unwrap_or_default();
        let lines = text
            .lines()
            .filter_map(|line| serde_json::from_str::<Value>(line).ok());
        lines.filter(|line| line.get(key).is_some()).count()
    }

    fn wait_for_rows(&self, rows: usize) {
        let begun = Instant::now();
        while self.logged("row") < rows {
            assert!(begun.elapsed() < Duration::from_secs(120), "no rows");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn assert_each_once(table: &[BTreeMap<String, String>], count: usize) {
    let cases: Vec<usize> = table
        .iter()
        .map(|row| row["case"].parse().unwrap())
        .collect();
    assert_eq!(cases, (0..count).collect::<Vec<_>>());
}

#[test]
fn a_study_that_is_run_again_counts_its_own_cases_alone() {
    let place = Place::new("again", 2, "");
    for _ in 0..2 {
        let ended = place.run(&[]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        let counted = ended.stdout.lines().next().unwrap_or_default();
        assert_eq!(counted, "converged          2", "{}", ended.stdout);
    }
}

#[test]
fn every_case_of_a_grid_is_a_row_in_order_and_the_same_whoever_solves_it() {
    let place = Place::new("grid", 3, "[list]\nfile = \"moduli.csv\"\n");
    fs::write(
        place.0.join("moduli.csv"),
        "material.body.shear_modulus\n1\n2\n",
    )
    .unwrap();
    let ended = place.run(&[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let table = place.table();
    assert_each_once(&table, 6);
    assert!(
        table.iter().all(|row| row["termination"] == "converged"),
        "{table:?}"
    );
    let force = |row: usize| table[row]["force"].parse::<f64>().unwrap();
    // Linear in the modulus, growing with the depth.
    assert!((force(3) / force(0) - 2.0).abs() < 1e-3, "{table:?}");
    assert!(
        force(0) < force(1) && force(1) < force(2) && force(2) < 0.0,
        "{table:?}"
    );
    let (process, url) = serve("127.0.0.1:0", "study_grid_server", "");
    let bits: Vec<String> = table.iter().map(|row| row["force"].clone()).collect();
    let ended = place.run(&["--server", &url]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let again: Vec<String> = place
        .table()
        .iter()
        .map(|row| row["force"].clone())
        .collect();
    assert_eq!(bits, again);
    drop(process);
}

#[test]
fn a_study_that_is_killed_again_and_again_loses_and_doubles_nothing() {
    const CASES: usize = 60;
    let place = Place::new("killed", CASES, "");
    for rows in [5, 20, 35] {
        let mut study = place.start(&["--resume"]);
        place.wait_for_rows(rows);
        study.signal("-KILL");
        study.0.wait().unwrap();
    }
    // As if the last write had been cut short.
    let log = place.path("out.csv.log");
    let torn = fs::read_to_string(&log).unwrap() + "{\"row\":{\"case\":5";
    fs::write(&log, torn).unwrap();
    let refused = place.run(&[]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(
        refused.stderr.contains("--resume goes on"),
        "{}",
        refused.stderr
    );
    let before = place.logged("row");
    assert!((35..CASES).contains(&before), "{before}");
    let ended = place.run(&["--resume"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_each_once(&place.table(), CASES);
    assert_eq!(place.logged("row"), CASES);
    // What had a row was not begun again.
    assert!(
        place.logged("begin") <= CASES + 3 * 2,
        "{}",
        place.logged("begin")
    );
    let again = place.run(&["--resume"]);
    assert_eq!((again.code, place.logged("row")), (Some(0), CASES));
}

#[test]
fn a_case_that_cannot_be_solved_is_a_row_with_its_cause() {
    let more = "[list]\nfile = \"cases.csv\"\n";
    let place = Place::new("poison", 1, more);
    let cases = "material.body.poisson_ratio,obstacle.ball.shape.radius,mesh\n\
                 0.5,1,\n0.6,1,\n0.5,one,\n0.5,1,none.msh\n";
    fs::write(place.0.join("cases.csv"), cases).unwrap();
    let ended = place.run(&[]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let table = place.table();
    assert_each_once(&table, 4);
    let told = |row: usize, column: &str| table[row][column].clone();
    assert_eq!(told(0, "termination"), "converged");
    for (row, cause, words) in [
        (1, "SCENE_INVALID", "material.body.poisson_ratio"),
        (2, "SCENE_INVALID", "obstacle.ball.shape.radius"),
        (3, "FILE", "none.msh"),
    ] {
        assert_eq!(told(row, "termination"), "refused");
        assert_eq!(told(row, "cause"), cause);
        assert!(told(row, "message").contains(words), "{:?}", table[row]);
        assert_eq!(told(row, "force"), "");
    }
    assert!(
        ended.stdout.contains("refused            3, such as case"),
        "{}",
        ended.stdout
    );
}

#[test]
fn a_case_that_always_ends_the_process_is_given_up() {
    let place = Place::new("ender", 3, "");
    let ended = place.run(&[]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    // The log as it is when case 1 has ended the process three times.
    let log = place.path("out.csv.log");
    let text = fs::read_to_string(&log).unwrap();
    let header = text.lines().next().unwrap();
    fs::write(&log, format!("{header}\n{}", "{\"begin\":1}\n".repeat(3))).unwrap();
    let ended = place.run(&["--resume"]);
    assert_eq!(ended.code, Some(3), "{}", ended.stderr);
    let table = place.table();
    assert_each_once(&table, 3);
    assert_eq!(
        (
            table[1]["termination"].as_str(),
            table[1]["attempts"].as_str()
        ),
        ("failed", "3")
    );
    assert!(
        table[1]["message"].contains("the process ended"),
        "{:?}",
        table[1]
    );
    assert_eq!(table[2]["termination"], "converged");
}

#[test]
fn the_first_interrupt_keeps_the_rows_and_resume_goes_on() {
    let place = Place::new("interrupt", 200, "");
    let mut study = place.start(&[]);
    place.wait_for_rows(3);
    let second = place.run(&["--resume"]);
    assert_eq!(second.code, Some(6), "{}", second.stderr);
    assert!(
        second.stderr.contains("another process"),
        "{}",
        second.stderr
    );
    study.signal("-INT");
    assert_eq!(study.0.wait().unwrap().code(), Some(130));
    let rows = place.table().len();
    assert!((3..200).contains(&rows), "{rows}");
    let changed = place.run(&["--resume", "--set", "material.body.shear_modulus=3"]);
    assert_eq!(changed.code, Some(4), "{}", changed.stderr);
    assert!(
        changed.stderr.contains("of another study"),
        "{}",
        changed.stderr
    );
    let ended = place.run(&["--resume"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert_each_once(&place.table(), 200);
}

#[test]
fn a_check_lists_the_cases_and_solves_none() {
    let place = Place::new("check", 40, "");
    let checked = place.run(&["--check"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    let lines: Vec<&str> = checked.stdout.lines().collect();
    assert_eq!(lines[0], "40 cases");
    assert_eq!(lines[1], "case,id,step.0.obstacle.ball.translation.2");
    assert!(
        lines[2].starts_with("0,00-") && lines[2].ends_with(",-0.05"),
        "{}",
        lines[2]
    );
    assert_eq!(lines.len(), 2 + 5 + 1);
    assert!(!Path::new(&place.path("out.csv.log")).exists());
}

#[test]
fn wrong_studies_are_refused_before_anything_runs() {
    let place = Place::new("refused", 2, "[list]\nfile = \"cases.csv\"\n");
    let refused = |cases: &str, out: &str| {
        fs::write(place.0.join("cases.csv"), cases).unwrap();
        let run = place.run_to(out, &[]);
        (run.code, run.stderr)
    };
    let out = place.path("out.csv");
    let (code, told) = refused("material.body.poison_ratio\n0.4\n", &out);
    assert_eq!(code, Some(4), "{told}");
    assert!(
        told.contains("material.body.poison_ratio: unknown key"),
        "{told}"
    );
    let (code, told) = refused("mesh_scale,name\n1\n", &out);
    assert_eq!(code, Some(4), "{told}");
    assert!(told.contains("cases.csv: line 2: has 1 cells"), "{told}");
    let input = place.path("cases.csv");
    let (code, told) = refused("mesh_scale\n1\n", &input);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("cases.csv: is read by the study"), "{told}");
    let (code, told) = refused("mesh_scale\n1\n", "out.txt");
    assert!(
        code == Some(2) && told.contains("neither .csv nor .parquet"),
        "{told}"
    );
    assert!(!Path::new(&place.path("out.csv.log")).exists());
}

#[test]
#[cfg(not(any(feature = "parquet", feature = "fleet")))]
fn what_a_build_does_not_have_is_refused_by_the_name_of_its_feature() {
    let place = Place::new("features", 2, "");
    let parquet = place.run_to("out.parquet", &[]);
    let queue = place.run(&["--queue", "nats://127.0.0.1:4222"]);
    for (run, feature) in [(parquet, "--features parquet"), (queue, "--features fleet")] {
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        assert!(run.stderr.contains(feature), "{}", run.stderr);
    }
}

#[test]
fn fields_of_each_case_are_in_a_folder_of_its_own() {
    let place = Place::new("fields", 2, "");
    let fields = place.path("fields");
    let ended = place.run(&["--fields", &fields]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for row in place.table() {
        let files = Path::new(&fields).join(&row["id"]);
        assert!(files.join("hertz-sphere_0001.vtu").exists(), "{row:?}");
        assert!(files.join("hertz-sphere_ball_0001.vtp").exists(), "{row:?}");
    }
}
