//! The server that cases are solved on: one that runs, or one of this process, started again
//! when it has ended.

use std::time::{Duration, Instant};

use signorini_client::{Client, ServerAddress};
use tokio::sync::Mutex;
use tokio::time::sleep;

use crate::arguments::connection::Connection;
use crate::arguments::{AccessArguments, Slots};
use crate::terminal::exit::Failure;

/// How long a server is waited for that does not answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// Between two questions whether it does; doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// Where cases are solved.
pub(crate) struct Server {
    address: Option<ServerAddress>,
    access: AccessArguments,
    slots: Slots,
    connection: Mutex<Connection>,
}

impl Server {
    /// Connects to a server, or starts one with these slots.
    pub(crate) async fn open(
        address: Option<ServerAddress>,
        access: AccessArguments,
        slots: Slots,
    ) -> Result<Self, Failure> {
        let connection = Connection::with_slots(address.as_ref(), &access, slots).await?;
        Ok(Self {
            address,
            access,
            slots,
            connection: Mutex::new(connection),
        })
    }

    /// A client of it.
    pub(crate) async fn client(&self) -> Client {
        self.connection.lock().await.client.clone()
    }

    /// Waits until it answers after a case has lost it, and starts it again if it was one of
    /// this process.
    pub(crate) async fn revive(&self) -> Result<(), Failure> {
        let (begun, mut pause) = (Instant::now(), FIRST_PAUSE);
        loop {
            match self.try_again().await {
                Err(failure) if begun.elapsed() > PATIENCE => return Err(failure),
                Err(_) => sleep(pause).await,
                Ok(()) => return Ok(()),
            }
            pause = (pause * 2).min(LONGEST_PAUSE);
        }
    }

    async fn try_again(&self) -> Result<(), Failure> {
        let mut connection = self.connection.lock().await;
        if connection.is_over() {
            let (address, slots) = (self.address.as_ref(), self.slots);
            *connection = Connection::with_slots(address, &self.access, slots).await?;
        }
        // Whatever it says to this, it answers.
        connection.client.find_mesh(&"0".repeat(64)).await?;
        Ok(())
    }

    /// Stops it if it belongs to this process.
    pub(crate) async fn close(self) {
        self.connection.into_inner().close().await;
    }
}
