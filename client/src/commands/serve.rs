//! `serve`: a server until a signal ends it.

use crate::arguments::ServeArguments;
use crate::terminal::exit::{Exit, Failure};

#[cfg(feature = "embedded")]
pub(super) async fn run(arguments: ServeArguments) -> Result<Exit, Failure> {
    use signorini_server::{
        Hangups, Listener, follow_log_level, return_freed_memory, serve_and_tell, start_log,
    };

    tokio::spawn(return_freed_memory());
    let flags = arguments.flags;
    let mut config = super::config::resolved(&flags)?.config;
    config.compared = crate::arguments::compared::compared();
    let level = move || flags.log_level_now().map_err(|error| error.to_string());
    let hangups = Hangups::of_process();
    tokio::spawn(follow_log_level(start_log(&config), hangups.clone(), level));
    let usage = |error: &dyn std::error::Error| Failure::new(Exit::Usage, error.to_string());
    let listener = Listener::bind(&config)
        .await
        .map_err(|error| usage(&error))?;
    // Scripts that let the server choose a port read it here.
    let mut told = Ok(());
    let tell = |url: &str| told = crate::terminal::stdout::print(&format!("{url}\n"));
    serve_and_tell(listener, config, (stop_signal(), hangups), tell)
        .await
        .map_err(|error| Failure::new(Exit::Server, error.to_string()))?;
    told?;
    Ok(Exit::Ok)
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
