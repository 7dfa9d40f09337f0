//! `serve`: a server until a signal ends it.

use crate::arguments::ServeArguments;
use crate::exit::{Exit, Failure};

#[cfg(feature = "embedded")]
pub(super) async fn run(arguments: ServeArguments) -> Result<Exit, Failure> {
    use signorini_server::{Listener, serve, start_log};

    let config = configuration(arguments)?;
    start_log(&config);
    let usage = |error: &dyn std::error::Error| Failure::new(Exit::Usage, error.to_string());
    let listener = Listener::bind(&config)
        .await
        .map_err(|error| usage(&error))?;
    // Scripts that let the server choose a port read it here.
    crate::stdout::print(&format!("{}\n", listener.url()))?;
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
    config.data = arguments.data.unwrap_or(config.data);
    config.log_format = arguments.log_format.unwrap_or(config.log_format);
    config.log_level = arguments.log_level.unwrap_or(config.log_level);
    Ok(config)
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
