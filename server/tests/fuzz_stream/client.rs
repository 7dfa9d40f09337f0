//! One stream of a session: sends moves, reads answers into the journal.

#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "most moves are alike in most ways"
)]

use fastrand::Rng;
use signorini_proto::v1::session_service_client::SessionServiceClient;
use signorini_proto::v1::solve_request::Message;
use signorini_proto::v1::{self as wire, solve_response};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Streaming;

use super::journal::Journal;
use super::{Move, common};
use common::{Server, open, press, target};

/// How a stream ended.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    Well,
    Invalid,
    Deleted,
}

/// Calls `Solve` with `open` on its way, on a connection of its own: the transport
/// closes one on which a thousand streams have ended in error.
async fn call(
    server: &Server,
    open: wire::SolveOpen,
) -> (
    mpsc::Sender<wire::SolveRequest>,
    Streaming<wire::SolveResponse>,
) {
    let (sender, outbound) = mpsc::channel(16);
    let message = Some(Message::Open(open));
    sender.send(wire::SolveRequest { message }).await.unwrap();
    let mut client = SessionServiceClient::new(server.connect().await);
    let answers = client.solve(ReceiverStream::new(outbound)).await;
    (sender, answers.unwrap().into_inner())
}

fn message(response: Option<wire::SolveResponse>) -> solve_response::Message {
    response.unwrap().message.unwrap()
}

/// A writer's stream; a task reads it, so that neither way waits for the other.
pub(crate) struct Client {
    session: String,
    sender: Option<mpsc::Sender<wire::SolveRequest>>,
    answers: mpsc::UnboundedReceiver<Result<solve_response::Message, tonic::Status>>,
    reading: tokio::task::JoinHandle<()>,
    /// The sequence that is next as far as is known.
    next: i64,
}

impl Client {
    /// Opens with a random point to resume from.
    pub(crate) async fn open(
        server: &Server,
        session: &str,
        journal: &mut Journal,
        rng: &mut Rng,
    ) -> Self {
        let seen = match rng.u32(..4) {
            0 => None,
            1 => Some(0),
            2 => Some(journal.last_seen()),
            _ => Some(rng.i64(0..=journal.last_seen() + 1)),
        };
        Self::open_from(server, session, journal, seen, rng).await
    }

    /// Opens as soon as the server has noticed that the client before has left.
    pub(crate) async fn open_from(
        server: &Server,
        session: &str,
        journal: &mut Journal,
        last_seen_event: Option<i64>,
        rng: &mut Rng,
    ) -> Self {
        let mut request = wire::SolveOpen {
            last_seen_event,
            fields: vec![1; rng.usize(..2)],
            on_disconnect: rng.i32(0..=2),
            disconnect_grace: common::duration(rng.i64(1..50)).filter(|_| rng.bool()),
            ..open(session)
        };
        loop {
            let (sender, mut inbound) = call(server, request.clone()).await;
            match inbound.message().await.map(message) {
                Ok(solve_response::Message::Opened(opened)) => {
                    journal.message(None);
                    journal.opened(opened.last_event);
                    let next = opened.session.unwrap().last_accepted_sequence + 1;
                    return Self::reading(session, sender, inbound, next);
                }
                Ok(other) => panic!("{other:?} before `opened`"),
                // What nobody has seen is no place to go on from.
                Err(status) if common::reason(&status) == "EVENT_NOT_FOUND" => {
                    assert!(request.last_seen_event > Some(journal.last_seen()));
                    request.last_seen_event = Some(journal.last_seen());
                }
                Err(status) => assert_eq!(common::reason(&status), "SESSION_BUSY"),
            }
        }
    }

    fn reading(
        session: &str,
        sender: mpsc::Sender<wire::SolveRequest>,
        mut inbound: Streaming<wire::SolveResponse>,
        next: i64,
    ) -> Self {
        let (told, answers) = mpsc::unbounded_channel();
        let reading = tokio::spawn(async move {
            while let Some(answer) = inbound.message().await.transpose() {
                let answer = answer.map(|answer| answer.message.unwrap());
                let ended = answer.is_err();
                if told.send(answer).is_err() || ended {
                    return;
                }
            }
        });
        Self {
            session: session.into(),
            sender: Some(sender),
            answers,
            reading,
            next,
        }
    }

    async fn send(&self, message: Option<Message>) {
        let sender = self.sender.as_ref().unwrap();
        // A stream that has ended takes nothing; its end is told by `end`.
        sender.send(wire::SolveRequest { message }).await.ok();
    }

