//! Connections to a server: TCP by URL, with transport security or without, or a Unix socket by
//! path.
//!
//! Flow-control windows are those of the service (1 MiB a stream, 4 MiB a
//! connection), so that fields and meshes are not throttled by HTTP/2's small
//! defaults.

use std::fmt;
use std::future::Future;
use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use signorini_proto::v1::mesh_service_client::MeshServiceClient;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use signorini_proto::v1::surface_service_client::SurfaceServiceClient;
use tonic::body::Body;
use tonic::codegen::http::header::AUTHORIZATION;
use tonic::codegen::http::{HeaderName, HeaderValue, Request, Response};
use tonic::transport::{Channel, ClientTlsConfig, Endpoint, Uri};
use tower::ServiceExt as _;
use tower::util::BoxCloneSyncService;

use crate::library::credentials::Credentials;
use crate::library::error::{ClientError, Stage, Unanswered};

/// Names the session that a call belongs to: what lies between leads by it.
const SESSION: HeaderName = HeaderName::from_static("x-signorini-session");
const STREAM_WINDOW: u32 = 1 << 20;
const CONNECTION_WINDOW: u32 = 4 << 20;
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// A peer that answers no ping within these is gone, however idle the connection.
const PING_INTERVAL: Duration = Duration::from_secs(20);
const PING_TIMEOUT: Duration = Duration::from_secs(10);
/// For calls that the server answers from what it has.
const ANSWER_LIMIT: Duration = Duration::from_secs(60);
/// For calls that plan a scene first.
const PLAN_LIMIT: Duration = Duration::from_secs(600);

/// Where a server listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ServerAddress {
    /// `http://HOST:PORT`; `HOST:PORT` is read as such.
    Http(String),
    /// `https://HOST:PORT`.
    Https(String),
    /// `unix:PATH`.
    Unix(PathBuf),
}

impl FromStr for ServerAddress {
    type Err = ClientError;

    fn from_str(text: &str) -> Result<Self, ClientError> {
        let wrong = || ClientError::Address(text.to_owned());
        if let Some(path) = text.strip_prefix("unix:") {
            let path = path.strip_prefix("//").unwrap_or(path);
            let path = Some(path).filter(|path| !path.is_empty());
            return path.map(|path| Self::Unix(path.into())).ok_or_else(wrong);
        }
        let url = if text.contains("://") {
            text.to_owned()
        } else {
            format!("http://{text}")
        };
        let uri: Uri = url.parse().map_err(|_| wrong())?;
        let is_bare = url != text;
        if uri.scheme_str() == Some("https") && uri.authority().is_some() {
            return Ok(Self::Https(url));
        }
        let is_known = uri.scheme_str() == Some("http") && uri.authority().is_some();
        // A word alone is rather a mistake than a host.
        if is_known && (!is_bare || uri.port().is_some() && uri.path() == "/") {
            return Ok(Self::Http(url));
        }
        Err(wrong())
    }
}

impl fmt::Display for ServerAddress {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Http(url) | Self::Https(url) => out.write_str(url),
            Self::Unix(path) => write!(out, "unix:{}", path.display()),
        }
    }
}

/// A connection to a server. Clones share it. One that breaks is replaced by the
/// next call; a stream goes on by itself (see [`crate::library::solve`]).
#[derive(Clone, Debug)]
pub struct Client {
    channel: Transport,
}

/// A channel whose failures name the address.
pub(crate) type Transport = BoxCloneSyncService<Request<Body>, Response<Body>, Unanswered>;

impl Client {
    /// Connects.
    ///
    /// # Errors
    /// [`ClientError::Unreachable`].
    pub async fn connect(address: &ServerAddress) -> Result<Self, ClientError> {
        Self::connect_with(address, &Credentials::default()).await
    }

    /// Connects, and shows what a server may ask for.
    ///
    /// # Errors
    /// [`ClientError::Unreachable`]; [`ClientError::NoAuthority`] and
    /// [`ClientError::Readable`] where the address and the credentials do not go together.
    pub async fn connect_with(
        address: &ServerAddress,
        credentials: &Credentials,
    ) -> Result<Self, ClientError> {
        let token = credentials.header();
        let channel = match address {
            ServerAddress::Http(url) if token.is_some() && !is_loopback(url) => {
                return Err(ClientError::Readable(url.clone()));
            }
            ServerAddress::Http(url) => connect_tcp(url, None).await,
            ServerAddress::Https(url) => connect_tcp(url, Some(credentials.tls(url)?)).await,
            ServerAddress::Unix(path) => connect_unix(path.clone()).await,
        };
        channel
            .map(|channel| Self {
                channel: named(channel, address.to_string(), token),
            })
            .map_err(|error| ClientError::Unreachable {
                address: address.to_string(),
                message: told(&error, &address.to_string()),
            })
    }

