//! The body of a request behind the gate: whole messages, each with its room and its time.
//!
//! A message of a stream has to be there in time once its first byte is. The one message of a unary call has that time
//! from the start of the call, and the end of the call has it after the message: who sends nothing
//! holds a call no longer than who sends slowly.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use bytes::{Buf as _, Bytes, BytesMut};
use hyper::body::{Body as HttpBody, Frame};
use tokio::runtime::{Handle, RuntimeFlavor};
use tokio::time::Sleep;
use tonic::Status;
use tonic::body::Body;

use super::decode::{Decode, Entry, Permit};
use crate::door::client_key::ClientIdentity;
use crate::fault::Fault;
use crate::process::limits::MESSAGE_BYTES;

/// Before each message: a flag and the length (gRPC over HTTP/2).
const PREFIX_BYTES: usize = 5;
/// Of a slow line, which is given its time beside.
const LEAST_BYTES_PER_SECOND: u64 = 64 << 10;
/// A message from this size on is looked at and decoded beside what the runtime serves.
const LARGE_BYTES: usize = 64 << 10;

/// Room that a call keeps until it is answered.
pub(super) type Kept = Arc<Mutex<Vec<Permit>>>;

/// What a body gives.
type Next = Option<Result<Frame<Bytes>, Status>>;

type Waiting = Pin<Box<dyn Future<Output = Result<Permit, Fault>> + Send>>;

enum Stage {
    /// Before a message.
    Between,
    /// For room for a message of that size with its prefix.
    Waits(usize, Waiting),
    Collects(usize, Permit, Pin<Box<Sleep>>),
    /// Turned away: nothing is kept of the message, and whoever sent it hears of it later, as if
    /// it had waited. Told at once it would come again at once.
    Refused(Fault, Pin<Box<Sleep>>),
    /// Too large a message follows, which the transport refuses by its prefix.
    Passes,
    Over,
}

/// A body of whole messages.
pub(super) struct Gated {
    inner: Body,
    gate: Arc<Decode>,
    client: ClientIdentity,
    /// What its messages are; `None` for calls that are not of the contract.
    shape: Option<usize>,
    /// Where room goes that is kept until the answer.
    kept: Option<Kept>,
    /// Room of the message that was handed on last.
    last: Vec<Permit>,
    collected: BytesMut,
    stage: Stage,
    /// Until which the next message has to begin, or the call to end.
    due: Option<Pin<Box<Sleep>>>,
}

impl Gated {
    pub(super) fn new(
        inner: Body,
        (gate, client): (Arc<Decode>, ClientIdentity),
        shape: Option<usize>,
        kept: Option<Kept>,
    ) -> Self {
        Self {
            inner,
            gate,
            client,
            shape,
            kept,
            last: Vec::new(),
            collected: BytesMut::new(),
            stage: Stage::Between,
            due: None,
        }
    }

    /// Whether what has to come next between two messages did not come in time.
    fn is_late(&mut self, context: &mut Context<'_>) -> bool {
        if self.kept.is_none() && self.collected.is_empty() {
            // A stream may rest.
            return false;
        }
        let time = self.gate.request_time;
        let due = self
            .due
            .get_or_insert_with(|| Box::pin(tokio::time::sleep(time)));
        due.as_mut().poll(context).is_ready()
    }

    /// Waits for the bytes of a message that has room.
    fn collects(&self, size: usize, permit: Permit) -> Stage {
        let slow = Duration::from_secs(size as u64 / LEAST_BYTES_PER_SECOND);
        let time = self.gate.request_time + slow;
        Stage::Collects(size, permit, Box::pin(tokio::time::sleep(time)))
    }

    /// The bytes of the next message with its prefix, when that has arrived.
    fn announced(&self) -> Option<usize> {
        let prefix = self.collected.get(..PREFIX_BYTES)?;
        let length = prefix.get(1..)?.try_into().ok().map(u32::from_be_bytes)?;
        Some(PREFIX_BYTES + length as usize)
    }

