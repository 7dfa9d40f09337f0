//! `bench`: measures families of scenes and writes table, figures and a page.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::arguments::BenchArguments;
use crate::bench::figures::{Figure, Results};
use crate::bench::machine::Machine;
use crate::bench::page::{self, LeftOut, Report};
use crate::bench::peers::{self, Peers};
use crate::bench::plan::{Extent, Plan, Wishes};
use crate::bench::reference::References;
use crate::bench::rounds::{Measured, Rounds};
use crate::bench::row::{self, Row};
use crate::bench::study_figures;
use crate::bench::workshop::{Workshop, WorkshopError};
use crate::exit::{Exit, Failure};
use crate::text::{note, print};

pub(super) async fn run(arguments: BenchArguments) -> Result<Exit, Failure> {
    let usage = |message: String| Failure::new(Exit::Usage, message);
    let plan = wishes(&arguments).plan().map_err(usage)?;
    if plan.cases.is_empty() {
        return Err(usage(
            "--levels: no chosen scene has one of them".to_owned(),
        ));
    }
    let references = References::shipped().map_err(usage)?;
    let peers = match &arguments.peers {
        Some(path) => peers::read(path).map_err(|message| Failure::new(Exit::Invalid, message))?,
        None => Peers::default(),
    };
    make_folder(&arguments.out)?;
    let started = Instant::now();
    let (exit, measured) = measure(&plan, arguments.meshes.clone()).await?;
    let minutes = started.elapsed().as_secs_f64() / 60.0;
    let (left_out, rows) = divided(measured, &references);
    let machine = Machine::here();
    let results = Results {
        rows,
        peers,
        references,
        machine,
    };
    let report = Report {
        chapters: results.chapters(),
        inquiries: study_figures::inquiries(&results, &plan.studies),
        left_out,
        minutes,
    };
    write(&arguments.out, &results, &report)?;
    Ok(exit_of(exit, &results.rows))
}

fn wishes(arguments: &BenchArguments) -> Wishes {
    let extent = match arguments.quick {
        true => Extent::Quick,
        false => Extent::Full,
    };
    Wishes {
        extent,
        scenes: arguments.scenes.clone(),
        studies: arguments.studies.clone(),
        levels: arguments.levels.clone(),
        methods: arguments.methods.clone(),
        tolerances: arguments.tolerances.clone(),
        repeats: arguments.repeats.map(usize::from),
        run_limit: arguments.run_limit.map(Duration::from_secs),
        budget: arguments.budget.map(Duration::from_secs),
        meshes: arguments.meshes.clone(),
    }
}

/// Until the plan is done or Ctrl-C is pressed; what was measured is kept.
async fn measure(plan: &Plan, meshes: Option<PathBuf>) -> Result<(Exit, Vec<Measured>), Failure> {
    let program = std::env::current_exe()
        .map_err(|error| Failure::new(Exit::Server, format!("this program: {error}")))?;
    let workshop = Workshop::open(meshes).map_err(|error| unavailable(&error))?;
    let mut rounds = Rounds::new(plan, &workshop, program);
    let mut interrupts = super::interrupts()?;
    let exit = tokio::select! {
        outcome = rounds.run(note) => outcome.map(|()| Exit::Ok).map_err(|error| unavailable(&error))?,
        _pressed = interrupts.recv() => Exit::Interrupted,
    };
    Ok((exit, rounds.into_measured()))
}

fn unavailable(error: &WorkshopError) -> Failure {
    let exit = match error {
        WorkshopError::NoMesh { .. } => Exit::Invalid,
        WorkshopError::Unwritable { .. } => Exit::Usage,
    };
    Failure::new(exit, error.to_string())
}

/// What did not run, and the rows of what did.
fn divided(measured: Vec<Measured>, references: &References) -> (Vec<LeftOut>, Vec<Row>) {
    let reason = |item: &Measured| Some((item.case.name(), item.left_out.clone()?));
    let left_out = measured.iter().filter_map(reason).collect();
    let rows = measured
        .into_iter()
        .filter_map(|item| Row::new(item, references));
    let mut rows: Vec<Row> = rows.collect();
    rows.sort_by_key(|row| row.case.family.name);
    (left_out, rows)
}

/// A bench in which nothing converged is no bench.
fn exit_of(exit: Exit, rows: &[Row]) -> Exit {
    if exit == Exit::Ok && !rows.iter().any(Row::converged) {
        return Exit::NotConverged;
    }
    exit
}

fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| Failure::unwritable(path, &error))
}

fn write(out: &Path, results: &Results, report: &Report) -> Result<(), Failure> {
    let table = row::csv(&results.rows, &results.machine);
    let table = table.map_err(|message| Failure::new(Exit::Server, message))?;
    let file = |name: &str, content: &[u8]| {
        let path = out.join(name);
        std::fs::write(&path, content).map_err(|error| Failure::unwritable(&path, &error))
    };
    file("bench.csv", &table)?;
    for Figure { name, svg } in report.figures() {
        file(&format!("{name}.svg"), svg.as_bytes())?;
    }
    let page = page::html(results, report);
    file("index.html", page.as_bytes())?;
    print(&format!("{}\n", out.join("index.html").display()))
}
