//! The door for connections: accepts them, counts them, and turns away what is too much.
//!
//! There are at most so many in all and of one client, so that no user of the machine
//! takes all descriptors. A connection that has not said in time that it speaks HTTP/2
//! is closed, and one whose handshake of transport security fails or takes too long. Where the process has no descriptor left the door waits a moment and
//! says so, instead of asking again at once.

mod connection;
mod peer;

use std::collections::HashMap;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream, UnixListener};
use tokio::sync::mpsc;
use tokio_rustls::TlsAcceptor;
use tokio_stream::wrappers::ReceiverStream;

use crate::config::Config;
use crate::door::access::{Certificates, common_name};
use crate::door::client_key::{ClientIdentity, ClientKey, Peer};
use crate::process::limits;
use crate::watch::lines::Whose;
use crate::watch::metrics::{Away, Metrics};
pub(crate) use connection::Connection;

/// Pause after a failure to accept.
const PAUSE: Duration = Duration::from_millis(100);

/// Descriptors that are no connections: files, the runtime, the metrics page.
const OWN_DESCRIPTORS: u64 = 32;

/// The open connections by client.
pub(crate) struct Door {
    open: Mutex<HashMap<ClientIdentity, usize>>,
    most: usize,
    most_of_client: usize,
    /// Time that a connection may leave an answer untaken.
    untaken: Duration,
    /// Whether it has been told that a limit turns connections away.
    told: [AtomicBool; 2],
    metrics: Arc<Metrics>,
}

impl Door {
    pub(crate) fn new(config: &Config, metrics: &Arc<Metrics>) -> Arc<Self> {
        let most = most(config.maximum_connections, limits::descriptors());
        Arc::new(Self {
            open: Mutex::default(),
            most,
            // Never all: somebody else has to be able to come in.
            most_of_client: config.maximum_client_connections.min(most.div_ceil(2)),
            untaken: 2 * config.unread_time(),
            told: Default::default(),
            metrics: Arc::clone(metrics),
        })
    }

    /// Counts one more connection of a client as long as the guard lives.
    fn enter(self: &Arc<Self>, client: ClientIdentity) -> Result<Guard, Away> {
        let mut open = self.lock();
        let all: usize = open.values().sum();
        if all >= self.most {
            return Err(Away::All);
        }
        let own = open.entry(client).or_default();
        if *own >= self.most_of_client {
            return Err(Away::Client);
        }
        *own += 1;
        self.metrics.connections(all + 1);
        let door = Arc::clone(self);
        Ok(Guard { door, client })
    }

    /// Whether the log may take one more line about a connection that said no name.
    fn may_tell(&self) -> bool {
        self.metrics.may_tell_of(Whose::Strangers)
    }

