//! The task behind a stream: carries orders out and answers in, over as many
//! connections as it takes.
//!
//! It never waits for one side while the other has something to do: orders are
//! taken at any time, and answers are read only when the ones before them are
//! taken, so that what is unread stays with the server.

use std::future::Future;
use std::pin::pin;
use std::time::{Duration, Instant};

use signorini_proto::v1;
use signorini_proto::v1::solve_request::Message as Request;
use signorini_proto::v1::solve_response::Message as Response;
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};

use super::backoff::Backoff;
use super::desk::{Desk, Turn};
use super::events::{Collector, Event};
use super::incoming::{Incoming, Stop};
use super::journal::Journal;
use super::source::Source;
use crate::error::ClientError;

/// One connection.
#[derive(Debug)]
pub(super) struct Link {
    /// `None` when it is half-closed or only reads.
    pub(super) requests: Option<mpsc::Sender<v1::SolveRequest>>,
    pub(super) incoming: Incoming,
    pub(super) collector: Collector,
}

/// How a stream ended.
enum End {
    Done,
    /// Nobody takes events any more.
    Left,
    Fault(ClientError),
}

/// How a connection ended.
enum Ending {
    Broken(ClientError),
    /// And the stream with it.
    Over(End),
}

/// Everything that outlives a connection.
pub(super) struct Pump {
    source: Source,
    journal: Journal,
    desk: Desk,
    /// Of breaks without a sign of life between them.
    backoff: Option<Backoff>,
}

impl Pump {
    pub(super) fn new(source: Source, journal: Journal, desk: Desk) -> Self {
        Self {
            source,
            journal,
            desk,
            backoff: None,
        }
    }

    /// Runs until the stream ends, fails, or nobody listens.
    pub(super) async fn run(mut self, mut link: Link) {
        loop {
            let ending = match self.carry(link).await {
                Ending::Broken(cause) => self.reconnect(cause).await,
                Ending::Over(end) => Err(end),
            };
            match ending {
                Ok(next) => link = next,
                Err(End::Done) => return self.desk.finish().await,
                Err(End::Left) => return,
                Err(End::Fault(error)) => return self.desk.fail(error).await,
            }
        }
    }

    async fn carry(&mut self, mut link: Link) -> Ending {
        loop {
            self.half_close(&mut link);
            let room = link.requests.clone().filter(|_| self.journal.has_request());
            let ended = tokio::select! {
                turn = self.desk.turn() => {
                    (!self.order(turn)).then_some(Ending::Over(End::Left))
                }
                room = reserve(room.clone()), if room.is_some() => {
                    self.send(&mut link, room);
                    None
                }
                answer = link.incoming.next(), if self.desk.ready.is_empty() => {
                    self.answer(&mut link, answer)
                }
            };
            if let Some(ending) = ended {
                return ending;
            }
        }
    }

    /// No order follows and the server has them all: it may end the stream.
    fn half_close(&self, link: &mut Link) {
        if !self.desk.open && self.journal.is_sent() {
            link.requests = None;
        }
    }

    /// Whether anybody still takes events.
    fn order(&mut self, turn: Turn) -> bool {
        match turn {
            Turn::Order(order) => self.desk.ready.extend(self.journal.order(order)),
            Turn::Closed | Turn::Delivered => {}
            Turn::Left => return false,
        }
        true
    }

    fn send(&mut self, link: &mut Link, room: Option<mpsc::OwnedPermit<v1::SolveRequest>>) {
        match room {
            Some(room) => {
                if let Some(message) = self.journal.next_request() {
                    room.send(request(message));
                }
            }
            // The answers say why nothing can be sent.
            None => link.requests = None,
        }
    }

    fn answer(
        &mut self,
        link: &mut Link,
        answer: Result<Option<Response>, Stop>,
    ) -> Option<Ending> {
        let message = match answer {
            Ok(Some(message)) => message,
            Ok(None) if self.source.ends(&self.journal) => return Some(Ending::Over(End::Done)),
            Ok(None) => {
                let message = "the stream ended before its answers".to_owned();
                return Some(Ending::Broken(ClientError::Broken { message }));
            }
            Err(Stop::Broken(cause)) => return Some(Ending::Broken(cause)),
            Err(Stop::Fault(error)) => return Some(Ending::Over(End::Fault(error))),
        };
        self.backoff = None;
        match self.collect(link, message) {
            Ok(()) => None,
            Err(error) => Some(Ending::Over(End::Fault(error))),
        }
    }

    fn collect(&mut self, link: &mut Link, message: Response) -> Result<(), ClientError> {
        if let Some(event) = link.collector.take(message)? {
            self.desk.ready.extend(self.journal.take(event)?);
        }
        Ok(())
    }

    /// Tries until a connection stands or the patience is used up.
    async fn reconnect(&mut self, mut cause: ClientError) -> Result<Link, End> {
        let (patience, now) = (self.source.patience(), Instant::now());
        let mut backoff = match self.backoff.take() {
            Some(backoff) => backoff,
            None => Backoff::new(patience, now),
        };
        if !patience.is_zero() {
            let cause = cause.to_string();
            self.desk.ready.push_back(Event::ConnectionLost { cause });
        }
        while let Some(pause) = backoff.pause(Instant::now()) {
            self.meanwhile(sleep(pause)).await?;
            match self.attempt(backoff.attempt(Instant::now())).await? {
                Ok(link) => {
                    let attempts = backoff.attempts();
                    self.desk.ready.push_back(Event::Reconnected { attempts });
                    self.backoff = Some(backoff);
                    return Ok(link);
                }
                Err(again) => cause = again,
            }
        }
        Err(End::Fault(cause))
    }

    /// One new connection, or why there is none yet.
    async fn attempt(&mut self, limit: Duration) -> Result<Result<Link, ClientError>, End> {
        let (source, seen) = (self.source.clone(), self.journal.seen());
        let attached = timeout(limit, source.attach(Some(seen)));
        match self.meanwhile(attached).await? {
            Ok(Ok((opened, link))) => {
                self.journal.resume(&opened).map_err(End::Fault)?;
                Ok(Ok(link))
            }
            Ok(Err(Stop::Broken(cause))) => Ok(Err(cause)),
            // The server has not noticed the break yet.
            Ok(Err(Stop::Fault(error))) if error.is_reason("SESSION_BUSY") => Ok(Err(error)),
            Ok(Err(Stop::Fault(error))) => Err(End::Fault(error)),
            Err(_) => Ok(Err(ClientError::Silent(self.source.patience()))),
        }
    }

    /// Waits for `work` while orders come and events go.
    async fn meanwhile<T>(&mut self, work: impl Future<Output = T>) -> Result<T, End> {
        let mut work = pin!(work);
        loop {
            let turn = tokio::select! {
                done = &mut work => return Ok(done),
                turn = self.desk.turn() => turn,
            };
            if !self.order(turn) {
                return Err(End::Left);
            }
        }
    }
}

async fn reserve(
    requests: Option<mpsc::Sender<v1::SolveRequest>>,
) -> Option<mpsc::OwnedPermit<v1::SolveRequest>> {
    requests?.reserve_owned().await.ok()
}

pub(super) fn request(message: Request) -> v1::SolveRequest {
    v1::SolveRequest {
        message: Some(message),
    }
}
