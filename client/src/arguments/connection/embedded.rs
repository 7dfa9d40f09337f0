//! The server of this process: the same code on a free loopback port.

use signorini_client::ServerAddress;
use signorini_server::{Config, Listener, serve};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

use crate::arguments::Slots;
use crate::arguments::compared::compared;
use crate::terminal::exit::{Exit, Failure};

/// A running server that ends with the command.
pub(super) struct Embedded {
    address: ServerAddress,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Embedded {
    /// Starts the server; with slots of its own none is kept for short scenes.
    pub(super) async fn start(slots: Option<Slots>) -> Result<Self, Failure> {
        let mut config = Config {
            compared: compared(),
            ..Config::embedded()
        };
        if let Some(slots) = slots {
            config.solver_slots = slots.count;
            config.short_slots = 0;
            config.threads_per_slot = slots.threads;
        }
        let listener = Listener::bind(&config)
            .await
            .map_err(|error| Failure::new(Exit::NoServer, error.to_string()))?;
        let address = listener.url().parse()?;
        let (stop, stopped) = oneshot::channel();
        let task = tokio::spawn(async move {
            let shutdown = async {
                // A sender that is gone means the same.
                let _stopped = stopped.await;
            };
            // A server that fails shows as a broken connection to its client.
            let _outcome = serve(listener, config, shutdown).await;
        });
        Ok(Self {
            address,
            stop,
            task,
        })
    }

    /// Whether it has ended.
    pub(super) fn is_over(&self) -> bool {
        self.task.is_finished()
    }

    pub(super) fn address(&self) -> &ServerAddress {
        &self.address
    }

    /// Lets the server end and waits for it.
    pub(super) async fn stop(self) {
        let _ended = self.stop.send(());
        let _ended = self.task.await;
    }
}
