//! Who a request comes from, as far as the transport tells: the basis of
//! fairness between clients.
//!
//! A client is a user of this machine: the one at the other end of a Unix socket
//! (`SO_PEERCRED`) or of a connection from an address of this machine (the tables of sockets of
//! Linux). Where neither is known a client is the machine that it comes from. On a server
//! with a token file a client is the name that a call proves, whatever its connection. What one client has is shared out
//! between its strands: processes behind a Unix socket, or TCP connections, and one for all its
//! sessions that nobody is attached to.

use std::fmt;
use std::net::SocketAddr;

use tonic::Request;

use crate::door::client_name::ClientName;

/// Whose share of the server a request uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ClientIdentity {
    /// Proven by a token or a certificate.
    Named(ClientName),
    /// User of this machine, by number.
    User(u32),
    /// Nothing is known but the machine; the port is 0.
    Address(SocketAddr),
    Unknown,
}

/// One of the ways on which a client comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Strand {
    Connection(SocketAddr),
    Process(i32),
    /// Of all sessions of a client that nobody is attached to: together they have one share.
    Unattended,
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
        match self.identity {
            ClientIdentity::Named(name) => write!(formatter, "{name}, ")?,
            ClientIdentity::User(number) => write!(formatter, "user {number}, ")?,
            ClientIdentity::Address(_) | ClientIdentity::Unknown => {}
        }
        match self.strand {
            Strand::Connection(address) => write!(formatter, "{address}"),
            Strand::Process(number) => write!(formatter, "process {number}"),
            Strand::Unattended => formatter.write_str("nobody attached"),
            Strand::Unknown => formatter.write_str("unknown"),
        }
    }
}

/// Who is at the other end of a connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer {
    pub(crate) client: ClientKey,
    /// What its certificate says, which the handshake has checked.
    pub(crate) certificate: Option<ClientName>,
}

impl Peer {
    pub(crate) const UNKNOWN: Self = Self {
        client: ClientKey::UNKNOWN,
        certificate: None,
    };
}

impl ClientKey {
    pub(crate) const UNKNOWN: Self = Self {
        identity: ClientIdentity::Unknown,
        strand: Strand::Unknown,
    };

    /// The client of a request.
    pub(crate) fn of<T>(request: &Request<T>) -> Self {
        let peer = request.extensions().get::<Peer>();
        peer.unwrap_or(&Peer::UNKNOWN).client
    }

    /// The client where nobody of it waits.
    pub(crate) fn unattended(self) -> Self {
        Self {
            strand: Strand::Unattended,
            ..self
        }
    }

    /// The share of one session.
    pub(crate) fn flow(self, session: u64) -> Flow {
        let (client, strand) = (Share::Client(self.identity), Share::Strand(self.strand));
        [client, strand, Share::Session(session)]
    }
}

/// A session's place among the shares.
pub(crate) type Flow = [Share; 3];
