//! Kept results of a session, read again.

use signorini_proto::v1;
use signorini_proto::v1::read_step_response::Message;
use signorini_proto::v1::solve_response::Message as Response;
use tonic::Streaming;

use crate::library::breaks::again;
use crate::library::connect::{Client, answer};
use crate::library::error::ClientError;
use crate::library::mesh::missing;
use crate::library::session::resource;
use crate::library::solve::{Collector, Event, Increment};

/// Results of one step, one after another.
#[derive(Debug)]
pub struct StepResults {
    stream: Streaming<v1::ReadStepResponse>,
    collector: Collector,
}

impl StepResults {
    /// The next increment with its fields; `None` after the last one that is kept.
    ///
    /// # Errors
    /// [`ClientError`]; none follows.
    pub async fn next(&mut self) -> Result<Option<Increment>, ClientError> {
        while let Some(response) = self.stream.message().await? {
            let message = response
                .message
                .ok_or_else(|| missing("the content of a message"))?;
            if let Some(Event::Increment(increment)) = self.collector.take(as_solved(message))? {
                return Ok(Some(*increment));
            }
        }
        if self.collector.is_waiting() {
            return Err(missing("a field of the last result"));
        }
        Ok(None)
    }
}

fn as_solved(message: Message) -> Response {
    match message {
        Message::StepFinished(finished) => Response::StepFinished(finished),
        Message::Field(chunk) => Response::Field(chunk),
    }
}

impl Client {
    /// Opens the kept results of one sequence, those so far of the one that runs.
    /// No fields named: those of the scene's output.
    ///
    /// # Errors
    /// [`ClientError::Refused`]: `SESSION_NOT_FOUND`, `STEP_NOT_FOUND` (without a
    /// result yet), `SEQUENCE_NOT_RETAINED`.
    pub async fn step_results(
        &self,
        session: &str,
        sequence: i64,
        fields: &[v1::FieldName],
    ) -> Result<StepResults, ClientError> {
        let request = v1::ReadStepRequest {
            name: resource(session),
            sequence,
            increment: 0,
            fields: fields.iter().copied().map(i32::from).collect(),
            element_type: v1::ElementType::F64.into(),
        };
        let read = || async {
            let mut sessions = self.sessions_of(session);
            answer(sessions.read_step(request.clone())).await
        };
        let response = again(read).await?;
        Ok(StepResults {
            stream: response.into_inner(),
            collector: Collector::default(),
        })
    }

    /// All of [`Client::step_results`] at once.
    ///
    /// # Errors
    /// As [`Client::step_results`].
    pub async fn read_step(
        &self,
        session: &str,
        sequence: i64,
        fields: &[v1::FieldName],
    ) -> Result<Vec<Increment>, ClientError> {
        let mut results = self.step_results(session, sequence, fields).await?;
        let mut increments = Vec::new();
        while let Some(increment) = results.next().await? {
            increments.push(increment);
        }
        Ok(increments)
    }
}
