//! What uploads take out of the byte budget, in all and of one client.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;
use crate::watch::metrics::Metrics;

/// Part of the budget that several uploads of one client may have together.
const PART: u64 = 2;

#[derive(Default)]
struct Open {
    bytes: HashMap<ClientIdentity, u64>,
    count: usize,
}

/// The uploads under way.
pub(crate) struct Uploads {
    open: Mutex<Open>,
    most: u64,
    metrics: Arc<Metrics>,
}

impl Uploads {
    pub(super) fn new(budget: u64, metrics: &Arc<Metrics>) -> Arc<Self> {
        Arc::new(Self {
            open: Mutex::default(),
            most: budget / PART,
            metrics: Arc::clone(metrics),
        })
    }

    /// Counts an upload as long as the share lives.
    pub(crate) fn begin(self: &Arc<Self>, client: ClientIdentity) -> UploadShare {
        let mut open = self.lock();
        open.count += 1;
        self.metrics.uploads(open.count);
        UploadShare {
            uploads: Arc::clone(self),
            client,
            bytes: 0,
        }
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One upload's bytes in its client's share.
pub(crate) struct UploadShare {
    uploads: Arc<Uploads>,
    client: ClientIdentity,
    bytes: u64,
}

impl UploadShare {
    /// Takes `bytes` in all.
    ///
    /// # Errors
    /// `MemoryBudget` with the share of one client as the budget, when that has others.
    pub(crate) fn grow(&mut self, bytes: u64) -> Result<(), Fault> {
        let mut open = self.uploads.lock();
        let own = open.bytes.entry(self.client).or_default();
        let others = own.saturating_sub(self.bytes);
        // A single one may have what there is: it takes only what has come.
        if others > 0 && others.saturating_add(bytes) > self.uploads.most {
            return Err(Fault::MemoryBudget {
                predicted: bytes,
                held: others,
                budget: self.uploads.most,
            });
        }
        *own = others + bytes;
        self.bytes = bytes;
        Ok(())
    }
}

impl Drop for UploadShare {
    fn drop(&mut self) {
        let mut open = self.uploads.lock();
        if let Some(own) = open.bytes.get_mut(&self.client) {
            *own = own.saturating_sub(self.bytes);
            if *own == 0 {
                open.bytes.remove(&self.client);
            }
        }
        open.count -= 1;
        self.uploads.metrics.uploads(open.count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_client_uploads_into_half_of_the_budget_and_another_into_the_rest() {
        let uploads = Uploads::new(100, &Metrics::new().unwrap());
        let [greedy, other] = [1, 2].map(ClientIdentity::User);
        let (mut first, mut second) = (uploads.begin(greedy), uploads.begin(greedy));
        first.grow(20).unwrap();
        first.grow(40).unwrap();
        assert!(second.grow(11).is_err());
        second.grow(10).unwrap();
        uploads.begin(other).grow(50).unwrap();
        drop(first);
        second.grow(50).unwrap();
        drop(second);
        assert!(uploads.lock().bytes.is_empty());
    }
}
