//! The streams of a session: they come, are fed, go and end.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use signorini_proto::v1::{self as wire, solve_response::Message};
use tokio::time::Instant;

use super::{Actor, Begin, Fresh, Reader, Watcher, Writer, after};
use crate::fault::Fault;
use crate::results::outbox::{Limit, Outbox, StreamEnd, Wanted};
use crate::session::handle::{Attachment, OnDisconnect, OpenRequest, Role};

/// Part of the budget that one reader may leave unread.
const UNREAD_PART: u64 = 8;

/// Results that wait for one watcher beside the kept ones.
const MOST_WATCHED: usize = 2;

impl Actor {
    pub(super) fn attach(&mut self, request: OpenRequest) -> Result<Attachment, Fault> {
        let role = request.role;
        if let (Role::Writer { .. }, Some(writer)) = (role, &self.writer) {
            let held_since = unix_seconds(writer.since);
            let name = self.spec.name.clone();
            return Err(Fault::SessionBusy { name, held_since });
        }
        let shown = self.kept.shown_event(self.last_event);
        if let Some(seen) = request.last_seen_event.filter(|seen| *seen > shown) {
            let name = self.spec.name.clone();
            return Err(Fault::EventNotFound {
                name,
                seen,
                newest: shown,
            });
        }
        let iterations = self.iterations.reader(request.iteration_interval);
        let outbox = self.new_outbox(&request);
        let start = self.kept.seen(request.last_seen_event, shown);
        let missed = match request.last_seen_event {
            Some(_) => 0,
            None => start,
        };
        let begin = Begin {
            event: start,
            missed,
            accepted: self.queue.last_accepted(),
        };
        let reader = Reader::new(Arc::clone(&outbox), begin);
        self.streams += 1;
        match role {
            Role::Writer {
                client,
                on_disconnect,
                deadline,
            } => {
                self.client = client;
                self.attach_writer(reader, on_disconnect, deadline);
            }
            Role::Watcher { until } => {
                let watcher = Watcher { reader, until };
                self.watchers.insert(self.streams, watcher);
            }
        }
        outbox.push(Message::Opened(wire::StreamOpened {
            session: Some(self.describe()),
            max_in_flight: i32::try_from(self.services.config.maximum_in_flight)
                .unwrap_or(i32::MAX),
            last_event: shown,
        }));
        self.feed(None);
        Ok(Attachment {
            number: self.streams,
            outbox,
            iterations,
            pulse: self.pulse.subscribe(),
        })
    }

    fn new_outbox(&self, request: &OpenRequest) -> Arc<Outbox> {
        let fields = if request.fields.is_empty() {
            self.spec.output.fields.clone()
        } else {
            request.fields.clone()
        };
        let encoding = request.encoding;
        let wanted = Wanted { fields, encoding };
        let limit = Limit {
            // Not more than its part of the budget, whatever the client asks for.
            bytes: request
                .max_unread_bytes
                .min(self.services.store.budget() / UNREAD_PART),
            results: match request.role {
                Role::Writer { .. } => usize::MAX,
                // The rest waits among the kept ones, where it costs nothing.
                Role::Watcher { .. } => MOST_WATCHED,
            },
        };
        Outbox::new(limit, wanted, &self.room)
    }

    fn attach_writer(
        &mut self,
        reader: Reader,
        on_disconnect: OnDisconnect,
        deadline: Option<Instant>,
    ) {
        self.fields = reader.outbox.fields().to_vec();
        self.cancels_at = None;
        let policy = match on_disconnect.policy {
            wire::DisconnectPolicy::Unspecified => self.spec.on_disconnect,
            wire::DisconnectPolicy::FinishStep | wire::DisconnectPolicy::CancelStep => {
                on_disconnect.policy
            }
        };
        self.writer = Some(Writer {
            number: self.streams,
            reader,
            since: SystemTime::now(),
            on_disconnect: OnDisconnect {
                policy,
                ..on_disconnect
            },
            deadline,
            half_closed: false,
        });
    }

    pub(super) fn detach(&mut self, number: u64) {
        self.watchers.remove(&number);
        let Some(writer) = self.writer.take_if(|writer| writer.number == number) else {
            return;
        };
        match writer.on_disconnect.policy {
            wire::DisconnectPolicy::CancelStep => {
                self.cancels_at = Some(after(writer.on_disconnect.grace));
                self.cancel_left();
            }
            wire::DisconnectPolicy::Unspecified | wire::DisconnectPolicy::FinishStep => {}
        }
    }

    /// Cancels the step whose client has not come back in time, and drops those behind it.
    pub(super) fn cancel_left(&mut self) {
        if self
            .cancels_at
            .take_if(|time| *time <= Instant::now())
            .is_some()
        {
            self.log_withdrawn(self.queue.current_sequence() + 1);
            self.queue.keep_current();
            self.cancel(0);
        }
    }

    /// Queues for every reader what it has room for.
    pub(super) fn feed(&mut self, fresh: Option<&Fresh>) {
        let kept = &self.kept;
        if let Some(writer) = &mut self.writer {
            writer.reader.feed(kept, fresh);
        }
        for watcher in self.watchers.values_mut() {
            watcher.reader.feed(kept, fresh);
        }
    }

    /// Whether nothing waits for the writer, so that a further increment may start.
    pub(super) fn writer_has_room(&mut self) -> bool {
        let (kept, writer) = (&self.kept, &mut self.writer);
        writer
            .as_mut()
            .is_none_or(|writer| writer.reader.feed(kept, None))
    }

    pub(super) fn writer_of(&mut self, number: u64) -> Option<&mut Writer> {
        self.writer
            .as_mut()
            .filter(|writer| writer.number == number)
    }

    /// Every update is answered: ends the streams that wait for no more.
    pub(super) fn end_finished_streams(&mut self) {
        let newest = self.last_event;
        let is_shown = self.kept.first_hidden().is_none();
        if self.writer_has_room()
            && is_shown
            && let Some(writer) = self.writer.as_ref().filter(|writer| writer.half_closed)
        {
            writer.reader.outbox.end(StreamEnd::Done);
        }
        for watcher in self.watchers.values() {
            let is_idle = watcher.until == wire::WatchEnd::Idle;
            if is_idle && is_shown && watcher.reader.cursor() >= newest {
                watcher.reader.outbox.end(StreamEnd::Done);
            }
        }
    }

    pub(super) fn end_streams(&mut self, why: &Fault) {
        let writer = self.writer.take().map(|writer| writer.reader);
        let watchers = std::mem::take(&mut self.watchers).into_values();
        for reader in writer.into_iter().chain(watchers.map(|one| one.reader)) {
            reader.outbox.end(StreamEnd::Fault(why.clone()));
        }
    }
}

fn unix_seconds(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_secs())
}
