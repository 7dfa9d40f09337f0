//! The one stream that writes to a session: it comes, goes and ends.

use std::sync::{Arc, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use signorini_proto::v1::{self as wire, solve_response::Message};

use super::{Actor, Writer};
use crate::fault::Fault;
use crate::outbox::{End, Outbox};
use crate::session::handle::{Attachment, OpenRequest};

impl Actor {
    pub(super) fn attach(&mut self, request: OpenRequest) -> Result<Attachment, Fault> {
        if let Some(writer) = &self.writer {
            let held_since = unix_seconds(writer.since);
            let name = self.seed.name.clone();
            return Err(Fault::SessionBusy { name, held_since });
        }
        self.writers += 1;
        let outbox = Outbox::new(request.max_unread_bytes, &self.shop.metrics);
        let fields = match request.fields.is_empty() {
            true => self.seed.output.fields.clone(),
            false => request.fields,
        };
        self.shop.metrics.stream_opened();
        self.writer = Some(Writer {
            number: self.writers,
            outbox: Arc::clone(&outbox),
            since: SystemTime::now(),
            fields,
            encoding: request.encoding,
            on_disconnect: request.on_disconnect,
            half_closed: false,
            sent: 0,
        });
        outbox.push(Message::Opened(wire::Opened {
            session: Some(self.describe()),
            max_in_flight: i32::try_from(self.shop.config.maximum_in_flight).unwrap_or(i32::MAX),
            last_event: self.last_event,
        }));
        if let Some(seen) = request.last_seen_event {
            for result in self.kept.after(seen) {
                self.send_result(&result);
            }
        }
        self.subscribe(Some(Arc::clone(&outbox)));
        Ok(Attachment {
            writer: self.writers,
            outbox,
            pulse: self.pulse.subscribe(),
        })
    }

    pub(super) fn detach(&mut self, number: u64) {
        let Some(writer) = self.writer.take_if(|writer| writer.number == number) else {
            return;
        };
        self.subscribe(None);
        self.shop.metrics.stream_closed();
        match writer.on_disconnect {
            wire::DisconnectPolicy::CancelStep => {
                self.queue.keep_current();
                self.cancel(0);
            }
            wire::DisconnectPolicy::Unspecified | wire::DisconnectPolicy::FinishStep => {}
        }
    }

    pub(super) fn subscribe(&self, outbox: Option<Arc<Outbox>>) {
        *self
            .subscriber
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = outbox;
    }

    pub(super) fn writer_of(&mut self, number: u64) -> Option<&mut Writer> {
        self.writer
            .as_mut()
            .filter(|writer| writer.number == number)
    }

    pub(super) fn end_finished_stream(&self) {
        if let Some(writer) = self.writer.as_ref().filter(|writer| writer.half_closed) {
            writer.outbox.end(End::Done);
        }
    }
}

fn unix_seconds(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_secs())
}
