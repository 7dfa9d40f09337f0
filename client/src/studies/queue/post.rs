//! Publishes cases and results so that each is there once, over breaks of the connection.

use std::collections::VecDeque;
use std::future::IntoFuture as _;
use std::time::Duration;

use async_nats::jetstream::context::{PublishAckFuture, PublishError, PublishErrorKind};
use async_nats::jetstream::message::PublishMessage;
use bytes::Bytes;
use tokio::time::sleep;

use super::{CASES, ID_HEADER, Queue, RESULTS, broken, case_subject, result_subject};
use crate::studies::row::Row;
use crate::terminal::exit::Failure;

/// Cases that are on the way to the queue at one time.
const WINDOW: usize = 256;
/// Before something is published again; doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(50);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Times that a publication is tried, over some five minutes.
const TRIES: usize = 150;

/// How a publication ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Posted {
    /// It is there, now or before.
    There,
    /// Its identifier is known, so it was dropped; it may be gone since.
    Known,
    /// Nobody knows: it is to be published again.
    Unknown,
}

/// A case on its way, as it is published again if need be.
#[derive(Clone)]
struct Parcel {
    subject: String,
    case: String,
    id: String,
    payload: Bytes,
}

/// Cases on their way to the queue.
pub(super) struct Mail<'a> {
    queue: &'a Queue,
    study: &'a str,
    on_the_way: VecDeque<(Parcel, PublishAckFuture)>,
}

impl<'a> Mail<'a> {
    pub(super) fn new(queue: &'a Queue, study: &'a str) -> Self {
        Self {
            queue,
            study,
            on_the_way: VecDeque::new(),
        }
    }

    /// Publishes a case; waits for earlier ones when many are on the way.
    pub(super) async fn send(
        &mut self,
        case: u64,
        id: &str,
        payload: Bytes,
    ) -> Result<(), Failure> {
        let parcel = Parcel {
            subject: case_subject(self.study, case),
            case: id.to_owned(),
            id: format!("{}-{id}", self.study),
            payload,
        };
        if self.on_the_way.len() >= WINDOW {
            self.settle().await?;
        }
        let message = message(&parcel).message_id(&parcel.id);
        let (context, subject) = (&self.queue.context, parcel.subject.clone());
        match context.send_publish(subject, message).await {
            Ok(acknowledged) => self.on_the_way.push_back((parcel, acknowledged)),
            Err(error) if error.kind() == PublishErrorKind::MaxPayloadExceeded => {
                return Err(broken(error));
            }
            Err(_) => again(self.queue, &parcel).await?,
        }
        Ok(())
    }

    /// Waits for all that are on the way.
    pub(super) async fn finish(mut self) -> Result<(), Failure> {
        while !self.on_the_way.is_empty() {
            self.settle().await?;
        }
        Ok(())
    }

    async fn settle(&mut self) -> Result<(), Failure> {
        let Some((parcel, acknowledged)) = self.on_the_way.pop_front() else {
            return Ok(());
        };
        let answer = acknowledged.into_future().await;
        match posted(answer.map(|answer| answer.duplicate))? {
            Posted::There => Ok(()),
            Posted::Known | Posted::Unknown => again(self.queue, &parcel).await,
        }
    }
}

fn message(parcel: &Parcel) -> PublishMessage {
    PublishMessage::build()
        .payload(parcel.payload.clone())
        .header(ID_HEADER, parcel.case.as_str())
        .expected_stream(CASES)
        .expected_last_subject_sequence(0)
}

fn posted(answer: Result<bool, PublishError>) -> Result<Posted, Failure> {
    let error = match answer {
        Ok(false) => return Ok(Posted::There),
        Ok(true) => return Ok(Posted::Known),
        Err(error) => error,
    };
    match error.kind() {
        // Its subject has a message.
        PublishErrorKind::WrongLastSequence => Ok(Posted::There),
        PublishErrorKind::MaxPayloadExceeded => Err(broken(error)),
        PublishErrorKind::TimedOut
        | PublishErrorKind::BrokenPipe
        | PublishErrorKind::StreamNotFound
        | PublishErrorKind::WrongLastMessageId
        | PublishErrorKind::MaxAckPending
        | PublishErrorKind::Other => Ok(Posted::Unknown),
    }
}

/// Publishes a case without its identifier, which NATS remembers of one that was taken back
/// too; its subject keeps it from being there twice.
async fn again(queue: &Queue, parcel: &Parcel) -> Result<(), Failure> {
    publish(queue, &parcel.subject, || message(parcel)).await
}

/// Publishes until it is there.
async fn publish(
    queue: &Queue,
    subject: &str,
    message: impl Fn() -> PublishMessage,
) -> Result<(), Failure> {
    let mut pause = FIRST_PAUSE;
    for _ in 0..TRIES {
        let sent = queue
            .context
            .send_publish(subject.to_owned(), message())
            .await;
        let answer = match sent {
            Ok(acknowledged) => acknowledged.into_future().await,
            Err(error) => Err(error),
        };
        if posted(answer.map(|_| false))? == Posted::There {
            return Ok(());
        }
        sleep(pause).await;
        pause = (pause * 2).min(LONGEST_PAUSE);
    }
    Err(broken("does not take what is published"))
}

/// Publishes the row of a case, unless it has one.
pub(super) async fn result(queue: &Queue, study: &str, row: &Row) -> Result<(), Failure> {
    let payload: Bytes = serde_json::to_vec(row).map_err(broken)?.into();
    let message = || {
        PublishMessage::build()
            .payload(payload.clone())
            .expected_stream(RESULTS)
            .expected_last_subject_sequence(0)
    };
    publish(queue, &result_subject(study, row.case), message).await
}
