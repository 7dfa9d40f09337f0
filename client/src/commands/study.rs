//! `study`: every case of a study, its rows in a table.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use signorini_client::study::{COLUMNS_BEFORE, Study, cell};
use tokio::sync::watch;

use super::stop_when_interrupted;
use crate::arguments::StudyArguments;
use crate::studies::{self, Format, Header, Ledger, Local, RowLog, Server, Shared, Start, Tally};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::progress::Verbosity;
use crate::terminal::stdout::print;

/// Rows that a check shows.
const SHOWN: u64 = 5;

pub(super) async fn run(arguments: StudyArguments) -> Result<Exit, Failure> {
    let study = Study::open(&arguments.study, &arguments.overrides)?;
    let out = out(&arguments);
    let table = (out.as_path(), Format::of(&out)?);
    keep_inputs(&out, &arguments, &study)?;
    match &arguments.queue.queue {
        Some(url) if !arguments.check => Box::pin(queued(&study, &arguments, url, table)).await,
        Some(_) | None => local(study, &arguments, table).await,
    }
}

/// Solves the cases on a server, or checks the first.
async fn local(
    study: Study,
    arguments: &StudyArguments,
    table: (&Path, Format),
) -> Result<Exit, Failure> {
    let workers = arguments.workers.unwrap_or_else(cores);
    let (address, access) = (arguments.server.clone(), arguments.access.clone());
    let slots = arguments.threads.slots(workers);
    let server = Server::open(address, access, slots).await?;
    let local = Local::new(study, server, arguments.fields.clone(), arguments.tries);
    let local = Arc::new(local);
    let outcome = if arguments.check {
        check(&local).await
    } else {
        solve(&local, arguments, table, workers).await
    };
    if let Some(local) = Arc::into_inner(local) {
        local.server.close().await;
    }
    outcome
}

#[cfg(not(feature = "fleet"))]
#[allow(clippy::unused_async)]
async fn queued(
    _study: &Study,
    _arguments: &StudyArguments,
    _url: &str,
    _table: (&Path, Format),
) -> Result<Exit, Failure> {
    Err(super::without_queue())
}

/// Lets the workers of a queue solve the cases.
#[cfg(feature = "fleet")]
async fn queued(
    study: &Study,
    arguments: &StudyArguments,
    url: &str,
    table: (&Path, Format),
) -> Result<Exit, Failure> {
    let queue = studies::Queue::open(&arguments.queue, url).await?;
    let assets = studies::Assets::default();
    let mesh = studies::first_scene(study, &assets, &queue).await?.mesh;
    let name = studies::name_of(study, &mesh);
    let ledger = ledger(study, arguments, table.0, mesh)?;
    let manifest = studies::Manifest {
        wanted: study.wanted().to_vec(),
        tries: arguments.tries,
        fields: arguments.fields.is_some(),
    };
    let (stop, _) = watch::channel(false);
    let queued = studies::Queued {
        queue: &queue,
        study,
        name: &name,
        assets: &assets,
        ledger: &ledger,
    };
    let ended = tokio::select! {
        ended = studies::run_study(&queued, &manifest, start(arguments), &stop) => ended,
        never = stop_when_interrupted(&stop, |line| ledger.lock().progress().note(line)) => never,
    };
    write_table(&ledger, study, table, verbosity(arguments))?;
    ended?;
    Ok(exit(&ledger, study))
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
    let scene = local.first_scene().await?;
    let plan = local.server.client().await.plan(scene).await?;
    for warning in &plan.warnings {
        crate::terminal::text::note(&format!("warning: {warning}\n"));
    }
    print("no faults in the first case\n")?;
    Ok(Exit::Ok)
}

async fn solve(
    local: &Arc<Local>,
    arguments: &StudyArguments,
    table: (&Path, Format),
    workers: usize,
) -> Result<Exit, Failure> {
    let mesh = local.first_scene().await?.mesh;
    let ledger = ledger(&local.study, arguments, table.0, mesh)?;
    let (stop, _) = watch::channel(false);
    let ended = tokio::select! {
        ended = studies::run(Arc::clone(local), ledger.clone(), workers, &stop) => ended,
        never = stop_when_interrupted(&stop, |line| ledger.lock().progress().note(line)) => never,
    };
    write_table(&ledger, &local.study, table, verbosity(arguments))?;
    ended?;
    Ok(exit(&ledger, &local.study))
}

fn verbosity(arguments: &StudyArguments) -> Verbosity {
    if arguments.quiet {
        Verbosity::Quiet
    } else {
        Verbosity::Normal
    }
}

/// What a log and a queue that are there mean.
fn start(arguments: &StudyArguments) -> Start {
    if arguments.resume {
        Start::Resume
    } else {
        Start::Anew
    }
}

/// The log beside the table, with the rows that it has.
fn ledger(
    study: &Study,
    arguments: &StudyArguments,
    out: &Path,
    mesh: String,
) -> Result<Shared, Failure> {
    let header = Header {
        study: study.digest().to_owned(),
        cases: study.count(),
        mesh,
    };
    let mut tally = Tally::default();
    let log = RowLog::open(&log_of(out), &header, start(arguments), |row| {
        tally.add(row)
    })?;
    // Rows of an earlier run that this one does not go on with are gone.
    let tally = match log.done() {
        0 => Tally::default(),
        _ => tally,
    };
    let ledger = Ledger::new(log, tally, header.cases, verbosity(arguments));
    Ok(studies::shared(ledger))
}

/// The table of what there is, and what people are told.
fn write_table(
    ledger: &Shared,
    study: &Study,
    (out, format): (&Path, Format),
    verbosity: Verbosity,
) -> Result<(), Failure> {
    let mut ledger = ledger.lock();
    ledger.progress().clear();
    ledger.log().sync()?;
    let log = ledger.log().path().to_owned();
    format.write(out, study, &log)?;
    if verbosity != Verbosity::Quiet {
        print(&ledger.tally().lines().concat())?;
        print(&format!("{:<18} {}\n", "written", out.display()))?;
    }
    Ok(())
}

/// How a study that nothing broke has ended.
fn exit(ledger: &Shared, study: &Study) -> Exit {
    let mut ledger = ledger.lock();
    let done = ledger.log().done();
    if done < study.count() {
        let line = format!("{done} of {} cases; --resume goes on\n", study.count());
        crate::terminal::text::note(&line);
        return Exit::Interrupted;
    }
    match ledger.tally().failures() {
        0 => Exit::Ok,
        _ => Exit::NotConverged,
    }
}
