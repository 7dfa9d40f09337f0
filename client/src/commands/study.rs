//! `study`: every case of a study, its rows in a table.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_client::study::{COLUMNS_BEFORE, Study, cell};
use tokio::sync::watch;

use super::interrupts;
use crate::arguments::StudyArguments;
use crate::campaign::{self, Format, Header, Ledger, Local, RowLog, Server, Shared, Start, Tally};
use crate::exit::{Exit, Failure};
use crate::progress::Verbosity;
use crate::stdout::print;

/// Rows that a check shows.
const SHOWN: u64 = 5;

pub(super) async fn run(arguments: StudyArguments) -> Result<Exit, Failure> {
    let study = Study::open(&arguments.study, &arguments.overrides)?;
    let out = out(&arguments);
    let format = Format::of(&out)?;
    keep_inputs(&out, &arguments, &study)?;
    let workers = arguments.workers.unwrap_or_else(cores);
    let (address, access) = (arguments.server.clone(), &arguments.access);
    let server = Server::open(address, access.clone(), workers).await?;
    let local = Local::new(study, server, arguments.fields.clone(), arguments.tries);
    let local = Arc::new(local);
    let outcome = match arguments.check {
        true => check(&local).await,
        false => solve(&local, &arguments, (&out, format), workers).await,
    };
    if let Some(local) = Arc::into_inner(local) {
        local.server.close().await;
    }
    outcome
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Where the table goes.
fn out(arguments: &StudyArguments) -> PathBuf {
    let beside = || arguments.study.with_extension("results.csv");
    arguments.out.clone().unwrap_or_else(beside)
}

/// The log of a table.
fn log_of(out: &Path) -> PathBuf {
    let mut name = out.as_os_str().to_owned();
    name.push(".log");
    name.into()
}

/// The table may not take the place of what the study reads.
fn keep_inputs(out: &Path, arguments: &StudyArguments, study: &Study) -> Result<(), Failure> {
    let same = |input: &Path| {
        let whole = (input.canonicalize(), out.canonicalize());
        matches!(whole, (Ok(input), Ok(out)) if input == out)
    };
    let inputs = [Some(arguments.study.as_path()), study.list()];
    match inputs.into_iter().flatten().find(|input| same(input)) {
        Some(input) => {
            let message = "is read by the study and would be written over";
            Err(Failure::new(Exit::Usage, message).about(input))
        }
        None => Ok(()),
    }
}

/// Number of cases, the first of them, and what the server says of one.
async fn check(local: &Local) -> Result<Exit, Failure> {
    let study = &local.study;
    let mut writer = csv::Writer::from_writer(Vec::new());
    let keys = study.keys().iter().map(String::as_str);
    let mut rows = vec![
        COLUMNS_BEFORE
            .into_iter()
            .chain(keys)
            .map(str::to_owned)
            .collect(),
    ];
    for case in (0..study.count().min(SHOWN)).filter_map(|index| study.case(index)) {
        let values = case.values.iter();
        let values = values.map(|value| value.as_ref().map(cell).unwrap_or_default());
        let row: Vec<String> = [case.index.to_string(), case.id]
            .into_iter()
            .chain(values)
            .collect();
        rows.push(row);
    }
    let written = rows.iter().try_for_each(|row| writer.write_record(row));
    written.map_err(|error| Failure::new(Exit::Server, error.to_string()))?;
    let text = String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default();
    print(&format!("{} cases\n{text}", study.count()))?;
    let plan = local.plan_first().await?;
    for warning in &plan.warnings {
        crate::text::note(&format!("warning: {warning}\n"));
    }
    print("no faults in the first case\n")?;
    Ok(Exit::Ok)
}

async fn solve(
    local: &Arc<Local>,
    arguments: &StudyArguments,
    (out, format): (&Path, Format),
    workers: usize,
) -> Result<Exit, Failure> {
    let header = Header {
        study: local.study.digest().to_owned(),
        cases: local.study.count(),
        mesh: local.first_mesh().await?,
    };
    let start = match arguments.resume {
        true => Start::Resume,
        false => Start::Anew,
    };
    let mut tally = Tally::default();
    let log = RowLog::open(&log_of(out), &header, start, |row| tally.add(row))?;
    let verbosity = match arguments.quiet {
        true => Verbosity::Quiet,
        false => Verbosity::Normal,
    };
    let ledger = campaign::shared(Ledger::new(log, tally, header.cases, verbosity));
    let (stop, _) = watch::channel(false);
    let ended = tokio::select! {
        ended = campaign::run(Arc::clone(local), ledger.clone(), workers, &stop) => ended,
        never = interrupt(&stop, &ledger) => never,
    };
    finish(ended, &ledger, local, (out, format), verbosity)
}

/// The first time lets running cases go, the second time quits.
async fn interrupt(stop: &watch::Sender<bool>, ledger: &Shared) -> Result<(), Failure> {
    let mut interrupts = interrupts()?;
    while interrupts.recv().await.is_some() {
        if stop.send_replace(true) {
            ledger.lock().progress().clear();
            std::process::exit(Exit::Interrupted as i32);
        }
        let line = "stopping; press Ctrl-C again to quit at once";
        ledger.lock().progress().note(line);
    }
    std::future::pending().await
}

/// The table of what there is, and what people are told.
fn finish(
    ended: Result<(), Failure>,
    ledger: &Shared,
    local: &Local,
    (out, format): (&Path, Format),
    verbosity: Verbosity,
) -> Result<Exit, Failure> {
    let mut ledger = ledger.lock();
    ledger.progress().clear();
    ledger.log().sync()?;
    let (log, done) = (ledger.log().path().to_owned(), ledger.log().done());
    format.write(out, &local.study, &log)?;
    if verbosity != Verbosity::Quiet {
        print(&ledger.tally().lines().concat())?;
        print(&format!("{:<18} {}\n", "written", out.display()))?;
    }
    ended?;
    if done < local.study.count() {
        let line = format!(
            "{done} of {} cases; --resume goes on\n",
            local.study.count()
        );
        crate::text::note(&line);
        return Ok(Exit::Interrupted);
    }
    Ok(match ledger.tally().failures() {
        0 => Exit::Ok,
        _ => Exit::NotConverged,
    })
}
