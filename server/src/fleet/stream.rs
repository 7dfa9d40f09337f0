//! The stream of records: what each session was asked and did, one subject a session.
//!
//! Every record says which one it follows: who follows another one than the last is refused. A
//! record whose answer is lost is sent again under the same name and stored once. Large records lie
//! in the shared folder, named by their digest, and the stream names them. Where the records after
//! the last whole one are several times its size, a whole one replaces them.

use std::path::{Path, PathBuf};
use std::time::Duration;

use async_nats::jetstream::context::{CreateStreamError, CreateStreamErrorKind, PublishErrorKind};
use async_nats::jetstream::message::PublishMessage;
use async_nats::jetstream::stream::{self, LastRawMessageErrorKind};
use async_nats::jetstream::{self, Context};
use bytes::Bytes;
use prost::Message;
use sha2::{Digest as _, Sha256};

const STREAM: &str = "SIGNORINI-SESSIONS";
const SUBJECTS: &str = "signorini.sessions";
/// Larger records are files: a server of NATS takes 1 MiB.
const LARGEST: usize = 256 << 10;
/// Code of a cluster that cannot answer now.
const UNAVAILABLE: usize = 503;
/// In which a record that is sent again is known again.
const KNOWN: Duration = Duration::from_secs(120);

/// What a message of the stream holds.
#[derive(Clone, PartialEq, Message)]
struct Envelope {
    /// The changes of a session, encoded by the journal.
    #[prost(bytes = "bytes", tag = "1")]
    changes: Bytes,
    /// In place of them the file that holds them.
    #[prost(string, tag = "2")]
    file: String,
    /// Of the lease under which it was written.
    #[prost(uint64, tag = "3")]
    epoch: u64,
    /// Who has written it.
    #[prost(string, tag = "4")]
    server: String,
}

/// Why a record is not stored.
pub(super) enum Refused {
    /// Another server has written since.
    Fenced,
    /// It may be stored, or not.
    Unknown(String),
}

/// The stream.
pub(super) struct Records {
    context: Context,
    stream: stream::Stream,
    folder: PathBuf,
    server: String,
}

/// Of one record.
pub(super) struct Place<'a> {
    pub(super) id: &'a str,
    pub(super) epoch: u64,
    /// The record that it follows.
    pub(super) after: u64,
    /// Of its writer.
    pub(super) number: u64,
}

impl Place<'_> {
    /// Name of a file, in the order of the records.
    fn file(&self) -> String {
        format!("{:020}-{:020}", self.epoch, self.number)
    }
}

impl Records {
    pub(super) async fn open(
        context: &Context,
        replicas: usize,
        (store, server): (&Path, &str),
    ) -> Result<Self, async_nats::Error> {
        let config = stream::Config {
            name: STREAM.to_owned(),
            subjects: vec![format!("{SUBJECTS}.*")],
            duplicate_window: KNOWN,
            num_replicas: replicas,
            ..Default::default()
        };
        let stream = context.get_or_create_stream(config).await?;
        let folder = store.join("records");
        std::fs::create_dir_all(&folder)?;
        Ok(Self {
            context: context.clone(),
            stream,
            folder,
            server: server.to_owned(),
        })
    }

    /// Stores a record; its number in the stream.
    pub(super) async fn publish(&self, place: &Place<'_>, changes: &Bytes) -> Result<u64, Refused> {
        let unknown = |error: &dyn std::fmt::Display| Refused::Unknown(error.to_string());
        let (changes, file) = if changes.len() > LARGEST {
            (
                Bytes::new(),
                self.put(place, changes).map_err(|error| unknown(&error))?,
            )
        } else {
            (changes.clone(), String::new())
        };
        let envelope = Envelope {
            changes,
            file,
            epoch: place.epoch,
            server: self.server.clone(),
        };
        let name = format!("{}-{}-{}", place.id, place.epoch, place.number);
        let message = PublishMessage::build()
            .payload(envelope.encode_to_vec().into())
            .expected_last_subject_sequence(place.after)
            .message_id(name);
        let sent = self.context.send_publish(subject(place.id), message).await;
        let stored = match sent {
            Ok(sent) => sent.await,
            Err(error) => Err(error),
        };
        stored.map(|stored| stored.sequence).map_err(|error| {
            if error.kind() == PublishErrorKind::WrongLastSequence {
                Refused::Fenced
            } else {
                unknown(&error)
            }
        })
    }

