//! The sessions of a whole fleet, for `signorini fleet status`.

use std::time::SystemTime;

use async_nats::jetstream;

use super::leases::{BUCKET, Holder};
use super::nats_addresses;

/// A session and the server that holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Held {
    /// `sessions/{id}`.
    pub session: String,
    /// Its holder, as that calls itself.
    pub server: String,
    /// Grows with every holder.
    pub epoch: u64,
    /// Seconds since the last renewal.
    pub renewed: u64,
}

/// Why nothing is known of a fleet.
#[derive(Debug, thiserror::Error)]
#[error("{url}: {why}")]
pub struct HeldError {
    /// Of NATS.
    pub url: String,
    /// What it said.
    pub why: String,
}

/// Every session that some server holds, in order of the names.
///
/// # Errors
/// [`HeldError`] where NATS does not answer or knows no fleet.
pub async fn held(url: &str) -> Result<Vec<Held>, HeldError> {
    let wrong = |error: async_nats::Error| HeldError {
        url: url.to_owned(),
        why: error.to_string(),
    };
    read(url).await.map_err(wrong)
}

async fn read(url: &str) -> Result<Vec<Held>, async_nats::Error> {
    use tokio_stream::StreamExt as _;
    let client = async_nats::connect(nats_addresses(url).as_slice()).await?;
    let store = jetstream::new(client).get_key_value(BUCKET).await?;
    let (mut keys, mut found) = (store.keys().await?, Vec::new());
    while let Some(id) = keys.next().await {
        let id = id?;
        // One that ended meanwhile is left out.
        let Some(entry) = store.entry(&id).await? else {
            continue;
        };
        let Some(holder) = Holder::read(&entry.value) else {
            continue;
        };
        let since = SystemTime::now().duration_since(entry.created.into());
        found.push(Held {
            session: format!("sessions/{id}"),
            server: holder.server,
            epoch: match holder.epoch {
                0 => entry.revision,
                epoch => epoch,
            },
            renewed: since.map_or(0, |since| since.as_secs()),
        });
    }
    found.sort_unstable_by(|one, other| one.session.cmp(&other.session));
    Ok(found)
}
