//! The commands, one module each.

#[cfg(feature = "bench")]
mod bench;
mod cancel;
#[cfg(feature = "embedded")]
mod certs;
mod check;
mod completions;
#[cfg(feature = "embedded")]
mod config;
#[cfg(feature = "embedded")]
mod data;
mod deck_draft;
pub(crate) mod embed;
mod fetch;
#[cfg(feature = "embedded")]
mod fit;
#[cfg(feature = "fleet")]
mod fleet;
mod init;
#[cfg(feature = "embedded")]
mod library_mesh;
mod man;
mod mesh;
mod mesh_shape;
mod plan;
#[cfg(feature = "embedded")]
mod refine;
mod report;
mod scene_draft;
mod serve;
mod session;
mod solve;
mod study;
#[cfg(feature = "embedded")]
mod token;
mod version;
mod watch;
mod worker;

use std::time::Instant;

use signorini_client::Client;
use signorini_proto::v1;
use tokio::signal::unix::{Signal, SignalKind, signal};

use crate::arguments::{Arguments, Command};
use crate::terminal::exit::{Exit, Failure};
use crate::terminal::text::note;

/// Runs a command. `started` is when the process began.
pub(crate) fn run(arguments: Arguments, started: Instant) -> Result<Exit, Failure> {
    let runtime = tokio::runtime::Runtime::new()
        .map_err(|error| Failure::new(Exit::Server, format!("no runtime: {error}")))?;
    match arguments.command {
        Command::Solve(arguments) => runtime.block_on(Box::pin(solve::run(arguments, started))),
        Command::Study(arguments) => runtime.block_on(Box::pin(study::run(arguments))),
        Command::Worker(arguments) => runtime.block_on(Box::pin(worker::run(arguments))),
        Command::Watch(arguments) => runtime.block_on(Box::pin(watch::run(arguments, started))),
        Command::Fetch(arguments) => runtime.block_on(Box::pin(fetch::run(arguments, started))),
        Command::Cancel(arguments) => runtime.block_on(cancel::run(arguments)),
        Command::Check(arguments) => runtime.block_on(check::run(arguments)),
        Command::Plan(arguments) => runtime.block_on(plan::run(arguments)),
        Command::Init { mesh, scene } => init::run(&mesh, scene),
        #[cfg(feature = "embedded")]
        Command::Refine(arguments) => refine::run(&arguments),
        #[cfg(feature = "embedded")]
        Command::Fit(arguments) => runtime.block_on(Box::pin(fit::run(arguments))),
        Command::Report { folder } => report::run(&folder),
        Command::Serve(arguments) => runtime.block_on(serve::run(arguments)),
        #[cfg(feature = "embedded")]
        Command::Config(command) => config::run(command),
        #[cfg(feature = "embedded")]
        Command::Backup { data, target, link } => {
            let copying = link.then_some(signorini_server::Copying::Links);
            data::backup(&data, &target, copying.unwrap_or_default())
        }
        #[cfg(feature = "embedded")]
        Command::Restore { backup, data } => data::restore(&backup, &data),
        #[cfg(feature = "embedded")]
        Command::Fsck { folder } => data::fsck(&folder),
        #[cfg(feature = "embedded")]
        Command::Doctor { folder, proxy } => data::doctor(&folder, proxy.as_deref()),
        #[cfg(feature = "embedded")]
        Command::Token(command) => token::run(command),
        #[cfg(feature = "embedded")]
        Command::Certs(command) => certs::run(command),
        #[cfg(feature = "bench")]
        Command::Bench(arguments) => runtime.block_on(Box::pin(bench::run(arguments))),
        Command::Mesh(command) => runtime.block_on(mesh::run(command)),
        Command::Session(command) => runtime.block_on(session::run(command)),
        #[cfg(feature = "fleet")]
        Command::Fleet(command) => runtime.block_on(fleet::run(command)),
        #[cfg(not(feature = "fleet"))]
        Command::Fleet(_) => Err(without_queue()),
        Command::Embed(command) => runtime.block_on(embed::run(command)),
        Command::Version => version::run(),
        Command::Completions { shell } => completions::run(shell),
        Command::Man { folder } => man::run(&folder),
    }
}

/// Presses of Ctrl-C, and wishes of the system that the process end, from now on.
struct Interrupts(Signal, Signal);

impl Interrupts {
    fn new() -> Result<Self, Failure> {
        let listen = |kind| {
            signal(kind).map_err(|error| Failure::new(Exit::Server, format!("no signals: {error}")))
        };
        let terminations = listen(SignalKind::terminate())?;
        Ok(Self(listen(SignalKind::interrupt())?, terminations))
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.0.recv() => {}
            _ = self.1.recv() => {}
        }
    }
}

/// Tells the work to stop when Ctrl-C is pressed or the system asks the process to end, and quits
/// when that happens again.
async fn stop_when_interrupted(
    stop: &tokio::sync::watch::Sender<bool>,
    tell: impl Fn(&str),
) -> Result<(), Failure> {
    let mut interrupts = Interrupts::new()?;
    loop {
        interrupts.next().await;
        if stop.send_replace(true) {
            tell("stopped");
            std::process::exit(Exit::Interrupted as i32);
        }
        tell("stopping; press Ctrl-C again to quit at once");
    }
}

/// Writes a line for people.
#[cfg(feature = "fleet")]
fn tell(line: &str) {
    note(&format!("{line}\n"));
}

/// Why there are no queues.
#[cfg(not(feature = "fleet"))]
fn without_queue() -> Failure {
    let message = "this build knows neither queues nor fleets: build it with `--features fleet`";
    Failure::new(Exit::Usage, message)
}

/// A session and its scene; tells when its first results are gone.
async fn open_session(client: &Client, name: &str) -> Result<(v1::Session, v1::Scene), Failure> {
    let mut session = client.get_session(name).await?;
    let scene = session.scene.take().unwrap_or_default();
    if session.first_retained_sequence > 1 {
        note(&format!(
            "results before step {} are no longer kept\n",
            session.first_retained_sequence
        ));
    }
    Ok((session, scene))
}

/// The smallest field of the scene's output: naming none asks for all of them.
fn lightest_field(scene: &v1::Scene) -> Vec<v1::FieldName> {
    let weight = |field: &v1::FieldName| match field {
        v1::FieldName::ContactState
        | v1::FieldName::ContactPath
        | v1::FieldName::Gap
        | v1::FieldName::ContactPressure
        | v1::FieldName::ContactPressureDeformed
        | v1::FieldName::ContactPressureUndeformed => 1,
        v1::FieldName::Pressure | v1::FieldName::ErrorEstimate | v1::FieldName::ErrorDensity => 2,
        v1::FieldName::Unspecified
        | v1::FieldName::Displacement
        | v1::FieldName::FrictionTraction
        | v1::FieldName::Slip
        | v1::FieldName::LowestMode
        | v1::FieldName::NodalForce
        | v1::FieldName::MeshGradient
        | v1::FieldName::Stress
        | v1::FieldName::Jacobian => 3,
    };
    let output = scene.output.as_ref();
    let fields = output.into_iter().flat_map(|output| output.fields());
    fields.min_by_key(weight).into_iter().collect()
}
