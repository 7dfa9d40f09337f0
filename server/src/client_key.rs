//! Who a request comes from, as far as the transport tells: the basis of
//! fairness between clients.

use std::fmt;
use std::net::SocketAddr;

use tonic::Request;
use tonic::transport::server::{TcpConnectInfo, UdsConnectInfo};

/// One client: a TCP connection, or a process behind a Unix socket.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ClientKey {
    Connection(SocketAddr),
    Process(i32),
    Unknown,
}

impl fmt::Display for ClientKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connection(address) => write!(formatter, "{address}"),
            Self::Process(number) => write!(formatter, "process {number}"),
            Self::Unknown => formatter.write_str("unknown"),
        }
    }
}

impl ClientKey {
    /// The client of a request.
    pub(crate) fn of<T>(request: &Request<T>) -> Self {
        let extensions = request.extensions();
        let address = extensions.get::<TcpConnectInfo>();
        if let Some(address) = address.and_then(TcpConnectInfo::remote_addr) {
            return Self::Connection(address);
        }
        let credentials = extensions.get::<UdsConnectInfo>();
        let process = credentials.and_then(|info| info.peer_cred?.pid());
        process.map_or(Self::Unknown, Self::Process)
    }
}
