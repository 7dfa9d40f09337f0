//! The server of a command: one that runs, or one started in this process.

use signorini_client::{Client, ServerAddress};

use crate::arguments::{AccessArguments, SceneArguments, Slots};
#[cfg(not(feature = "embedded"))]
use crate::terminal::exit::Exit;
use crate::terminal::exit::Failure;

/// A client, and the server behind it when it belongs to this process.
pub(crate) struct Connection {
    pub(crate) client: Client,
    #[cfg(feature = "embedded")]
    server: Option<embedded::Embedded>,
}

impl Connection {
    /// Connects to a server, or starts one.
    pub(crate) async fn open(arguments: &SceneArguments) -> Result<Self, Failure> {
        match &arguments.server {
            Some(address) => Self::to(address, &arguments.access).await,
            None => Self::start(None).await,
        }
    }

    /// Connects to a server, or starts one with these slots.
    pub(crate) async fn with_slots(
        address: Option<&ServerAddress>,
        access: &AccessArguments,
        slots: Slots,
    ) -> Result<Self, Failure> {
        match address {
            Some(address) => Self::to(address, access).await,
            None => Self::start(Some(slots)).await,
        }
    }

    async fn to(address: &ServerAddress, access: &AccessArguments) -> Result<Self, Failure> {
        Ok(Self {
            client: Client::connect_with(address, &access.read()?).await?,
            #[cfg(feature = "embedded")]
            server: None,
        })
    }

    #[cfg(feature = "embedded")]
    async fn start(slots: Option<Slots>) -> Result<Self, Failure> {
        let server = embedded::Embedded::start(slots).await?;
        let client = Client::connect(server.address()).await?;
        Ok(Self {
            client,
            server: Some(server),
        })
    }

    #[cfg(not(feature = "embedded"))]
    #[allow(clippy::unused_async)]
    async fn start(_slots: Option<Slots>) -> Result<Self, Failure> {
        Err(Failure::new(
            Exit::NoServer,
            "this build has no server of its own: give --server URL",
        ))
    }

    /// Whether it had a server of this process that has ended.
    pub(crate) fn is_over(&self) -> bool {
        #[cfg(feature = "embedded")]
        let is_over = self
            .server
            .as_ref()
            .is_some_and(embedded::Embedded::is_over);
        #[cfg(not(feature = "embedded"))]
        let is_over = false;
        is_over
    }

    /// Stops the server if it belongs to this process.
    #[cfg_attr(not(feature = "embedded"), allow(clippy::unused_async))]
    pub(crate) async fn close(self) {
        drop(self.client);
        #[cfg(feature = "embedded")]
        if let Some(server) = self.server {
            server.stop().await;
        }
    }
}

#[cfg(feature = "embedded")]
mod embedded;
