//! Answers of the stream as typed events; fields are put together from chunks.

use signorini_proto::array::{Assembler, element_count};
use signorini_proto::v1;
use signorini_proto::v1::solve_response::Message as Response;

use crate::library::error::{ClientError, Refusal};
use crate::library::mesh::missing;

/// A whole field.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Which.
    pub name: v1::FieldName,
    /// Values per row.
    pub components: usize,
    /// Flat, `[rows, components]`.
    pub values: Vec<f64>,
}

/// The result of one increment, with its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Increment {
    /// Of the update.
    pub sequence: i64,
    /// Number of the result in the session.
    pub event: i64,
    /// Everything but fields.
    pub report: v1::StepReport,
    /// Whether it ends its update.
    pub last: bool,
    /// In the order in which they came.
    pub fields: Vec<Field>,
    /// Fields were asked for that are no longer kept.
    pub fields_dropped: bool,
}

/// One answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Newest statistics; older ones may have been skipped.
    Iteration(v1::IterationStatistics),
    /// A result.
    Increment(Box<Increment>),
    /// A bad update; the stream lives on.
    Rejected {
        /// Of the update, free again.
        sequence: i64,
        /// Why.
        refusal: Box<Refusal>,
    },
    /// A sign of life.
    Heartbeat(v1::StreamHeartbeat),
    /// The connection broke; another one is being tried. What was sent and what
    /// was received is kept, iteration statistics may be lost.
    ConnectionLost {
        /// For people.
        cause: String,
    },
    /// Another connection goes on where the one before broke.
    Reconnected {
        /// Attempts that it took.
        attempts: u32,
    },
}

/// Holds a result until its fields are complete.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    pending: Option<Pending>,
}

#[derive(Debug)]
struct Pending {
    increment: Increment,
    expected: Vec<v1::FieldName>,
    open: Option<(v1::FieldName, usize, Assembler<f64>)>,
}

impl Collector {
    /// Takes a message; an event when it completes one.
    pub(crate) fn take(&mut self, message: Response) -> Result<Option<Event>, ClientError> {
        match message {
            Response::Opened(_) => Err(ClientError::Protocol("`opened` came twice".to_owned())),
            Response::Iteration(statistics) => Ok(Some(Event::Iteration(statistics))),
            Response::StepFinished(finished) => self.begin(finished),
            Response::Field(chunk) => self.add(&chunk),
            Response::UpdateRejected(rejected) => reject(rejected).map(Some),
            Response::Heartbeat(heartbeat) => Ok(Some(Event::Heartbeat(heartbeat))),
        }
    }

    fn begin(&mut self, finished: v1::StepFinished) -> Result<Option<Event>, ClientError> {
        if self.pending.is_some() {
            return Err(missing("a field of the result before"));
        }
        let expected: Vec<_> = finished.fields().collect();
        let increment = Increment {
            sequence: finished.sequence,
            event: finished.event,
            report: finished
                .report
                .ok_or_else(|| missing("the report of a result"))?,
            last: finished.last,
            fields: Vec::new(),
            fields_dropped: finished.fields_dropped,
        };
        self.pending = Some(Pending {
            increment,
            expected,
            open: None,
        });
        Ok(self.complete())
    }

    fn add(&mut self, chunk: &v1::FieldChunk) -> Result<Option<Event>, ClientError> {
        let pending = self
            .pending
            .as_mut()
            .ok_or_else(|| missing("the result of a field"))?;
        pending.add(chunk)?;
        Ok(self.complete())
    }

    /// Whether a result waits for its fields.
    pub(crate) fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }

    fn complete(&mut self) -> Option<Event> {
        let pending = self.pending.take_if(|pending| {
            pending.open.is_none() && pending.increment.fields.len() >= pending.expected.len()
        })?;
        Some(Event::Increment(Box::new(pending.increment)))
    }
}

impl Pending {
    fn add(&mut self, chunk: &v1::FieldChunk) -> Result<(), ClientError> {
        let next = self.expected.get(self.increment.fields.len()).copied();
        if chunk.event != self.increment.event || next != Some(chunk.field()) {
            let message = format!("a chunk of {:?} where {next:?} is next", chunk.field());
            return Err(ClientError::Protocol(message));
        }
        let (name, components, mut assembler) = match self.open.take() {
            Some(open) => open,
            None => begin_field(chunk)?,
        };
        assembler.push(chunk.offset_elements, &chunk.data)?;
        if chunk.last {
            let values = assembler.finish()?;
            self.increment.fields.push(Field {
                name,
                components,
                values,
            });
        } else {
            self.open = Some((name, components, assembler));
        }
        Ok(())
    }
}