    /// Number of the newest record of a session.
    pub(super) async fn newest(&self, id: &str) -> Result<Option<u64>, async_nats::Error> {
        match self
            .stream
            .get_last_raw_message_by_subject(&subject(id))
            .await
        {
            Ok(message) => Ok(Some(message.sequence)),
            Err(error) if error.kind() == LastRawMessageErrorKind::NoMessageFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// The changes of a session up to a record, oldest first.
    pub(super) async fn read(&self, id: &str, last: u64) -> Result<Vec<Bytes>, async_nats::Error> {
        let (subject, mut found, mut next) = (subject(id), Vec::new(), 1);
        while next <= last {
            let next_one = self.stream.raw_message_builder().sequence(next);
            let message = next_one.next_by_subject(subject.clone()).send().await?;
            next = message.sequence + 1;
            let envelope = Envelope::decode(message.payload)?;
            found.push(match envelope.file.as_str() {
                "" => envelope.changes,
                file => self.get(id, file)?,
            });
        }
        Ok(found)
    }

    /// Drops the records before `first`, and the files of those before `place`. What another
    /// server may have written since stays.
    pub(super) async fn drop_before(
        &self,
        place: &Place<'_>,
        first: u64,
    ) -> Result<(), async_nats::Error> {
        let purge = self.stream.purge().filter(subject(place.id));
        purge.sequence(first).await?;
        let (folder, before) = (self.folder.join(place.id), place.file());
        for entry in std::fs::read_dir(folder).into_iter().flatten() {
            let entry = entry?;
            if entry
                .file_name()
                .to_str()
                .is_some_and(|name| name < before.as_str())
            {
                std::fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }

    /// Writes a file of a session; its name.
    fn put(&self, place: &Place<'_>, bytes: &[u8]) -> std::io::Result<String> {
        let name = format!("{}-{}", place.file(), digest(bytes));
        let folder = self.folder.join(place.id);
        std::fs::create_dir_all(&folder)?;
        let (path, part) = (
            folder.join(&name),
            folder.join(format!("{name}.{}", std::process::id())),
        );
        std::fs::write(&part, bytes)?;
        std::fs::File::open(&part)?.sync_all()?;
        std::fs::rename(&part, path)?;
        std::fs::File::open(&folder)?.sync_all()?;
        Ok(name)
    }

    fn get(&self, id: &str, name: &str) -> Result<Bytes, async_nats::Error> {
        let is_ours = name
            .bytes()
            .all(|byte| byte.is_ascii_hexdigit() || byte == b'-');
        let bytes = if is_ours {
            std::fs::read(self.folder.join(id).join(name))?
        } else {
            Vec::new()
        };
        if name.ends_with(&digest(&bytes)) {
            Ok(bytes.into())
        } else {
            Err(format!("the file `{name}` of `{id}` is not as it was written").into())
        }
    }
}

fn subject(id: &str) -> String {
    format!("{SUBJECTS}.{id}")
}

fn digest(bytes: &[u8]) -> String {
    let digest: [u8; 32] = Sha256::digest(bytes).into();
    signorini_proto::digest::hex(&digest)
}

/// Whether a stream was not opened because nobody could say what there is: a cluster that has no
/// leader yet is silent, or says that it has none.
pub(super) fn is_unanswered(error: &async_nats::Error) -> bool {
    let error = error.downcast_ref::<CreateStreamError>();
    error.is_some_and(|error| match error.kind() {
        CreateStreamErrorKind::TimedOut => true,
        CreateStreamErrorKind::JetStream(error) => error.code() == UNAVAILABLE,
        CreateStreamErrorKind::EmptyStreamName
        | CreateStreamErrorKind::InvalidStreamName
        | CreateStreamErrorKind::DomainAndExternalSet
        | CreateStreamErrorKind::JetStreamUnavailable
        | CreateStreamErrorKind::Response
        | CreateStreamErrorKind::NotFound
        | CreateStreamErrorKind::ResponseParse => false,
    })
}

/// A context whose calls end in time for another try within a lease.
pub(super) fn context(client: async_nats::Client, ttl: Duration) -> Context {
    let mut context = jetstream::new(client);
    context.set_timeout((ttl / 6).max(Duration::from_millis(200)));
    context
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_waits_for_a_leader_and_not_for_settings_that_are_wrong() {
        let of = |kind| async_nats::Error::from(CreateStreamError::from(kind));
        let said = |code: usize| {
            let said = serde_json::json!({ "code": code, "err_code": 10008 });
            of(CreateStreamErrorKind::JetStream(
                serde_json::from_value(said).unwrap(),
            ))
        };
        assert!(is_unanswered(&of(CreateStreamErrorKind::TimedOut)));
        assert!(is_unanswered(&said(503)) && !is_unanswered(&said(400)));
        assert!(!is_unanswered(&of(
            CreateStreamErrorKind::InvalidStreamName
        )));
        assert!(!is_unanswered(&"the leases live 3 s".into()));
    }
}
