//! What a session tells about itself.

use std::time::SystemTime;

use signorini::Reuse;
use signorini_proto::v1 as wire;
use tokio::time::Instant;

use super::memory::lock;
use super::{Actor, Place};
use crate::convert::{mesh, wide};
use crate::fault::Fault;
use crate::fault::status;
use crate::session::glance::{Glance, Latest, Runs};
use crate::session::handle::{ReadAnswer, ReadRequest};
use crate::session::queue::Accepted;

impl Actor {
    pub(super) fn read(&self, request: &ReadRequest) -> Result<ReadAnswer, Fault> {
        let sequence = request.sequence;
        let first = self.kept.first_sequence();
        if sequence >= 1 && sequence < first {
            return Err(Fault::SequenceNotRetained { sequence, first });
        }
        let mut results = self.kept.of_sequence(sequence);
        results.retain(|result| [0, result.report.increment].contains(&request.increment));
        if results.is_empty() {
            let name = self.spec.name.clone();
            return Err(Fault::StepNotFound { name, sequence });
        }
        let output = self.spec.output.fields.clone();
        Ok(ReadAnswer { results, output })
    }

    pub(super) fn describe(&self) -> wire::Session {
        let expire = SystemTime::now() + (self.expires - Instant::now());
        let shared = self.prepared.as_ref();
        wire::Session {
            name: self.spec.name.clone(),
            state: self.state().into(),
            scene_name: self.spec.plan_report.name.clone(),
            mesh: mesh::name(self.spec.mesh.value().id()),
            create_time: Some(self.spec.created.into()),
            expire_time: Some(expire.into()),
            last_accepted_sequence: self.queue.durably_accepted(self.log.durable),
            last_finished_sequence: self.shown_finished(),
            first_retained_sequence: self.kept.first_sequence(),
            attached: self.writer.is_some(),
            memory_bytes: wide(lock(&self.spec.reservation).bytes()),
            prepared_memory_bytes: shared.map_or(0, |(lease, _)| wide(lease.value().bytes())),
            prepared_reused: shared.is_some_and(|(_, reuse)| *reuse == Reuse::Reused),
            plan: Some(self.spec.plan_report.clone()),
            failure: self.failure().map(|fault| status::rpc_status(&fault)),
            // Answered where it is asked for: it may be large.
            scene: None,
            watcher_count: i32::try_from(self.watchers.len()).unwrap_or(i32::MAX),
        }
    }

    pub(super) fn glance(&self) -> Glance {
        Glance {
            session: wire::Session {
                plan: None,
                ..self.describe()
            },
            waiting: self.queue.len().saturating_sub(1),
            runs: self.queue.first().map(|one| self.runs(one)),
            latest: self.last_report.as_ref().map(Latest::of),
        }
    }

    fn runs(&self, update: &Accepted) -> Runs {
        let newest = self.iterations.newest();
        Runs {
            sequence: update.sequence,
            increments: update.step.increments,
            done: update.results,
            iteration: (newest.sequence == update.sequence).then_some(newest.report),
        }
    }

    /// The largest finished sequence of which every result is shown.
    fn shown_finished(&self) -> i64 {
        let hidden = self.kept.first_hidden();
        hidden.map_or(self.last_finished, |one| one.sequence - 1)
    }

    pub(super) fn failure(&self) -> Option<Fault> {
        let Place::Lost(loss) = &self.place else {
            return None;
        };
        Some(Fault::SessionFailed {
            name: self.spec.name.clone(),
            why: loss.why.clone(),
            cause: loss.cause,
        })
    }

    pub(super) fn state(&self) -> wire::SessionState {
        match &self.place {
            Place::Preparing => wire::SessionState::Preparing,
            Place::Lost(_) => wire::SessionState::Failed,
            Place::Home(_) | Place::Away(_) | Place::Behind if self.queue.is_empty() => {
                wire::SessionState::Active
            }
            Place::Home(_) | Place::Away(_) | Place::Behind => wire::SessionState::Running,
        }
    }

    pub(super) fn show(&self) {
        let now = (self.state(), self.queue.current_sequence());
        self.pulse
            .send_if_modified(|pulse| std::mem::replace(pulse, now) != now);
    }
}
