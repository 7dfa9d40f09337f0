//! One accepted connection, as the transport reads and writes it.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpStream, UnixStream};
use tokio::time::Sleep;
use tokio_rustls::server::TlsStream;
use tonic::transport::server::Connected;

use super::Guard;
use crate::door::client_key::Peer;
use crate::door::untaken::{Incoming, Untaken};
use crate::watch::metrics::Away;

/// Time in which a connection has to say that it speaks HTTP/2, and before it to end the
/// handshake of transport security.
pub(super) const HANDSHAKE: Duration = Duration::from_secs(10);

/// Looks at the answers of a connection in the time that one may wait.
const LOOKS: u32 = 4;

/// Bytes of the preface of HTTP/2 and of the frame after it (RFC 9113, 3.4).
const PREFACE_BYTES: usize = 24 + 9;

pub(crate) enum Stream {
    Tcp(TcpStream),
    Unix(UnixStream),
    Tls(Box<TlsStream<TcpStream>>),
}

/// A connection that counts at its door.
pub(crate) struct Connection {
    stream: Stream,
    peer: Peer,
    guard: Guard,
    /// Until the client has begun.
    handshake: Option<Pin<Box<Sleep>>>,
    received: usize,
    untaken: Arc<Untaken>,
    /// When it looks at its answers again.
    look: Pin<Box<Sleep>>,
}

impl Connection {
    pub(super) fn new(stream: Stream, peer: Peer, guard: Guard) -> Self {
        let look = Box::pin(tokio::time::sleep(guard.door().untaken / LOOKS));
        Self {
            stream,
            peer,
            guard,
            handshake: Some(Box::pin(tokio::time::sleep(HANDSHAKE))),
            received: 0,
            untaken: Arc::default(),
            look,
        }
    }

    /// Fails when the client has left an answer untaken for too long.
    fn check_answers(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        let most = self.guard.door().untaken;
        while self.look.as_mut().poll(context).is_ready() {
            if self.untaken.longest() >= most {
                self.guard.door().turn_away(Away::Unread);
                return Err(io::ErrorKind::TimedOut.into());
            }
            let next = tokio::time::Instant::now() + most / LOOKS;
            self.look.as_mut().reset(next);
        }
        Ok(())
    }

    /// Fails when the client has not begun in time.
    fn check_handshake(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        let is_late = self
            .handshake
            .as_mut()
            .is_some_and(|time| time.as_mut().poll(context).is_ready());
        if is_late {
            self.guard.door().turn_away(Away::Silent);
            return Err(io::ErrorKind::TimedOut.into());
        }
        Ok(())
    }
}

impl Connected for Connection {
    type ConnectInfo = Incoming;

    fn connect_info(&self) -> Incoming {
        Incoming {
            peer: self.peer,
            untaken: Arc::clone(&self.untaken),
        }
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = match &mut self.stream {
            Stream::Tcp(stream) => Pin::new(stream).poll_read(context, buffer),
            Stream::Unix(stream) => Pin::new(stream).poll_read(context, buffer),
            Stream::Tls(stream) => Pin::new(stream).poll_read(context, buffer),
        };
        if self.handshake.is_some() {
            if read.is_pending() {
                self.check_handshake(context)?;
            }
            self.received += buffer.filled().len() - before;
            if self.received >= PREFACE_BYTES {
                self.handshake = None;
            }
        }
        if read.is_pending() {
            self.check_answers(context)?;
        }
        ready!(read)?;
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match &mut self.stream {
            Stream::Tcp(stream) => Pin::new(stream).poll_write(context, bytes),
            Stream::Unix(stream) => Pin::new(stream).poll_write(context, bytes),
            Stream::Tls(stream) => Pin::new(stream).poll_write(context, bytes),
        }
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        match &mut self.stream {
            Stream::Tcp(stream) => Pin::new(stream).poll_write_vectored(context, bytes),
            Stream::Unix(stream) => Pin::new(stream).poll_write_vectored(context, bytes),
            Stream::Tls(stream) => Pin::new(stream).poll_write_vectored(context, bytes),
        }
    }

    fn is_write_vectored(&self) -> bool {
        true
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut self.stream {
            Stream::Tcp(stream) => Pin::new(stream).poll_flush(context),
            Stream::Unix(stream) => Pin::new(stream).poll_flush(context),
            Stream::Tls(stream) => Pin::new(stream).poll_flush(context),
        }
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        match &mut self.stream {
            Stream::Tcp(stream) => Pin::new(stream).poll_shutdown(context),
            Stream::Unix(stream) => Pin::new(stream).poll_shutdown(context),
            Stream::Tls(stream) => Pin::new(stream).poll_shutdown(context),
        }
    }
}
