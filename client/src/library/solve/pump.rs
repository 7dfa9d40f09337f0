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
use signorini_proto::v1::solve_response::Message as Response;
use tokio::sync::mpsc;
use tokio::time::{sleep, timeout};

use super::events::Event;
use super::journal::Journal;
use super::link::{Link, request};
use super::source::Source;
use super::user_channels::{Activity, UserChannels};
use crate::library::backoff::Backoff;
use crate::library::breaks::Stop;
use crate::library::error::ClientError;

/// How a stream ended.
enum StreamEnd {
    Done,
    /// Nobody takes events any more.
    Left,
    Fault(ClientError),
}

/// How a connection ended.
enum LinkEnd {
    Broken(ClientError),
    /// And the stream with it.
    Over(StreamEnd),
}

/// Everything that outlives a connection.
pub(super) struct Pump {
    source: Source,
    journal: Journal,
    user: UserChannels,
    /// Of breaks without a sign of life between them.
    backoff: Option<Backoff>,
}

impl Pump {
    pub(super) fn new(source: Source, journal: Journal, user: UserChannels) -> Self {
        Self {
            source,
            journal,
            user,
            backoff: None,
        }
    }

    /// Runs until the stream ends, fails, or nobody listens.
    pub(super) async fn run(mut self, mut link: Link) {
        loop {
            let ending = match self.carry(link).await {
                LinkEnd::Broken(cause) => self.reconnect(cause).await,
                LinkEnd::Over(end) => Err(end),
            };
            match ending {
                Ok(next) => link = next,
                Err(StreamEnd::Done) => return self.user.finish().await,
                Err(StreamEnd::Left) => return,
                Err(StreamEnd::Fault(error)) => return self.user.fail(error).await,
            }
        }
    }

    async fn carry(&mut self, mut link: Link) -> LinkEnd {
        loop {
            self.half_close(&mut link);
            let room = link.requests.clone().filter(|_| self.journal.has_request());
            let ended = tokio::select! {
                activity = self.user.activity() => {
                    (!self.order(activity)).then_some(LinkEnd::Over(StreamEnd::Left))
                }
                room = reserve(room.clone()), if room.is_some() => {
                    self.send(&mut link, room);
                    None
                }
                answer = link.incoming.next(), if self.user.ready.is_empty() => {
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
        if !self.user.open && self.journal.is_sent() {
            link.requests = None;
        }
    }

    /// Whether anybody still takes events.
    fn order(&mut self, activity: Activity) -> bool {
        match activity {
            Activity::Order(order) => self.user.ready.extend(self.journal.order(*order)),
            Activity::Closed | Activity::Delivered => {}
            Activity::Left => return false,
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
    ) -> Option<LinkEnd> {
        let message = match answer {
            Ok(Some(message)) => message,
            Ok(None) if self.source.ends(&self.journal) => {
                return Some(LinkEnd::Over(StreamEnd::Done));
            }
            Ok(None) => {
                let message = "the stream ended before its answers".to_owned();
                return Some(LinkEnd::Broken(ClientError::Broken { message }));
            }
            Err(Stop::Broken(cause)) => return Some(LinkEnd::Broken(cause)),
            Err(Stop::Fault(error)) => return Some(LinkEnd::Over(StreamEnd::Fault(error))),
        };
        self.backoff = None;
        match self.collect(link, message) {
            Ok(()) => None,
            Err(error) => Some(LinkEnd::Over(StreamEnd::Fault(error))),
        }
    }

    fn collect(&mut self, link: &mut Link, message: Response) -> Result<(), ClientError> {
        if let Some(event) = link.collector.take(message)? {
            self.user.ready.extend(self.journal.take(event)?);
        }
        Ok(())
    }

    /// Tries until a connection stands or the patience is used up.
    async fn reconnect(&mut self, mut cause: ClientError) -> Result<Link, StreamEnd> {
        let (patience, now) = (self.source.patience(), Instant::now());
        let mut backoff = match self.backoff.take() {
            Some(backoff) => backoff,
            None => Backoff::new(patience, now),
        };
        if !patience.is_zero() {
            let cause = cause.to_string();
            self.user.ready.push_back(Event::ConnectionLost { cause });
        }
        while let Some(pause) = backoff.pause(Instant::now()) {
            self.meanwhile(sleep(pause)).await?;
            match self.attempt(backoff.attempt(Instant::now())).await? {
                Ok(link) => {
                    let attempts = backoff.attempts();
                    self.user.ready.push_back(Event::Reconnected { attempts });
                    self.backoff = Some(backoff);
                    return Ok(link);
                }
                Err(again) => cause = again,
            }
        }
        Err(StreamEnd::Fault(cause))
    }

    /// One new connection, or why there is none yet.
    async fn attempt(&mut self, limit: Duration) -> Result<Result<Link, ClientError>, StreamEnd> {
        let (source, seen) = (self.source.clone(), self.journal.seen());
        let attached = timeout(limit, source.attach(Some(seen)));
        match self.meanwhile(attached).await? {
            Ok(Ok((opened, link))) => {
                self.journal.resume(&opened).map_err(StreamEnd::Fault)?;
                Ok(Ok(link))
            }
            Ok(Err(Stop::Broken(cause))) => Ok(Err(cause)),
            // The server has not noticed the break yet.
            Ok(Err(Stop::Fault(error))) if error.is_reason("SESSION_BUSY") => Ok(Err(error)),
            // It was there before the break.
            Ok(Err(Stop::Fault(error))) if error.is_reason("SESSION_NOT_FOUND") => {
                let name = self.source.session.clone();
                Err(StreamEnd::Fault(ClientError::SessionLost(name)))
            }
            Ok(Err(Stop::Fault(error))) => Err(StreamEnd::Fault(error)),
            Err(_) => Ok(Err(ClientError::Silent(self.source.patience()))),
        }
    }

    /// Waits for `work` while orders come and events go.
    async fn meanwhile<T>(&mut self, work: impl Future<Output = T>) -> Result<T, StreamEnd> {
        let mut work = pin!(work);
        loop {
            let activity = tokio::select! {
                done = &mut work => return Ok(done),
                activity = self.user.activity() => activity,
            };
            if !self.order(activity) {
                return Err(StreamEnd::Left);
            }
        }
    }
}

async fn reserve(
    requests: Option<mpsc::Sender<v1::SolveRequest>>,
) -> Option<mpsc::OwnedPermit<v1::SolveRequest>> {
    requests?.reserve_owned().await.ok()
}
