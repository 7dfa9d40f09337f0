//! Where the server listens: loopback TCP or a Unix socket of mode 0600, and any other
//! address with transport security and tokens only: without them everybody who reaches the
//! port could use the server.

use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

use tokio::net::{TcpListener, UnixListener, UnixSocket, UnixStream};

use crate::config::Config;

const UNIX_PREFIX: &str = "unix:";
const BACKLOG: u32 = 1024;

/// An address that cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// Neither `host:port` nor `unix:/path`.
    #[error("`{0}` is no address; write `127.0.0.1:50051` or `unix:/path/to/socket`")]
    Address(String),
    /// Reachable from other machines.
    #[error(
        "`{0}` can be reached from other machines, which needs transport security and tokens: \
         `signorini certs init DIR` makes certificates (`tls_certificate` and `tls_key` in the \
         settings), `signorini token add NAME --role ROLE --tokens FILE` a token (`tokens`); or \
         listen on `127.0.0.1:PORT` or `unix:/path/to/socket` and forward it, for example with \
         `ssh -L PORT:127.0.0.1:PORT HOST`"
    )]
    Exposed(String),
    /// The metrics page has no transport security of its own.
    #[error(
        "`{0}` can be reached from other machines, but this page has neither transport security \
         nor tokens; use `127.0.0.1:PORT`, and a proxy or `ssh -L` before it"
    )]
    ExposedPage(String),
    /// Transport security for a Unix socket.
    #[error("`{0}` takes no transport security; leave `tls_certificate` out or listen on a port")]
    SecuredSocket(String),
    /// The path of the Unix socket is taken by something else.
    #[error("`{0}` exists and is not a socket that nobody serves")]
    Occupied(PathBuf),
    /// The address of the metrics page cannot be served.
    #[error(
        "the metrics page: {0}; `--metrics-listen ADDRESS` (`metrics_listen` in the settings) \
         puts it elsewhere, `--metrics-listen \"\"` leaves it out"
    )]
    MetricsPage(#[source] Box<ListenError>),
    /// The system refused.
    #[error("cannot listen on `{address}`: {source}")]
    System {
        /// Address asked for.
        address: String,
        /// Reason of the system.
        source: io::Error,
    },
}

/// The socket on which the service listens.
#[derive(Debug)]
pub(crate) enum Socket {
    Tcp(TcpListener),
    Unix(UnixListener, SocketFile),
}

/// Removes the socket's file when the server ends.
#[derive(Debug)]
pub(crate) struct SocketFile(PathBuf);

impl Drop for SocketFile {
    fn drop(&mut self) {
        // Another process may have removed it already.
        let _gone = std::fs::remove_file(&self.0);
    }
}

/// Bound sockets of one server.
#[derive(Debug)]
pub struct Listener {
    pub(crate) socket: Socket,
    pub(crate) metrics: Option<TcpListener>,
    url: String,
}

impl Listener {
    /// Binds the addresses of `config`.
    ///
    /// # Errors
    /// [`ListenError`], naming the address and what to write instead.
    pub async fn bind(config: &Config) -> Result<Self, ListenError> {
        Self::check(config)?;
        let (socket, url) = match config.listen.strip_prefix(UNIX_PREFIX) {
            Some(path) => bind_unix(Path::new(path)).await?,
            None => {
                let listener = bind(&config.listen, service_address(config)?).await?;
                let address = local_address(&listener, &config.listen)?;
                let scheme = match config.tls_files() {
                    Some(_) => "https",
                    None => "http",
                };
                (Socket::Tcp(listener), format!("{scheme}://{address}"))
            }
        };
        let metrics = match config.metrics_listen.as_str() {
            "" => None,
            address => Some(bind_page(address).await.map_err(of_page)?),
        };
        Ok(Self {
            socket,
            metrics,
            url,
        })
    }

    /// Whether the addresses of `config` may be served at all.
    pub(crate) fn check(config: &Config) -> Result<(), ListenError> {
        if !config.listen.starts_with(UNIX_PREFIX) {
            service_address(config)?;
        } else if config.tls_files().is_some() {
            return Err(ListenError::SecuredSocket(config.listen.clone()));
        }
        if !config.metrics_listen.is_empty() {
            page_address(&config.metrics_listen).map_err(of_page)?;
        }
        Ok(())
    }

    /// What a client connects to: `http://127.0.0.1:PORT`, `https://HOST:PORT` or `unix:/path`.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Address of the metrics page, when there is one.
    pub fn metrics_url(&self) -> Option<String> {
        let address = self.metrics.as_ref()?.local_addr().ok()?;
        Some(format!("http://{address}/metrics"))
    }
}

/// The address of the service, if it may be served.
fn service_address(config: &Config) -> Result<SocketAddr, ListenError> {
    let address = socket_address(&config.listen)?;
    let is_closed = config.tls_files().is_some() && config.token_file().is_some();
    if address.ip().is_loopback() || is_closed {
        Ok(address)
    } else {
        Err(ListenError::Exposed(config.listen.clone()))
    }
}

/// The address of the metrics page, if it may be served.
fn page_address(written: &str) -> Result<SocketAddr, ListenError> {
    let address = socket_address(written)?;
    if address.ip().is_loopback() {
        Ok(address)
    } else {
        Err(ListenError::ExposedPage(written.to_owned()))
    }
}

