//! What a server does by itself while it serves.

use std::sync::Arc;
use std::time::Duration;

use hyper::StatusCode;
use hyper::http::request::Parts;
use tokio::task::JoinHandle;
use tonic_health::ServingStatus;
use tonic_health::server::HealthReporter;

use super::live::LivePage;
use super::set_health;
use crate::config::Config;
use crate::data::control;
use crate::journal::Journal;
use crate::registry::Registry;
use crate::session::Services;
use crate::watch::metrics::Metrics;
use crate::watch::page::{self, Answer, Answers};

const UPKEEP: Duration = Duration::from_secs(5);
/// How often the data folder is looked for.
const LOOK: Duration = Duration::from_secs(3);
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
            metrics.tell_lines_left_out();
            registry.expire_asleep().await;
        }
    });
    let page = listener.map(|listener| tokio::spawn(page::serve(listener, page)));
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

/// Looks from time to time whether the data folder is still there and can be written; where not
/// the server says so to probes.
pub(super) async fn watch_folder(services: Arc<Services>, health: HealthReporter) {
    let (Some(journal), Some(presence)) = (services.journal.clone(), services.presence.clone())
    else {
        return;
    };
    let mut ticks = tokio::time::interval(LOOK);
    let mut was_ready = true;
    loop {
        ticks.tick().await;
        let (journal, presence) = (Arc::clone(&journal), Arc::clone(&presence));
        let looked = tokio::task::spawn_blocking(move || {
            journal.disk().look();
            presence.look()
        });
        let Ok(change) = looked.await else {
            continue;
        };
        if let Some(is_gone) = change {
            tell_of_folder(&services, is_gone);
        }
        let is_ready = services.check_ready().is_ok();
        if is_ready != was_ready {
            let status = match is_ready {
                true => ServingStatus::Serving,
                false => ServingStatus::NotServing,
            };
            set_health(&health, status).await;
        }
        was_ready = is_ready;
    }
}

fn tell_of_folder(services: &Services, is_gone: bool) {
    services.metrics.data_folder_gone(is_gone);
    let folder = services.config.data.as_str();
    if is_gone {
        tracing::error!(
            folder,
            "the data folder was deleted or moved: nothing is taken"
        );
    } else {
        tracing::warn!(folder, "the data folder is back");
    }
}

/// The page of a server.
#[derive(Clone)]
pub(crate) struct Page {
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) registry: Arc<Registry>,
    /// Where the service itself listens.
    pub(crate) service: Arc<str>,
    /// What runs just now.
    pub(crate) live: Arc<LivePage>,
}

impl Answers for Page {
    async fn answer(&self, request: &Parts) -> Answer {
        let (status, text) = match request.uri.path() {
            "/live" => return self.live.page(),
            "/live.json" => return self.live.data(&request.headers).await,
            "/metrics" => (StatusCode::OK, self.metrics.render()),
            "/healthz" => self.health(),
            "/livez" => (StatusCode::OK, "ok\n".to_owned()),
            "/" => (StatusCode::OK, self.help()),
            _ => (StatusCode::NOT_FOUND, self.help()),
        };
        Answer::plain(status, text)
    }
}

impl Page {
    fn health(&self) -> (StatusCode, String) {
        match self.registry.check_ready() {
            Ok(()) => (StatusCode::OK, "ok\n".to_owned()),
            Err(fault) => (StatusCode::SERVICE_UNAVAILABLE, format!("{fault}\n")),
        }
    }

    fn help(&self) -> String {
        format!(
            "Signorini {}\n\n\
             /live     sessions, what runs, memory, for a browser\n\
             /metrics  for Prometheus\n\
             /healthz  200 while the server takes work, 503 while it shuts down or nothing can be written\n\
             /livez    200 while it answers at all\n\n\
             The service itself speaks gRPC at {}.\n",
            env!("CARGO_PKG_VERSION"),
            self.service
        )
    }
}
