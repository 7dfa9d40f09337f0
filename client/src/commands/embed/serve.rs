//! A server for one caller: it ends when the caller closes its stdin, also by dying.

use crate::terminal::exit::{Exit, Failure};

#[cfg(feature = "embedded")]
pub(super) async fn run(listen: String) -> Result<Exit, Failure> {
    use signorini_server::{Config, Listener, serve};

    let config = Config {
        listen,
        compared: crate::arguments::compared::compared(),
        ..Config::embedded()
    };
    let listener = Listener::bind(&config)
        .await
        .map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    crate::terminal::stdout::print(&format!("{}\n", listener.url()))?;
    serve(listener, config, end_of_stdin())
        .await
        .map_err(|error| Failure::new(Exit::Server, error.to_string()))?;
    Ok(Exit::Ok)
}

/// Completes when nobody can write to stdin any more.
#[cfg(feature = "embedded")]
async fn end_of_stdin() {
    let (ended, wait) = tokio::sync::oneshot::channel();
    // Not a task: a runtime that ends would wait for its read.
    std::thread::spawn(move || {
        let _read = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        let _gone = ended.send(());
    });
    let _ended = wait.await;
}

#[cfg(not(feature = "embedded"))]
#[allow(clippy::unused_async)]
pub(super) async fn run(_listen: String) -> Result<Exit, Failure> {
    Err(Failure::new(Exit::Usage, "this build has no server"))
}
