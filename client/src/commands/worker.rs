//! `worker`: solves cases of studies from a queue.

use crate::arguments::WorkerArguments;
use crate::terminal::exit::{Exit, Failure};

#[cfg(not(feature = "fleet"))]
#[allow(clippy::unused_async)]
pub(super) async fn run(_arguments: WorkerArguments) -> Result<Exit, Failure> {
    Err(super::without_queue())
}

#[cfg(feature = "fleet")]
pub(super) async fn run(arguments: WorkerArguments) -> Result<Exit, Failure> {
    use std::sync::Arc;
    use std::time::Duration;

    use tokio::sync::watch;

    use crate::studies::{Fields, Queue, Server, Worker, work};
    use crate::terminal::progress::Verbosity;

    let url = arguments.queue.queue.as_deref();
    let url = url.ok_or_else(|| Failure::new(Exit::Usage, "--queue URL is missing"))?;
    let page = match arguments.metrics {
        Some(address) => Some(page(address).await?),
        None => None,
    };
    let queue = Queue::open(&arguments.queue, url).await?;
    let (address, access) = (arguments.server.clone(), arguments.access.clone());
    let slots = arguments.threads.slots(arguments.workers);
    let server = Server::open(address, access, slots).await?;
    let worker = Arc::new(Worker {
        queue,
        server,
        fields: arguments.fields.map(Fields::new),
        idle: arguments.idle.map(Duration::from_secs),
        verbosity: Verbosity::of(arguments.verbose),
        manifests: Default::default(),
        gauges: page.as_ref().map(|(gauges, _)| Arc::clone(gauges)),
    });
    let page = page.map(|(gauges, listener)| tokio::spawn(gauges.serve(listener)));
    let (stop, _) = watch::channel(false);
    let ended = tokio::select! {
        ended = work(Arc::clone(&worker), arguments.workers, &stop) => ended,
        never = super::stop_when_interrupted(&stop, super::tell) => never,
    };
    if let Some(page) = page {
        page.abort();
    }
    if let Some(worker) = Arc::into_inner(worker) {
        worker.server.close().await;
    }
    ended?;
    let is_interrupted = *stop.borrow();
    Ok(if is_interrupted {
        Exit::Interrupted
    } else {
        Exit::Ok
    })
}

/// Metrics, and the listener that will show them.
#[cfg(feature = "fleet")]
async fn page(
    address: std::net::SocketAddr,
) -> Result<
    (
        std::sync::Arc<crate::studies::Gauges>,
        tokio::net::TcpListener,
    ),
    Failure,
> {
    let wrong = |error: &dyn std::fmt::Display| {
        Failure::new(Exit::Usage, format!("--metrics {address}: {error}"))
    };
    let listener = tokio::net::TcpListener::bind(address).await;
    let listener = listener.map_err(|error| wrong(&error))?;
    let gauges = crate::studies::Gauges::new().map_err(|error| wrong(&error))?;
    Ok((std::sync::Arc::new(gauges), listener))
}
