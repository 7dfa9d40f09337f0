//! Studies through a queue: every case has one row, whatever is killed. Needs `nats-server`, and
//! says so where it is not there.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::process::Process;
use common::{example, folder, signorini};

/// A queue and a study of so many depths.
struct Place {
    folder: PathBuf,
    port: u16,
}

impl Place {
    /// None where there is no `nats-server`.
    fn new(test: &str, depths: usize) -> Option<Self> {
        if Command::new("nats-server")
            .arg("--version")
            .output()
            .is_err()
        {
            eprintln!("left out: nats-server is not there");
            return None;
        }
        let folder = folder(&format!("queue_{test}"));
        let scene = fs::read_to_string(example("hertz-sphere.toml")).unwrap();
        let mesh = example("meshes/indent_l1.msh");
        let scene = scene.replace("meshes/indent_l3.msh", mesh.to_str().unwrap());
        fs::write(folder.join("scene.toml"), scene.replace("1e-10", "1e-6")).unwrap();
        let study = format!(
            "scene = \"scene.toml\"\n[[grid]]\nkey = \"step.0.obstacle.ball.translation.2\"\n\
             from = -0.05\nto = -0.02\ncount = {depths}\n[[result]]\nname = \"force\"\n\
             of = \"obstacles.ball.force.z\"\n"
        );
        fs::write(folder.join("study.toml"), study).unwrap();
        let port = TcpListener::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap()
            .port();
        Some(Self { folder, port })
    }

