//! `serve`: a server until a signal ends it.

use crate::arguments::ServeArguments;
use crate::exit::{Exit, Failure};

#[cfg(feature = "embedded")]
pub(super) async fn run(arguments: ServeArguments) -> Result<Exit, Failure> {
    use signorini_server::{Listener, serve};

    log_to_stderr();
    let config = configuration(arguments)?;
    let usage = |error: &dyn std::error::Error| Failure::new(Exit::Usage, error.to_string());
    let listener = Listener::bind(&config)
        .await
        .map_err(|error| usage(&error))?;
    // Scripts that let the server choose a port read it here.
    crate::text::print(&format!("{}\n", listener.url()))?;
    serve(listener, config, stop_signal())
        .await
        .map_err(|error| Failure::new(Exit::Server, error.to_string()))?;
    Ok(Exit::Ok)
}

/// Defaults, then the file, then the arguments.
#[cfg(feature = "embedded")]
fn configuration(arguments: ServeArguments) -> Result<signorini_server::Config, Failure> {
    use signorini_server::Config;

    let mut config = match arguments.config {
        None => Config::default(),
        Some(path) => {
            let text = std::fs::read_to_string(&path).map_err(|error| {
                Failure::new(Exit::Usage, format!("{}: {error}", path.display()))
            })?;
            Config::from_toml(&text).map_err(|error| {
                Failure::new(Exit::Usage, format!("{}: {error}", path.display()))
            })?
        }
    };
    config.listen = arguments.listen.unwrap_or(config.listen);
    config.metrics_listen = arguments.metrics_listen.unwrap_or(config.metrics_listen);
    Ok(config)
}

/// Logs of level `info`, or as `RUST_LOG` says.
#[cfg(feature = "embedded")]
fn log_to_stderr() {
    use std::io::IsTerminal as _;

    use tracing_subscriber::EnvFilter;

    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let subscriber = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(colours);
    // A subscriber that is set already keeps its place.
    let _set = subscriber.with_writer(std::io::stderr).try_init();
}

/// Ends with the first interrupt or termination signal; the second one quits.
#[cfg(feature = "embedded")]
async fn stop_signal() {
    use tokio::signal::unix::{SignalKind, signal};

    let (Ok(mut interrupt), Ok(mut terminate)) = (
        signal(SignalKind::interrupt()),
        signal(SignalKind::terminate()),
    ) else {
        return std::future::pending().await;
    };
    let mut next = async move || {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    };
    next().await;
    tokio::spawn(async move {
        next().await;
        std::process::exit(Exit::Interrupted as i32);
    });
}

#[cfg(not(feature = "embedded"))]
#[allow(clippy::unused_async)]
pub(super) async fn run(_arguments: ServeArguments) -> Result<Exit, Failure> {
    Err(Failure::new(
        Exit::Usage,
        "this build has no server; install the package signorini-server",
    ))
}