fn begin_field(
    chunk: &v1::FieldChunk,
) -> Result<(v1::FieldName, usize, Assembler<f64>), ClientError> {
    if chunk.element_type() != v1::ElementType::F64 {
        return Err(ClientError::Protocol(
            "a field is not of doubles".to_owned(),
        ));
    }
    let components = chunk.shape.get(1).copied().unwrap_or(1);
    let components = usize::try_from(components).unwrap_or_default();
    let count = element_count(&chunk.shape)?;
    Ok((chunk.field(), components, Assembler::new(count)))
}

fn reject(rejected: v1::UpdateRejected) -> Result<Event, ClientError> {
    let status = rejected
        .status
        .ok_or_else(|| missing("the status of a rejection"))?;
    let refusal = Box::new(Refusal::from(&status));
    Ok(Event::Rejected {
        sequence: rejected.sequence,
        refusal,
    })
}

#[cfg(test)]
mod tests {
    use signorini_proto::array::encode;

    use super::*;

    fn finished(fields: &[v1::FieldName]) -> Response {
        let fields = fields.iter().map(|field| i32::from(*field)).collect();
        let report = Some(v1::StepReport::default());
        let finished = v1::StepFinished {
            sequence: 1,
            event: 1,
            report,
            fields,
            last: true,
            ..Default::default()
        };
        Response::StepFinished(finished)
    }

    fn chunk(field: v1::FieldName, rows: i64, offset: i64, values: &[f64], rest: Rest) -> Response {
        let chunk = v1::FieldChunk {
            sequence: 1,
            event: 1,
            field: field.into(),
            element_type: v1::ElementType::F64.into(),
            shape: vec![rows, 1],
            offset_elements: offset,
            data: encode(values),
            last: matches!(rest, Rest::Last),
        };
        Response::Field(chunk)
    }

    enum Rest {
        More,
        Last,
    }

    #[test]
    fn a_result_without_fields_is_complete_at_once() {
        let event = Collector::default().take(finished(&[])).unwrap();
        assert!(matches!(event, Some(Event::Increment(increment)) if increment.fields.is_empty()));
    }

    #[test]
    fn a_result_waits_for_its_fields() {
        let (gap, pressure) = (v1::FieldName::Gap, v1::FieldName::Pressure);
        let mut collector = Collector::default();
        assert_eq!(collector.take(finished(&[gap, pressure])).unwrap(), None);
        assert_eq!(
            collector
                .take(chunk(gap, 3, 0, &[1.0, 2.0], Rest::More))
                .unwrap(),
            None
        );
        assert_eq!(
            collector
                .take(chunk(gap, 3, 2, &[3.0], Rest::Last))
                .unwrap(),
            None
        );
        let event = collector
            .take(chunk(pressure, 1, 0, &[4.0], Rest::Last))
            .unwrap();
        let Some(Event::Increment(increment)) = event else {
            unreachable!()
        };
        assert_eq!(
            increment.fields[0],
            Field {
                name: gap,
                components: 1,
                values: vec![1.0, 2.0, 3.0]
            }
        );
        assert_eq!(increment.fields[1].values, [4.0]);
    }

    #[test]
    fn chunks_out_of_place_break_the_protocol() {
        let (gap, pressure) = (v1::FieldName::Gap, v1::FieldName::Pressure);
        let mut collector = Collector::default();
        assert!(
            collector
                .take(chunk(gap, 1, 0, &[1.0], Rest::Last))
                .is_err()
        );
        collector.take(finished(&[gap])).unwrap();
        assert!(
            collector
                .take(chunk(pressure, 1, 0, &[1.0], Rest::Last))
                .is_err()
        );
        assert!(
            collector
                .take(chunk(gap, 2, 0, &[1.0], Rest::Last))
                .is_err()
        );
    }

    #[test]
    fn a_result_before_the_fields_of_the_last_breaks_the_protocol() {
        let mut collector = Collector::default();
        collector.take(finished(&[v1::FieldName::Gap])).unwrap();
        assert!(collector.take(finished(&[])).is_err());
    }
}
