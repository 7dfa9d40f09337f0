//! What a server does by itself while it serves.

use std::sync::Arc;
use std::time::Duration;

use tokio::task::JoinHandle;

use crate::config::Config;
use crate::control;
use crate::journal::Journal;
use crate::metrics_page::{self, Page};
use crate::registry::Registry;
use crate::session::Services;

const UPKEEP: Duration = Duration::from_secs(5);
/// How often the data folder is looked through for results that shall go.
const TRIM: Duration = Duration::from_secs(60);

/// Starts what goes on beside the service until it is aborted: the metrics page, upkeep, backups.
pub(crate) fn start(
    page: Page,
    services: &Arc<Services>,
    registry: &Arc<Registry>,
    listener: Option<tokio::net::TcpListener>,
) -> Vec<JoinHandle<()>> {
    let (journal, config) = (services.journal.clone(), services.config.clone());
    let (metrics, registry) = (Arc::clone(&page.metrics), Arc::clone(registry));
    let upkeep = tokio::spawn(async move {
        let mut ticks = tokio::time::interval(UPKEEP);
        loop {
            ticks.tick().await;
            metrics.upkeep();
            registry.expire_asleep().await;
        }
    });
    let page = listener.map(|listener| tokio::spawn(metrics_page::serve(listener, page)));
    let trim = journal
        .clone()
        .map(|journal| tokio::spawn(trim(journal, config)));
    let control = journal.map(|journal| tokio::spawn(control::serve(journal)));
    std::iter::once(upkeep)
        .chain(page)
        .chain(control)
        .chain(trim)
        .collect()
}

/// Drops from time to time what the data folder shall not keep.
async fn trim(journal: Arc<Journal>, config: Config) {
    let mut ticks = tokio::time::interval(TRIM);
    loop {
        ticks.tick().await;
        let Some(limit) = config.data_limit() else {
            continue;
        };
        let journal = Arc::clone(&journal);
        match tokio::task::spawn_blocking(move || journal.trim(limit)).await {
            Ok(Ok(0)) => {}
            Ok(Ok(sessions)) => tracing::info!(sessions, "old results dropped from disk"),
            Ok(Err(why)) => tracing::error!(why = why.to_string(), "old results stay on disk"),
            Err(why) => tracing::error!(why = why.to_string(), "old results stay on disk"),
        }
    }
}
