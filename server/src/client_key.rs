//! Who a request comes from, as far as the transport tells: the basis of
//! fairness between clients.
//!
//! A client is a user of this machine: the one at the other end of a Unix socket
//! (`SO_PEERCRED`) or of a loopback connection (the table of sockets of Linux). Where
//! neither is known a client is a connection. What one client has is shared out
//! between its strands: processes behind a Unix socket, or TCP connections.

use std::fmt;
use std::net::SocketAddr;

use tonic::Request;

/// Whose share of the server a request uses. A name that a token proves will be a
/// further kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ClientIdentity {
    /// User of this machine, by number.
    User(u32),
    /// Nothing is known but the address.
    Address(SocketAddr),
    Unknown,
}

/// One of the ways on which a client comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Strand {
    Connection(SocketAddr),
    Process(i32),
    Unknown,
}

/// A client on one of its ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ClientKey {
    pub(crate) identity: ClientIdentity,
    pub(crate) strand: Strand,
}

/// What the solver threads are shared by: clients, their strands, their sessions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Share {
    Client(ClientIdentity),
    Strand(Strand),
    Session(u64),
}

impl fmt::Display for ClientKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let ClientIdentity::User(number) = self.identity {
            write!(formatter, "user {number}, ")?;
        }
        match self.strand {
            Strand::Connection(address) => write!(formatter, "{address}"),
            Strand::Process(number) => write!(formatter, "process {number}"),
            Strand::Unknown => formatter.write_str("unknown"),
        }
    }
}

/// Who is at the other end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer {
    pub(crate) client: ClientKey,
}

impl ClientKey {
    pub(crate) const UNKNOWN: Self = Self {
        identity: ClientIdentity::Unknown,
        strand: Strand::Unknown,
    };

    /// The client of a request.
    pub(crate) fn of<T>(request: &Request<T>) -> Self {
        let peer = request.extensions().get::<Peer>();
        peer.map_or(Self::UNKNOWN, |peer| peer.client)
    }

    /// The shares of all its sessions.
    pub(crate) fn path(self) -> [Share; 2] {
        [Share::Client(self.identity), Share::Strand(self.strand)]
    }

    /// The share of one session.
    pub(crate) fn flow(self, session: u64) -> Flow {
        let [client, strand] = self.path();
        [client, strand, Share::Session(session)]
    }
}

/// A session's place among the shares.
pub(crate) type Flow = [Share; 3];