    pub(crate) fn turn_away(&self, why: Away) {
        self.metrics.turned_away(why.name());
        tracing::debug!(why = why.name(), "connection turned away");
        let [all, client] = &self.told;
        let (told, limit, key) = match why {
            Away::All => (all, self.most, "maximum_connections"),
            Away::Client => (client, self.most_of_client, "maximum_client_connections"),
            Away::Silent | Away::Descriptors | Away::Handshake | Away::Unread => return,
        };
        // Once: whoever is turned away may come again at once, the metric counts them.
        if !told.swap(true, Ordering::Relaxed) {
            tracing::warn!(limit, key, "connections are turned away");
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<ClientIdentity, usize>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Connections that fit beside what the process needs for itself.
fn most(asked: usize, descriptors: Option<u64>) -> usize {
    let Some(descriptors) = descriptors else {
        return asked;
    };
    let left = descriptors
        .saturating_sub(OWN_DESCRIPTORS)
        .max(descriptors / 4);
    asked.min(usize::try_from(left).unwrap_or(usize::MAX))
}

/// One open connection.
pub(crate) struct Guard {
    door: Arc<Door>,
    client: ClientIdentity,
}

impl Guard {
    pub(crate) fn door(&self) -> &Door {
        &self.door
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        let mut open = self.door.lock();
        if let Some(own) = open.get_mut(&self.client) {
            *own -= 1;
            if *own == 0 {
                open.remove(&self.client);
            }
        }
        self.door.metrics.connections(open.values().sum());
    }
}

/// Where connections come from.
pub(crate) enum Source {
    Tcp(TcpListener),
    Tls(TcpListener, Arc<Certificates>),
    Unix(UnixListener),
}

/// Accepts connections until nobody takes them any more.
pub(crate) fn incoming(
    source: Source,
    door: Arc<Door>,
) -> ReceiverStream<Result<Connection, io::Error>> {
    let (sender, connections) = mpsc::channel(64);
    tokio::spawn(async move {
        tokio::select! {
            () = accept_all(&door, &sender, &source) => {}
            () = sender.closed() => {}
        }
    });
    ReceiverStream::new(connections)
}

type Accepted = (Begun, ClientKey);

/// A connection that is accepted and says nothing yet.
enum Begun {
    Open(connection::Stream),
    Tls(TcpStream, TlsAcceptor),
}

impl Source {
    async fn accept(&self) -> io::Result<Accepted> {
        match self {
            Self::Tcp(listener) => {
                let (stream, client) = accept_tcp(listener).await?;
                Ok((Begun::Open(connection::Stream::Tcp(stream)), client))
            }
            Self::Tls(listener, certificates) => {
                let (stream, client) = accept_tcp(listener).await?;
                Ok((Begun::Tls(stream, certificates.current().into()), client))
            }
            Self::Unix(listener) => accept_unix(listener).await,
        }
    }
}

async fn accept_tcp(listener: &TcpListener) -> io::Result<(TcpStream, ClientKey)> {
    let (stream, address) = listener.accept().await?;
    stream.set_nodelay(true)?;
    let client = match stream.local_addr() {
        // A look into a file of the kernel, which a runtime's thread shall not wait for.
        Ok(local) => tokio::task::spawn_blocking(move || peer::of_tcp(address, local)).await,
        Err(_) => return Ok((stream, peer::by_address(address))),
    };
    let client = client.unwrap_or_else(|_| peer::by_address(address));
    Ok((stream, client))
}

async fn accept_unix(listener: &UnixListener) -> io::Result<Accepted> {
    let (stream, _) = listener.accept().await?;
    let client = peer::of_unix(&stream);
    Ok((Begun::Open(connection::Stream::Unix(stream)), client))
}

async fn accept_all(
    door: &Arc<Door>,
    sender: &mpsc::Sender<Result<Connection, io::Error>>,
    source: &Source,
) {
    let mut is_out = false;
    loop {
        match source.accept().await {
            Ok((stream, client)) => {
                is_out = false;
                match door.enter(client.identity) {
                    Ok(guard) => begin(stream, client, guard, sender).await,
                    // Dropped, which closes it.
                    Err(why) => door.turn_away(why),
                }
            }
            Err(error) if is_out_of_descriptors(&error) => {
                door.turn_away(Away::Descriptors);
                if !is_out {
                    tracing::warn!(%error, "no descriptor for a new connection: `ulimit -n`");
                }
                is_out = true;
                tokio::time::sleep(PAUSE).await;
            }
            // Of one connection, which has gone.
            Err(error) => tracing::debug!(%error, "a connection was not accepted"),
        }
    }
}

/// Hands a connection on; one that begins with a handshake when that is done.
async fn begin(
    begun: Begun,
    client: ClientKey,
    guard: Guard,
    sender: &mpsc::Sender<Result<Connection, io::Error>>,
) {
    let certificate = None;
    match begun {
        Begun::Open(stream) => {
            let peer = Peer {
                client,
                certificate,
            };
            let connection = Connection::new(stream, peer, guard);
            // Nobody takes it when the server stops.
            let _stopped = sender.send(Ok(connection)).await;
        }
        Begun::Tls(stream, acceptor) => {
            let sender = sender.clone();
            tokio::spawn(async move {
                if let Some(connection) = shake_hands(stream, acceptor, client, guard).await {
                    let _stopped = sender.send(Ok(connection)).await;
                }
            });
        }
    }
}

async fn shake_hands(
    stream: TcpStream,
    acceptor: TlsAcceptor,
    client: ClientKey,
    guard: Guard,
) -> Option<Connection> {
    let Ok(done) = tokio::time::timeout(connection::HANDSHAKE, acceptor.accept(stream)).await
    else {
        guard.door().turn_away(Away::Silent);
        return None;
    };
    match done {
        Ok(stream) => {
            let shown = stream.get_ref().1.peer_certificates();
            let certificate = shown.and_then(|all| common_name(all.first()?));
            let peer = Peer {
                client,
                certificate,
            };
            let stream = connection::Stream::Tls(Box::new(stream));
            Some(Connection::new(stream, peer, guard))
        }
        Err(error) => {
            guard.door().turn_away(Away::Handshake);
            if guard.door().may_tell() {
                tracing::info!(%client, %error, "handshake failed");
            }
            None
        }
    }
}

fn is_out_of_descriptors(error: &io::Error) -> bool {
    const ENFILE: i32 = 23;
    const EMFILE: i32 = 24;
    const ENOBUFS: i32 = 105;
    const ENOMEM: i32 = 12;
    let code = error.raw_os_error();
    code.is_some_and(|code| [ENFILE, EMFILE, ENOBUFS, ENOMEM].contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_leave_descriptors_for_the_server_itself() {
        assert_eq!(most(1024, None), 1024);
        assert_eq!(most(1024, Some(1 << 20)), 1024);
        assert_eq!(most(1024, Some(256)), 224);
        assert_eq!(most(1024, Some(40)), 10);
    }

    #[test]
    fn one_client_never_has_all_and_gives_back_what_it_had() {
        let config = Config {
            maximum_connections: 4,
            maximum_client_connections: 100,
            ..Config::embedded()
        };
        let door = Door::new(&config, &Metrics::new().unwrap());
        let [greedy, other] = [1, 2].map(ClientIdentity::User);
        let held: Vec<_> = (0..2).map(|_| door.enter(greedy).ok().unwrap()).collect();
        assert_eq!(door.enter(greedy).err(), Some(Away::Client));
        let others: Vec<_> = (0..2).map(|_| door.enter(other).ok().unwrap()).collect();
        assert_eq!(door.enter(ClientIdentity::User(3)).err(), Some(Away::All));
        drop(held);
        assert!(door.enter(greedy).is_ok());
        drop(others);
        assert!(door.lock().is_empty());
    }
}
