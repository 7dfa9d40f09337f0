//! The server as a program: arguments, settings, log, serve, drain.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use signorini_server::{Config, Listener, LogFormat, LogLevel, follow_log_level, serve, start_log};

/// Serves contact problems of nearly incompressible bodies over gRPC.
#[derive(Clone, Parser)]
#[command(version)]
struct Arguments {
    /// Settings in TOML; every key has a default.
    #[arg(long, value_name = "FILE", env = "SIGNORINI_CONFIG")]
    config: Option<PathBuf>,
    /// Address of the service: 127.0.0.1:PORT or unix:/path.
    #[arg(long, value_name = "ADDRESS", env = "SIGNORINI_LISTEN")]
    listen: Option<String>,
    /// Address of the metrics page, 127.0.0.1:PORT; empty for none.
    #[arg(long, value_name = "ADDRESS", env = "SIGNORINI_METRICS_LISTEN")]
    metrics_listen: Option<String>,
    /// Data folder, made if it is missing; without one nothing outlives the server.
    #[arg(long, value_name = "DIR", env = "SIGNORINI_DATA")]
    data: Option<String>,
    /// How the log is written.
    #[arg(long, value_name = "FORMAT", env = "SIGNORINI_LOG_FORMAT")]
    log_format: Option<LogFormat>,
    /// The least important lines of the log; `RUST_LOG` goes before it.
    #[arg(long, value_name = "LEVEL", env = "SIGNORINI_LOG_LEVEL")]
    log_level: Option<LogLevel>,
}

#[tokio::main]
async fn main() -> ExitCode {
    match run(Arguments::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Said whatever the log takes: it is why there is no server.
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn run(arguments: Arguments) -> Result<(), Box<dyn std::error::Error>> {
    let config = config(arguments.clone())?;
    let level = move || level(arguments.clone());
    tokio::spawn(follow_log_level(start_log(&config), level));
    let listener = Listener::bind(&config).await?;
    serve(listener, config, stop_signal()?).await?;
    Ok(())
}

fn config(arguments: Arguments) -> Result<Config, Box<dyn std::error::Error>> {
    let mut config = match &arguments.config {
        Some(path) => {
            let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
            let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
            Config::from_toml(&text).map_err(|error| at(&error))?
        }
        None => Config::default(),
    };
    config.listen = arguments.listen.unwrap_or(config.listen);
    config.metrics_listen = arguments.metrics_listen.unwrap_or(config.metrics_listen);
    config.data = arguments.data.unwrap_or(config.data);
    config.log_format = arguments.log_format.unwrap_or(config.log_format);
    config.log_level = arguments.log_level.unwrap_or(config.log_level);
    Ok(config)
}

/// The level of the log that the settings name now; none where no file names one.
fn level(arguments: Arguments) -> Result<Option<LogLevel>, String> {
    if arguments.config.is_none() {
        return Ok(None);
    }
    let config = config(arguments).map_err(|error| error.to_string())?;
    Ok(Some(config.log_level))
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