    /// The same connection for calls that belong to one session, by its identifier or name:
    /// a proxy in front of several servers leads them all to the same one. Calls that name a
    /// session say so by themselves; this is for what comes before it, such as its mesh.
    #[must_use]
    pub fn of_session(&self, session: &str) -> Self {
        let id = session.strip_prefix("sessions/").unwrap_or(session);
        // What no header takes is no name of a session either: the server says so.
        let Ok(id) = HeaderValue::from_str(id) else {
            return self.clone();
        };
        let marked = move |mut request: Request<Body>| {
            request.headers_mut().insert(SESSION, id.clone());
            request
        };
        Self {
            channel: Transport::new(self.channel.clone().map_request(marked)),
        }
    }

    pub(crate) fn meshes(&self) -> MeshServiceClient<Transport> {
        MeshServiceClient::new(self.channel.clone())
    }

    pub(crate) fn surfaces(&self) -> SurfaceServiceClient<Transport> {
        SurfaceServiceClient::new(self.channel.clone())
    }

    pub(crate) fn sessions(&self) -> SessionServiceClient<Transport> {
        SessionServiceClient::new(self.channel.clone())
    }

    /// For calls about one session.
    pub(crate) fn sessions_of(&self, session: &str) -> SessionServiceClient<Transport> {
        self.of_session(session).sessions()
    }
}

/// The answer to a call that the server gives from what it has.
///
/// # Errors
/// [`ClientError::Silent`] after a minute; any error of the call.
pub(crate) fn answer<T, E: Into<ClientError>>(
    call: impl Future<Output = Result<T, E>>,
) -> impl Future<Output = Result<T, ClientError>> {
    within(ANSWER_LIMIT, Box::pin(call))
}

/// The answer to a call that plans a scene.
///
/// # Errors
/// [`ClientError::Silent`] after ten minutes; any error of the call.
pub(crate) fn planned<T, E: Into<ClientError>>(
    call: impl Future<Output = Result<T, E>>,
) -> impl Future<Output = Result<T, ClientError>> {
    within(PLAN_LIMIT, Box::pin(call))
}

async fn within<T, E: Into<ClientError>>(
    limit: Duration,
    call: impl Future<Output = Result<T, E>>,
) -> Result<T, ClientError> {
    let answer = tokio::time::timeout(limit, call).await;
    answer
        .map_err(|_| ClientError::Silent(limit))?
        .map_err(Into::into)
}

/// Whatever listens there may accept the connection and yet be no server: that
/// shows only when a call fails without any answer.
fn named(channel: Channel, address: String, token: Option<HeaderValue>) -> Transport {
    let shown = channel.map_request(move |mut request: Request<Body>| {
        if let Some(token) = &token {
            request.headers_mut().insert(AUTHORIZATION, token.clone());
        }
        request
    });
    Transport::new(shown.map_err(move |error| {
        let (message, stage) = (told(&error, &address), stage(&error));
        Unanswered {
            address,
            message,
            stage,
        }
    }))
}

/// A call that is reset by itself was given up by somebody who goes on answering.
fn stage(error: &tonic::transport::Error) -> Stage {
    let is_reset = |error: &h2::Error| error.is_reset() && error.is_remote();
    if of_http2(error).any(is_reset) {
        return Stage::Call;
    }
    Stage::Connection
}

/// What happened, and what to try where somebody answers who is not understood: records of
/// transport security, read as a frame, have a size that none has, as has a page of HTTP/1.
fn told(error: &tonic::transport::Error, address: &str) -> String {
    let said = root_cause(error);
    let is_no_frame = |error: &h2::Error| error.reason() == Some(h2::Reason::FRAME_SIZE_ERROR);
    match address.strip_prefix("http://") {
        Some(host) if of_http2(error).any(is_no_frame) => format!(
            "what it says is no HTTP/2 without TLS ({said}); a server with TLS is at https://{host}"
        ),
        _ => said,
    }
}

/// The errors of HTTP/2 among the causes of another one.
fn of_http2(error: &tonic::transport::Error) -> impl Iterator<Item = &h2::Error> {
    let first: &dyn std::error::Error = error;
    std::iter::successors(Some(first), |error| error.source())
        .filter_map(|error| error.downcast_ref::<h2::Error>())
}

/// Whether nobody but this machine reads what is sent there.
fn is_loopback(url: &str) -> bool {
    let uri: Option<Uri> = url.parse().ok();
    let host = uri.as_ref().and_then(Uri::host).unwrap_or_default();
    let address = host.trim_matches(['[', ']']).parse::<IpAddr>();
    host == "localhost" || address.is_ok_and(|address| address.is_loopback())
}

