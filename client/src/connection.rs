//! The server of a command: one that runs, or one started in this process.

use signorini_client::Client;

use crate::arguments::SceneArguments;
#[cfg(not(feature = "embedded"))]
use crate::exit::Exit;
use crate::exit::Failure;

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
            Some(address) => Ok(Self {
                client: Client::connect_with(address, &arguments.access.read()?).await?,
                #[cfg(feature = "embedded")]
                server: None,
            }),
            None => Self::start().await,
        }
    }

    #[cfg(feature = "embedded")]
    async fn start() -> Result<Self, Failure> {
        let server = embedded::Embedded::start().await?;
        let client = Client::connect(server.address()).await?;
        Ok(Self {
            client,
            server: Some(server),
        })
    }

    #[cfg(not(feature = "embedded"))]
    #[allow(clippy::unused_async)]
    async fn start() -> Result<Self, Failure> {
        Err(Failure::new(
            Exit::NoServer,
            "this build has no server of its own: give --server URL",
        ))
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