    /// Breaks the rules of the stream itself.
    pub(crate) async fn break_protocol(&self, how: Move, journal: &mut Journal) {
        journal.message(None);
        let again = Message::Open(open(&self.session));
        self.send(matches!(how, Move::SecondOpen).then_some(again))
            .await;
    }

    /// Sends an update or a cancellation.
    pub(crate) async fn update(&mut self, what: Move, journal: &mut Journal, rng: &mut Rng) {
        let sequence = match what {
            Move::Gap => self.next + 1 + rng.i64(..3),
            Move::BelowOne => [0, -1, i64::MIN][rng.usize(..3)],
            Move::Repeat => (self.next - 1 - rng.i64(..3)).max(1),
            Move::CancelRunning => return self.cancel(0, journal).await,
            Move::CancelAny => {
                let any = [self.next - 1, self.next, 1, -1, i64::MAX];
                return self.cancel(any[rng.usize(..any.len())], journal).await;
            }
            _ => self.next,
        };
        journal.message(Some(sequence));
        self.send(Some(update(what, sequence, rng))).await;
        if matches!(what, Move::Good | Move::LongThenCancel) {
            self.next += 1;
        }
        if matches!(what, Move::LongThenCancel) {
            self.cancel(sequence, journal).await;
        }
    }

    async fn cancel(&self, sequence: i64, journal: &mut Journal) {
        journal.message(None);
        self.send(Some(Message::Cancel(wire::SolveCancel { sequence })))
            .await;
    }

    /// Another writer is refused while this one is there.
    pub(crate) async fn rival(&self, server: &Server) {
        let (_sender, mut answers) = call(server, open(&self.session)).await;
        let status = answers.message().await.unwrap_err();
        assert_eq!(common::reason(&status), "SESSION_BUSY");
    }

    /// Learns which sequence is next.
    pub(crate) async fn catch_up(&mut self, server: &Server) {
        let session = server.describe(&self.session).await;
        self.next = session.last_accepted_sequence + 1;
    }

    pub(crate) fn half_close(&mut self) {
        self.sender = None;
    }

    /// Breaks the connection; what was told until now is noted.
    pub(crate) fn leave(mut self, journal: &mut Journal) {
        self.reading.abort();
        while let Ok(Ok(answer)) = self.answers.try_recv() {
            note(&answer, journal);
        }
    }

    /// Reads to the end.
    pub(crate) async fn end(&mut self, journal: &mut Journal) -> Ending {
        while let Some(answer) = self.answers.recv().await {
            match answer {
                Ok(answer) => note(&answer, journal),
                Err(status) => match common::reason(&status).as_str() {
                    "REQUEST_INVALID" | "UNSUPPORTED_COMBINATION" => return Ending::Invalid,
                    "SESSION_DELETED" => return Ending::Deleted,
                    other => panic!("the stream ends with {other}"),
                },
            }
        }
        Ending::Well
    }
}

fn note(answer: &solve_response::Message, journal: &mut Journal) {
    match answer {
        solve_response::Message::StepFinished(one) => journal.result(one),
        solve_response::Message::UpdateRejected(one) => journal.rejection(one),
        solve_response::Message::Opened(_) => panic!("`opened` comes once"),
        solve_response::Message::Iteration(_)
        | solve_response::Message::Field(_)
        | solve_response::Message::Heartbeat(_) => {}
    }
}

/// A load step or a movement of the obstacle.
fn update(what: Move, sequence: i64, rng: &mut Rng) -> Message {
    let step = step(what, rng);
    if rng.bool() {
        return Message::ObstacleUpdate(wire::ObstacleUpdate {
            sequence,
            obstacles: step.obstacles,
            increments: step.increments,
            max_wall_time: None,
        });
    }
    Message::LoadStep(wire::LoadStepUpdate {
        sequence,
        step: Some(step),
        max_wall_time: None,
    })
}

fn step(what: Move, rng: &mut Rng) -> wire::LoadStep {
    let mut step = press(0.02 * rng.f64(), rng.i32(1..=3));
    match what {
        Move::NotFinite => step.obstacles = vec![target(f64::NAN)],
        Move::UnknownObstacle => step.obstacles[0].name = "bal".into(),
        Move::NoObstacle => step.obstacles.clear(),
        Move::NoIncrement => step.increments = Some([0, -1, i32::MIN][rng.usize(..3)]),
        Move::TooManyIncrements => step.increments = Some(i32::MAX),
        Move::LongThenCancel => step.increments = Some(100_000),
        _ => {}
    }
    step
}