async fn bind_page(written: &str) -> Result<TcpListener, ListenError> {
    bind(written, page_address(written)?).await
}

async fn bind(written: &str, address: SocketAddr) -> Result<TcpListener, ListenError> {
    let listener = TcpListener::bind(address).await;
    listener.map_err(|source| system(written, source))
}

fn socket_address(address: &str) -> Result<SocketAddr, ListenError> {
    let wrong = || ListenError::Address(address.to_owned());
    let (host, port) = address.rsplit_once(':').ok_or_else(wrong)?;
    let port: u16 = port.parse().map_err(|_| wrong())?;
    let host = match host {
        "localhost" => "127.0.0.1",
        host => host.trim_start_matches('[').trim_end_matches(']'),
    };
    // Names other than localhost are not resolved: an answer may change.
    let host: IpAddr = host.parse().map_err(|_| wrong())?;
    Ok(SocketAddr::new(host, port))
}

fn local_address(listener: &TcpListener, asked: &str) -> Result<SocketAddr, ListenError> {
    listener
        .local_addr()
        .map_err(|source| system(asked, source))
}

async fn bind_unix(path: &Path) -> Result<(Socket, String), ListenError> {
    let address = format!("{UNIX_PREFIX}{}", path.display());
    if path.as_os_str().is_empty() {
        return Err(ListenError::Address(address));
    }
    remove_stale(path).await?;
    let listener = open_private(path).map_err(|source| system(&address, source))?;
    let file = SocketFile(path.to_owned());
    Ok((Socket::Unix(listener, file), address))
}

/// Takes the permissions away before listening, so that nobody can connect in between.
fn open_private(path: &Path) -> io::Result<UnixListener> {
    use std::os::unix::fs::PermissionsExt;
    let socket = UnixSocket::new_stream()?;
    socket.bind(path)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
    socket.listen(BACKLOG)
}

/// Removes a socket that a killed server left behind.
async fn remove_stale(path: &Path) -> Result<(), ListenError> {
    use std::os::unix::fs::FileTypeExt;
    let Ok(found) = std::fs::symlink_metadata(path) else {
        return Ok(());
    };
    let served = !found.file_type().is_socket() || UnixStream::connect(path).await.is_ok();
    if served {
        return Err(ListenError::Occupied(path.to_owned()));
    }
    std::fs::remove_file(path).map_err(|source| system(&path.display().to_string(), source))
}

fn of_page(error: ListenError) -> ListenError {
    ListenError::MetricsPage(Box::new(error))
}

fn system(address: &str, source: io::Error) -> ListenError {
    ListenError::System {
        address: address.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn bind(listen: &str) -> Result<Listener, ListenError> {
        let listen = listen.to_owned();
        Listener::bind(&Config {
            listen,
            ..Config::embedded()
        })
        .await
    }

    #[tokio::test]
    async fn loopback_addresses_get_a_free_port() {
        for address in ["127.0.0.1:0", "localhost:0"] {
            let listener = bind(address).await.unwrap();
            assert!(listener.url().starts_with("http://127.0.0.1:"));
            assert!(!listener.url().ends_with(":0"));
        }
    }

    #[tokio::test]
    async fn other_addresses_are_refused_with_a_way_out() {
        for address in ["0.0.0.0:50051", "[::]:50051", "192.0.2.1:50051"] {
            let message = bind(address).await.unwrap_err().to_string();
            assert!(
                message.contains(address) && message.contains("unix:"),
                "{message}"
            );
        }
        assert!(matches!(
            bind("example.org:1").await,
            Err(ListenError::Address(_))
        ));
        assert!(matches!(
            bind("nonsense").await,
            Err(ListenError::Address(_))
        ));
    }

    #[tokio::test]
    async fn a_metrics_page_that_cannot_be_served_says_how_to_move_it() {
        let taken = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let taken = taken.local_addr().unwrap().to_string();
        for address in [taken.as_str(), "0.0.0.0:0", "nonsense"] {
            let config = Config {
                metrics_listen: address.to_owned(),
                ..Config::embedded()
            };
            let message = Listener::bind(&config).await.unwrap_err().to_string();
            let is_clear = message.starts_with("the metrics page: ")
                && message.contains(address)
                && message.contains("--metrics-listen");
            assert!(is_clear, "{message}");
        }
    }

    #[tokio::test]
    async fn unix_socket_is_private_and_replaces_only_a_dead_one() {
        use std::os::unix::fs::PermissionsExt;
        let path = std::env::temp_dir().join(format!("signorini-{}.sock", std::process::id()));
        let address = format!("unix:{}", path.display());
        let first = bind(&address).await.unwrap();
        let mode = std::fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        assert!(matches!(
            bind(&address).await,
            Err(ListenError::Occupied(_))
        ));
        drop(first);
        assert!(!path.exists());
        // A socket file without a server is what a killed process leaves.
        drop(std::os::unix::net::UnixListener::bind(&path).unwrap());
        drop(bind(&address).await.unwrap());
        std::fs::write(&path, "text").unwrap();
        assert!(matches!(
            bind(&address).await,
            Err(ListenError::Occupied(_))
        ));
        std::fs::remove_file(&path).unwrap();
    }
}