    fn nats(&self) -> Process {
        let (port, store) = (self.port.to_string(), self.folder.join("store"));
        let mut command = Command::new("nats-server");
        command
            .args(["-js", "-a", "127.0.0.1", "-p", &port, "-sd"])
            .arg(store);
        let nats = Process(
            command
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap(),
        );
        let begun = Instant::now();
        while TcpStream::connect(("127.0.0.1", self.port)).is_err() {
            assert!(
                begun.elapsed() < Duration::from_secs(30),
                "nats-server does not start"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        nats
    }

    fn spawn(&self, arguments: &[&str]) -> Process {
        let url = format!("nats://127.0.0.1:{}", self.port);
        let mut command = signorini();
        command
            .args(arguments)
            .args(["--queue", &url])
            .current_dir(&self.folder);
        Process(
            command
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap(),
        )
    }

    fn worker(&self, more: &[&str]) -> Process {
        self.spawn(&[&["worker", "--threads", "1"], more].concat())
    }

    fn study(&self, more: &[&str]) -> Process {
        self.spawn(
            &[
                &["study", "study.toml", "--quiet", "--out", "out.csv"],
                more,
            ]
            .concat(),
        )
    }

    fn rows(&self) -> usize {
        let log = fs::read_to_string(self.folder.join("out.csv.log")).unwrap_or_default();
        log.lines()
            .filter(|line| line.starts_with("{\"row\""))
            .count()
    }

    fn wait_for_rows(&self, rows: usize) {
        let begun = Instant::now();
        while self.rows() < rows {
            assert!(
                begun.elapsed() < Duration::from_secs(120),
                "{} rows",
                self.rows()
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Rows of the table, each case once.
    fn table(&self, count: usize) -> Vec<BTreeMap<String, String>> {
        let mut reader = csv::Reader::from_path(self.folder.join("out.csv")).unwrap();
        let table: Vec<BTreeMap<String, String>> =
            reader.deserialize().map(Result::unwrap).collect();
        let cases: Vec<usize> = table
            .iter()
            .map(|row| row["case"].parse().unwrap())
            .collect();
        assert_eq!(cases, (0..count).collect::<Vec<_>>());
        assert_eq!(self.rows(), count);
        table
    }
}

fn ends(mut process: Process, code: i32) {
    let mut told = String::new();
    let stderr = process.0.stderr.take().unwrap();
    for line in BufReader::new(stderr).lines() {
        told.push_str(&line.unwrap());
    }
    assert_eq!(process.0.wait().unwrap().code(), Some(code), "{told}");
}

fn kill(mut process: Process) {
    process.signal("-KILL");
    process.0.wait().unwrap();
}

#[test]
fn every_case_has_one_row_though_workers_the_queue_and_the_study_are_killed() {
    const CASES: usize = 80;
    let Some(place) = Place::new("killed", CASES) else {
        return;
    };
    let mut nats = place.nats();
    let (first, _second) = (place.worker(&[]), place.worker(&[]));
    let study = place.study(&[]);
    place.wait_for_rows(10);
    kill(first);
    let _third = place.worker(&[]);
    place.wait_for_rows(25);
    kill(nats);
    nats = place.nats();
    place.wait_for_rows(40);
    kill(study);
    ends(place.study(&["--resume"]), 0);
    let table = place.table(CASES);
    assert!(
        table
            .iter()
            .all(|row| row["termination"] == "converged" && !row["force"].is_empty())
    );
    drop(nats);
}

#[test]
fn a_case_that_ends_its_workers_is_given_up_with_its_cause() {
    let Some(place) = Place::new("ender", 3) else {
        return;
    };
    let _nats = place.nats();
    let mut victim = place.worker(&["--verbose"]);
    // Long enough to be killed in.
    let long = ["--tries", "1", "--set", "step.0.increments=40"];
    let study = place.study(&long);
    let lines = BufReader::new(victim.0.stderr.take().unwrap()).lines();
    let begins = lines
        .map(Result::unwrap)
        .find(|line| line.starts_with("begins: case 1-"));
    assert!(begins.is_some());
    kill(victim);
    let _other = place.worker(&[]);
    ends(study, 3);
    let table = place.table(3);
    // Case 1 may have been solved in the moment before its worker was killed.
    let (ended, cause) = (table[1]["termination"].as_str(), table[1]["cause"].as_str());
    assert!(
        matches!((ended, cause), ("failed", "worker_lost")),
        "{table:?}"
    );
    assert_eq!(
        (
            table[0]["termination"].as_str(),
            table[2]["termination"].as_str()
        ),
        ("converged", "converged")
    );
}

#[test]
fn an_interrupted_study_takes_its_cases_back_and_resume_hands_them_out_again() {
    let Some(place) = Place::new("interrupt", 20) else {
        return;
    };
    let _nats = place.nats();
    let study = place.study(&[]);
    // All are published, nobody takes them.
    std::thread::sleep(Duration::from_secs(2));
    study.signal("-INT");
    ends(study, 130);
    let idle = place.worker(&["--idle", "1"]);
    ends(idle, 0);
    assert_eq!(place.rows(), 0);
    let study = place.study(&["--resume"]);
    let worker = place.worker(&["--idle", "5"]);
    ends(study, 0);
    place.table(20);
    ends(worker, 0);
}

#[test]
fn a_worker_tells_prometheus_how_its_cases_ended_and_gives_its_case_back_when_it_is_asked_to_end() {
    let Some(place) = Place::new("metrics", 6) else {
        return;
    };
    let _nats = place.nats();
    let study = place.study(&["--set", "step.0.increments=40"]);
    let mut first = place.worker(&["--verbose"]);
    let mut line = String::new();
    BufReader::new(first.0.stderr.as_mut().unwrap())
        .read_line(&mut line)
        .unwrap();
    assert!(line.starts_with("begins: case 0-"), "{line}");
    first.signal("-TERM");
    assert_eq!(first.0.wait().unwrap().code(), Some(130));
    let port = TcpListener::bind("127.0.0.1:0").unwrap();
    let page = port.local_addr().unwrap();
    drop(port);
    let worker = place.worker(&["--metrics", &page.to_string()]);
    ends(study, 0);
    assert_eq!(place.table(6)[0]["attempts"], "2");
    let mut stream = TcpStream::connect(page).unwrap();
    stream
        .write_all(b"GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        .unwrap();
    let mut told = String::new();
    stream.read_to_string(&mut told).unwrap();
    for line in [
        "signorini_worker_cases_total{termination=\"converged\"} 6",
        "signorini_worker_given_back_total 0",
        "signorini_worker_solve_seconds_count 6",
        "signorini_worker_overhead_seconds_count 6",
    ] {
        assert!(told.contains(line), "{line}: {told}");
    }
    kill(worker);
}

#[test]
fn a_queue_that_is_not_there_is_told() {
    let Some(place) = Place::new("none", 2) else {
        return;
    };
    ends(place.study(&[]), 5);
    ends(place.worker(&[]), 5);
}
