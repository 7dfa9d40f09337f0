//! The server as a program: arguments, settings, log, serve, drain.

use std::process::ExitCode;

use clap::Parser;
use signorini_server::{
    Flags, Hangups, LargePages, Listener, follow_log_level, return_freed_memory, serve_and_tell,
    start_log,
};

#[global_allocator]
static MEMORY: LargePages = LargePages;

/// Serves contact problems of nearly incompressible bodies over gRPC.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    flags: Flags,
}

#[tokio::main]
async fn main() -> ExitCode {
    match run(Arguments::parse().flags).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Said whatever the log takes: it is why there is no server.
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn run(flags: Flags) -> Result<(), Box<dyn std::error::Error>> {
    tokio::spawn(return_freed_memory());
    let config = flags.resolve()?.config;
    let level = move || flags.log_level_now().map_err(|error| error.to_string());
    let hangups = Hangups::of_process();
    tokio::spawn(follow_log_level(start_log(&config), hangups.clone(), level));
    let listener = Listener::bind(&config).await?;
    let signals = (stop_signal()?, hangups);
    serve_and_tell(listener, config, signals, |_| ()).await?;
    Ok(())
}

/// Completes at SIGTERM or ctrl-c; a second signal ends the process at once.
fn stop_signal() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let (first, stop) = tokio::sync::oneshot::channel();
    tokio::spawn(async move {
        let mut first = Some(first);
        loop {
            tokio::select! {
                _ = terminate.recv() => {}
                _ = interrupt.recv() => {}
            }
            match first.take() {
                // Nobody listens any more when the server has failed already.
                Some(first) => drop(first.send(())),
                None => std::process::exit(1),
            }
        }
    });
    Ok(async {
        // A sender that is gone means that no signal can come.
        let _stop = stop.await;
    })
}