    /// Hands on a message that has arrived.
    fn message(&mut self, size: usize, received: Permit) -> Result<Bytes, Fault> {
        let message = self.collected.split_to(size).freeze();
        let shape = self.shape;
        let content = message.get(PREFIX_BYTES..).unwrap_or_default();
        let decoded = shape.map(|shape| unhindered(size, || self.gate.decode(shape, content)));
        let permits = std::iter::once(received).chain(decoded.transpose()?);
        match &self.kept {
            Some(kept) => kept
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .extend(permits),
            None => self.last = permits.collect(),
        }
        Ok(message)
    }

    /// Drops what has come, with what the transport holds, which takes nothing more.
    fn turn_away(&mut self, fault: Fault) -> Stage {
        self.inner = Body::empty();
        self.collected = BytesMut::new();
        Stage::Refused(fault, Box::pin(tokio::time::sleep(self.gate.patience)))
    }

    fn fail(&mut self, fault: Fault) -> Poll<Next> {
        self.stage = Stage::Over;
        if self.kept.is_some() {
            // A stream counts what it ends with.
            self.gate.refused(&fault);
        }
        Poll::Ready(Some(Err(fault.into())))
    }
}

fn late() -> Fault {
    Fault::request("message", "came too slowly")
}

/// Runs the look at a message of so many bytes. For a large one another thread takes over the
/// tasks of this one, short calls such as health among them, and keeps them when the look is
/// over: the transport decodes the message in the rest of the same poll.
fn unhindered<T>(bytes: usize, look: impl FnOnce() -> T) -> T {
    let runtime = Handle::try_current().map(|runtime| runtime.runtime_flavor());
    let has_others = matches!(runtime, Ok(RuntimeFlavor::MultiThread));
    match has_others && bytes >= LARGE_BYTES {
        #[expect(
            clippy::disallowed_methods,
            reason = "no solver work: the decoder runs here"
        )]
        true => tokio::task::block_in_place(look),
        false => look(),
    }
}

impl Drop for Gated {
    fn drop(&mut self) {
        self.last.clear();
        self.kept = None;
        self.stage = Stage::Over;
        self.gate.show();
    }
}

impl HttpBody for Gated {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Next> {
        let this = &mut *self;
        // Whoever asks again has decoded the last one.
        if !this.last.is_empty() {
            this.last.clear();
            this.gate.show();
        }
        loop {
            match std::mem::replace(&mut this.stage, Stage::Over) {
                Stage::Over => return Poll::Ready(None),
                Stage::Passes => {
                    this.stage = Stage::Passes;
                    if this.collected.has_remaining() {
                        let rest = this.collected.split().freeze();
                        return Poll::Ready(Some(Ok(Frame::data(rest))));
                    }
                    return Pin::new(&mut this.inner).poll_frame(context);
                }
                Stage::Between => match this.announced() {
                    Some(size) if size > PREFIX_BYTES + MESSAGE_BYTES => {
                        this.stage = Stage::Passes;
                    }
                    Some(size) => {
                        this.due = None;
                        this.stage = match this.gate.receive(this.client, size) {
                            Entry::Room(permit) => this.collects(size, permit),
                            Entry::Waits(room) => Stage::Waits(size, room),
                            Entry::Full(fault) => this.turn_away(fault),
                        };
                    }
                    None => {
                        if this.is_late(context) {
                            return this.fail(late());
                        }
                        this.stage = Stage::Between;
                        if let Some(end) = ready!(this.collect(context)) {
                            return Poll::Ready(end);
                        }
                    }
                },
                Stage::Waits(size, mut room) => match room.as_mut().poll(context) {
                    Poll::Pending => {
                        this.stage = Stage::Waits(size, room);
                        return Poll::Pending;
                    }
                    Poll::Ready(Err(fault)) => return this.fail(fault),
                    Poll::Ready(Ok(permit)) => this.stage = this.collects(size, permit),
                },
                Stage::Refused(fault, mut clock) => match clock.as_mut().poll(context) {
                    Poll::Pending => {
                        this.stage = Stage::Refused(fault, clock);
                        return Poll::Pending;
                    }
                    Poll::Ready(()) => return this.fail(fault),
                },
                Stage::Collects(size, permit, mut clock) => {
                    if this.collected.len() >= size {
                        this.stage = Stage::Between;
                        return match this.message(size, permit) {
                            Ok(message) => Poll::Ready(Some(Ok(Frame::data(message)))),
                            Err(fault) => this.fail(fault),
                        };
                    }
                    let is_late = clock.as_mut().poll(context).is_ready();
                    this.stage = Stage::Collects(size, permit, clock);
                    if is_late {
                        return this.fail(late());
                    }
                    if let Some(end) = ready!(this.collect(context)) {
                        return Poll::Ready(end);
                    }
                }
            }
        }
    }
}

