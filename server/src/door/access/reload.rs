//! Takes up changed tokens and certificates: at a hangup, or soon after a file changes.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::Interval;

use super::files::Stamp;
use super::{Access, TokenFile};
use crate::process::hangup::Hangups;
use crate::watch::metrics::Metrics;

/// How often the files are looked at.
const LOOK: Duration = Duration::from_secs(1);

/// Rereads the files until it is dropped. A server that asks nobody has none.
pub(crate) async fn watch(access: Access, mut hangups: Hangups, metrics: Arc<Metrics>) {
    if access.tokens.is_none() && access.certificates.is_none() {
        return;
    }
    let mut ticks = tokio::time::interval(LOOK);
    // Nothing: the first look reads what changed since the start.
    let mut seen = <[Vec<Stamp>; 2]>::default();
    loop {
        let is_asked = next(&mut hangups, &mut ticks).await;
        let (access, before) = (access.clone(), std::mem::take(&mut seen));
        let metrics = Arc::clone(&metrics);
        // A few small files, but whose disk may hang.
        let looked = tokio::task::spawn_blocking(move || {
            let stamps = access.stamps();
            if is_asked || stamps != before {
                access.read_again();
                access.tell_ends(&metrics);
            }
            stamps
        });
        match looked.await {
            Ok(stamps) => seen = stamps,
            Err(error) => tracing::error!(said = error.to_string(), "reading access files failed"),
        }
    }
}

/// Waits for the next look; whether a hangup asks for it.
async fn next(hangups: &mut Hangups, ticks: &mut Interval) -> bool {
    tokio::select! {
        () = hangups.next() => true,
        _ = ticks.tick() => false,
    }
}

impl Access {
    fn stamps(&self) -> [Vec<Stamp>; 2] {
        let tokens = self.tokens.iter().map(|tokens| Stamp::of(&tokens.file));
        let certificates = self.certificates.iter().flat_map(|all| all.paths());
        [tokens.collect(), certificates.map(Stamp::of).collect()]
    }

    /// What cannot be used leaves what was there.
    fn read_again(&self) {
        if let Some(tokens) = &self.tokens {
            match TokenFile::read(&tokens.file) {
                Ok(fresh) => {
                    let entries = fresh.entries().len();
                    tokens.sender.send_replace(Arc::new(fresh));
                    tracing::info!(entries, "token file read");
                }
                Err(why) => stay(&why),
            }
        }
        if let Some(certificates) = &self.certificates {
            match certificates.read_again() {
                Ok(()) => tracing::info!("certificates read"),
                Err(why) => stay(&why),
            }
        }
    }
}

fn stay(why: &super::AccessError) {
    tracing::error!(why = why.to_string(), "what was read before stays in force");
}
