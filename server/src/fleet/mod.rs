//! Sessions of several servers: each is held by one of them, and goes on at another when that one
//! is gone.
//!
//! NATS JetStream has a lease for each session (bucket `signorini-leases`, of one time to live) and
//! what the session was asked and did (stream `SIGNORINI-SESSIONS`, a subject each). The lease says
//! who may serve; what keeps a session from having two servers is the stream: every record names
//! the record that it follows, so that one server's records end where another's begin. The local
//! data folder holds a copy of what the stream has. A build without the feature `fleet` has none of
//! it.

#[cfg(feature = "fleet")]
mod held;
#[cfg(feature = "fleet")]
mod lease;
#[cfg(feature = "fleet")]
mod leases;
#[cfg(feature = "fleet")]
mod nats;
#[cfg(not(feature = "fleet"))]
mod none;
#[cfg(feature = "fleet")]
mod stream;
#[cfg(feature = "fleet")]
mod wishes;

#[cfg(feature = "fleet")]
pub use held::{Held, HeldError, held};
#[cfg(feature = "fleet")]
pub(crate) use lease::Lease;
#[cfg(feature = "fleet")]
pub(crate) use nats::Fleet;
#[cfg(not(feature = "fleet"))]
pub(crate) use none::{Fleet, Lease};

/// The addresses of a list with commas: servers of one cluster, any of which leads to the others.
#[cfg(feature = "fleet")]
pub fn nats_addresses(list: &str) -> Vec<&str> {
    list.split(',').map(str::trim).collect()
}

/// What a call wants of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wish {
    /// To know of it where it is.
    Look,
    /// To write to it: a holder that nobody writes to gives it away.
    Drive,
}

/// Another server's wish for a session: its name, and where the answer goes.
pub(crate) type Wished = (String, tokio::sync::oneshot::Sender<bool>);

/// What a server finds of a session that it asks the fleet for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// It is in the data folder now, and this server's.
    Taken,
    /// There is none; its name is this server's.
    #[cfg_attr(not(feature = "fleet"), expect(dead_code, reason = "nobody is asked"))]
    New,
}
