//! Drives a session step by step and passes its events on.

use std::time::Duration;

use signorini_client::solve::{Attach, Canceller, Events, Solve, Updates};
use signorini_client::{Client, ClientError};
use signorini_proto::v1;

use crate::commands::Interrupts;
use crate::report::record::Record;
use crate::terminal::exit::{Exit, Failure};

/// For the reason of an end that nobody here asked for.
const PARTING: Duration = Duration::from_secs(5);

/// A run and where its results go.
pub(super) struct Run {
    pub(super) record: Record,
    /// How long a broken connection is tried again, and the server waits for this.
    patience: Duration,
    interrupted: bool,
}

/// What a run waits for. The signals are listened to all the time, so that none
/// is lost while files are written.
struct Answers {
    events: Events,
    canceller: Canceller,
    interrupts: Interrupts,
}

impl Run {
    pub(super) fn new(record: Record, patience: Duration) -> Self {
        Self {
            record,
            patience,
            interrupted: false,
        }
    }

    /// Sends the steps one after another until one does not converge.
    pub(super) async fn drive(
        &mut self,
        client: &Client,
        session: &str,
        steps: Vec<v1::LoadStep>,
    ) -> Result<Exit, Failure> {
        let attach = Attach {
            iteration_interval: self.record.iteration_interval(),
            // A client that was killed comes back no more.
            on_disconnect: v1::DisconnectPolicy::CancelStep,
            disconnect_grace: self.patience,
            patience: self.patience,
            ..Default::default()
        };
        let Solve {
            mut updates,
            events,
            ..
        } = client.solve(session, attach).await?;
        let mut answers = Answers {
            events,
            canceller: updates.canceller(),
            interrupts: Interrupts::new()?,
        };
        for step in steps {
            let termination = self.step(step, &mut updates, &mut answers).await?;
            if self.interrupted {
                return Ok(Exit::Interrupted);
            }
            if termination == v1::Termination::Cancelled {
                self.hear_why(updates, answers).await;
                return Ok(Exit::from(termination));
            }
            if termination != v1::Termination::Converged {
                return Ok(Exit::from(termination));
            }
        }
        Ok(Exit::Ok)
    }

    async fn step(
        &mut self,
        step: v1::LoadStep,
        updates: &mut Updates,
        answers: &mut Answers,
    ) -> Result<v1::Termination, Failure> {
        let sequence = match updates.load_step(step).await {
            Ok(sequence) => sequence,
            // The events say why.
            Err(ClientError::Closed) => 0,
            Err(error) => return Err(error.into()),
        };
        self.wait(sequence, answers).await
    }

    /// Takes events until the step that was sent is done.
    async fn wait(
        &mut self,
        sequence: i64,
        answers: &mut Answers,
    ) -> Result<v1::Termination, Failure> {
        loop {
            let event = tokio::select! {
                event = answers.events.next() => event?,
                () = answers.interrupts.next() => {
                    self.interrupt(sequence, &answers.canceller).await;
                    continue;
                }
            };
            let Some(event) = event else {
                let message = "the stream ended before the result of a step";
                return Err(Failure::new(Exit::Server, message));
            };
            if let Some(termination) = self.record.take(event)? {
                return Ok(termination);
            }
        }
    }

    /// The first time cancels and keeps the last state, the second time quits.
    async fn interrupt(&mut self, sequence: i64, canceller: &Canceller) {
        if self.interrupted {
            self.record.progress.clear();
            std::process::exit(Exit::Interrupted as i32);
        }
        self.interrupted = true;
        self.record
            .progress
            .note("cancelling; press Ctrl-C again to quit at once");
        // When the stream has ended, the events say why.
        let _ended = canceller.cancel(sequence).await;
    }

    /// A server that shuts down cancels the step and says so at the end of the
    /// stream; any other end says that somebody else has cancelled it.
    async fn hear_why(&self, updates: Updates, answers: Answers) {
        let Answers { mut events, .. } = answers;
        drop(updates);
        let ended = async {
            loop {
                match events.next().await {
                    Ok(Some(_)) => {}
                    Ok(None) => return "the step was cancelled from elsewhere".to_owned(),
                    Err(error) => return error.to_string(),
                }
            }
        };
        if let Ok(why) = tokio::time::timeout(PARTING, ended).await {
            self.record
                .progress
                .note(&format!("{why}; the last state is kept"));
        }
    }
}
