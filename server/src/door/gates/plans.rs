//! Plans at one time: as many as there are cores, half of them of one client.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::door::client_key::ClientIdentity;

/// Who plans.
pub(crate) struct Plans {
    all: Arc<Semaphore>,
    own: Mutex<HashMap<ClientIdentity, Arc<Semaphore>>>,
    /// Of one client.
    most: usize,
}

impl Plans {
    pub(super) fn new() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Self::of(cores.max(2))
    }

    fn of(all: usize) -> Self {
        Self {
            all: Arc::new(Semaphore::new(all)),
            own: Mutex::default(),
            most: all / 2,
        }
    }

    /// Waits for the turn of `client`; it lasts until the permits are dropped.
    pub(crate) async fn turn(&self, client: ClientIdentity) -> [Option<OwnedSemaphorePermit>; 2] {
        let own = self.own(client).acquire_owned().await;
        let all = Arc::clone(&self.all).acquire_owned().await;
        // Neither is ever closed.
        [own.ok(), all.ok()]
    }

    fn own(&self, client: ClientIdentity) -> Arc<Semaphore> {
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        own.retain(|_, one| Arc::strong_count(one) > 1);
        let one = own
            .entry(client)
            .or_insert_with(|| Arc::new(Semaphore::new(self.most)));
        Arc::clone(one)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[tokio::test]
    async fn one_client_plans_once_at_a_time_and_leaves_room_for_others() {
        let plans = Plans::of(2);
        let [greedy, other] = [1, 2].map(ClientIdentity::User);
        let first = plans.turn(greedy).await;
        let wait = Duration::from_millis(20);
        assert!(
            tokio::time::timeout(wait, plans.turn(greedy))
                .await
                .is_err()
        );
        assert!(tokio::time::timeout(wait, plans.turn(other)).await.is_ok());
        drop(first);
        assert!(tokio::time::timeout(wait, plans.turn(greedy)).await.is_ok());
    }
}