fn configured(endpoint: Endpoint) -> Endpoint {
    endpoint
        .initial_stream_window_size(STREAM_WINDOW)
        .initial_connection_window_size(CONNECTION_WINDOW)
        .connect_timeout(CONNECT_TIMEOUT)
        .http2_keep_alive_interval(PING_INTERVAL)
        .keep_alive_timeout(PING_TIMEOUT)
        .keep_alive_while_idle(true)
        .tcp_nodelay(true)
}

async fn connect_tcp(
    url: &str,
    tls: Option<ClientTlsConfig>,
) -> Result<Channel, tonic::transport::Error> {
    let mut endpoint = Endpoint::from_shared(url.to_owned())?;
    if let Some(tls) = tls {
        endpoint = endpoint.tls_config(tls)?;
    }
    configured(endpoint).connect().await
}

async fn connect_unix(path: PathBuf) -> Result<Channel, tonic::transport::Error> {
    // The URL only fills the header; the connector decides where to go.
    let endpoint = configured(Endpoint::from_static("http://localhost"));
    let connector = tower::service_fn(move |_: Uri| {
        let path = path.clone();
        async move {
            let stream = tokio::net::UnixStream::connect(path).await?;
            Ok::<_, std::io::Error>(hyper_util::rt::TokioIo::new(stream))
        }
    });
    endpoint.connect_with_connector(connector).await
}

/// The innermost error says what happened; the outer ones say "transport error".
pub(crate) fn root_cause(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(inner) = cause.source() {
        cause = inner;
    }
    cause.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_server_that_does_not_answer_in_time_is_silent() {
        let never = std::future::pending::<Result<(), tonic::Status>>();
        let error = within(Duration::ZERO, never).await.unwrap_err();
        assert!(matches!(error, ClientError::Silent(Duration::ZERO)));
        assert_eq!(error.to_string(), "the server does not answer within 0 s");
    }

    #[test]
    fn addresses_are_urls_or_socket_paths() {
        let unix = |path: &str| ServerAddress::Unix(path.into());
        assert_eq!(
            "unix:/run/s.sock".parse::<ServerAddress>().unwrap(),
            unix("/run/s.sock")
        );
        assert_eq!(
            "unix:///run/s.sock".parse::<ServerAddress>().unwrap(),
            unix("/run/s.sock")
        );
        let http = "http://127.0.0.1:50051".parse::<ServerAddress>().unwrap();
        assert_eq!(http.to_string(), "http://127.0.0.1:50051");
        for bare in ["127.0.0.1:50051", "localhost:1", "[::1]:50051"] {
            let address = bare.parse::<ServerAddress>().unwrap();
            assert_eq!(address.to_string(), format!("http://{bare}"));
        }
        let https = "https://host:1".parse::<ServerAddress>().unwrap();
        assert_eq!(https, ServerAddress::Https("https://host:1".to_owned()));
        for wrong in [
            "",
            "unix:",
            "127.0.0.1",
            "nowhere",
            "host:port",
            "127.0.0.1:50051/path",
            "ftp://host:1",
            "http://",
        ] {
            assert!(wrong.parse::<ServerAddress>().is_err(), "{wrong}");
        }
    }

    #[tokio::test]
    async fn a_server_with_tls_that_is_asked_without_is_named_with_its_address() {
        use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let place = listener.local_addr().unwrap();
        // A record of TLS 1.2 that says "no record of TLS".
        let alert = [0x15, 3, 3, 0, 2, 2, 10];
        tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                // The preface of HTTP/2.
                stream.read_exact(&mut [0; 24]).await.unwrap();
                stream.write_all(&alert).await.unwrap();
            }
        });
        let address = place.to_string().parse::<ServerAddress>().unwrap();
        let error = match Client::connect(&address).await {
            Ok(client) => client.list_sessions().await.err(),
            Err(error) => Some(error),
        };
        let told = error.expect("nobody who is understood").to_string();
        assert!(
            told.contains(&format!("TLS is at https://{place}")),
            "{told}"
        );
    }

    #[tokio::test]
    async fn a_token_does_not_travel_readable_and_https_needs_an_authority() {
        let token = Credentials::default().with_token("signorini_1").unwrap();
        let connect = async |address: &str| {
            let address = address.parse::<ServerAddress>().unwrap();
            Client::connect_with(&address, &token).await.unwrap_err()
        };
        let readable = connect("http://192.0.2.1:50051").await;
        assert!(matches!(readable, ClientError::Readable(_)), "{readable}");
        let unknown = connect("https://192.0.2.1:50051").await;
        assert!(matches!(unknown, ClientError::NoAuthority(_)), "{unknown}");
        for own in ["http://127.0.0.1:1", "http://localhost:1", "http://[::1]:1"] {
            assert!(is_loopback(own), "{own}");
        }
        assert!(!is_loopback("http://localhost.example.org:1"));
    }
}