impl Gated {
    /// Adds the next bytes; the end of the body, or its failure, is returned.
    fn collect(&mut self, context: &mut Context<'_>) -> Poll<Option<Next>> {
        let next = ready!(Pin::new(&mut self.inner).poll_frame(context));
        let frame = match next {
            Some(Ok(frame)) => frame,
            Some(Err(status)) => {
                self.stage = Stage::Over;
                return Poll::Ready(Some(Some(Err(status))));
            }
            None => {
                self.stage = Stage::Over;
                // A part of a message: the transport says what is wrong with it.
                let rest = self.collected.split().freeze();
                let rest = (!rest.is_empty()).then(|| Ok(Frame::data(rest)));
                return Poll::Ready(Some(rest));
            }
        };
        match frame.into_data() {
            Ok(data) => {
                self.collected.extend_from_slice(&data);
                Poll::Ready(None)
            }
            Err(frame) => Poll::Ready(Some(Some(Ok(frame)))),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    /// A body that sends one frame and then nothing, and is noticed when it goes.
    struct Endless {
        frame: Option<Bytes>,
        _here: Arc<()>,
    }

    impl HttpBody for Endless {
        type Data = Bytes;
        type Error = Status;

        fn poll_frame(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Next> {
            match self.frame.take() {
                Some(bytes) => Poll::Ready(Some(Ok(Frame::data(bytes)))),
                None => Poll::Pending,
            }
        }
    }

    /// The start of a message of so many bytes.
    fn begun(gate: &Arc<Decode>, bytes: usize) -> (Pin<Box<Gated>>, Arc<()>) {
        let prefix = u32::try_from(bytes).unwrap().to_be_bytes();
        let frame: Vec<u8> = std::iter::once(0).chain(prefix).chain([7; 1000]).collect();
        let here = Arc::new(());
        let (frame, _here) = (Some(frame.into()), Arc::clone(&here));
        let body = Body::new(Endless { frame, _here });
        let door = (Arc::clone(gate), ClientIdentity::Unknown);
        (Box::pin(Gated::new(body, door, None, None)), here)
    }

    #[tokio::test]
    async fn a_message_without_a_place_is_dropped_at_once_and_told_later() {
        let metrics = crate::watch::metrics::Metrics::new().unwrap();
        let mut gate = Decode::new(0, Duration::from_secs(10), &metrics).unwrap();
        Arc::get_mut(&mut gate).unwrap().patience = Duration::from_millis(50);
        let mut context = Context::from_waker(std::task::Waker::noop());
        let mut all = Vec::new();
        // Until one is turned away: those before it are collected or wait.
        let mut refused = loop {
            let (mut body, here) = begun(&gate, 4 << 20);
            assert!(body.as_mut().poll_frame(&mut context).is_pending());
            if Arc::strong_count(&here) == 1 {
                break body;
            }
            all.push(body);
            assert!(all.len() < 100);
        };
        let begun = tokio::time::Instant::now();
        let next = std::future::poll_fn(|context| refused.as_mut().poll_frame(context)).await;
        let status = next.unwrap().unwrap_err();
        assert_eq!(status.code(), tonic::Code::ResourceExhausted);
        assert!(begun.elapsed() >= gate.patience);
        let end = std::future::poll_fn(|context| refused.as_mut().poll_frame(context)).await;
        assert!(end.is_none());
    }

    #[test]
    fn a_look_at_a_large_message_holds_up_no_other_task() {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .unwrap();
        let looking = runtime.spawn(async {
            let (sender, receiver) = mpsc::channel();
            tokio::spawn(async move { sender.send(()).unwrap() });
            unhindered(LARGE_BYTES, || {
                receiver.recv_timeout(Duration::from_secs(20))
            })
        });
        runtime.block_on(looking).unwrap().unwrap();
    }

    #[tokio::test]
    async fn a_runtime_of_one_thread_looks_at_it_where_it_is() {
        assert_eq!(unhindered(LARGE_BYTES, || 7), 7);
    }
}
