//! A disk that loses power: what was not waited for comes partly, torn or not at all.

use std::sync::{Arc, Mutex};

use bytes::Bytes;
use redb::StorageBackend;

use super::*;

/// A disk: what is safe, and what was written since.
#[derive(Debug, Default)]
struct Disk {
    safe: Vec<u8>,
    now: Vec<u8>,
    written: Vec<Written>,
    /// Operations until the power goes.
    left: usize,
}

#[derive(Clone, Debug)]
enum Written {
    Bytes(usize, Vec<u8>),
    Length(usize),
}

impl Disk {
    fn works(&mut self) -> std::io::Result<()> {
        if self.left == 0 {
            return Err(std::io::Error::other("no power"));
        }
        self.left -= 1;
        Ok(())
    }

    /// What is found when the power is back: of the last writes some came, some were
    /// torn, in no order.
    fn found(&self, random: &mut fastrand::Rng) -> Vec<u8> {
        let mut bytes = self.safe.clone();
        let mut written = self.written.clone();
        random.shuffle(&mut written);
        for one in written {
            match one {
                Written::Length(length) if random.bool() => bytes.resize(length, 0),
                Written::Bytes(at, data) if random.bool() => {
                    // Sectors are whole, but not all of a write.
                    let torn = data.len() / 512 * 512;
                    let sectors = random.usize(..=torn / 512) * 512;
                    let came = if random.bool() { data.len() } else { sectors };
                    let end = (at + came).min(bytes.len());
                    if at < end {
                        bytes[at..end].copy_from_slice(&data[..end - at]);
                    }
                }
                Written::Length(_) | Written::Bytes(..) => {}
            }
        }
        bytes
    }
}

#[derive(Clone, Debug)]
struct Drive(Arc<Mutex<Disk>>);

impl Drive {
    fn with(bytes: Vec<u8>, left: usize) -> Self {
        Self(Arc::new(Mutex::new(Disk {
            safe: bytes.clone(),
            now: bytes,
            written: Vec::new(),
            left,
        })))
    }

    fn open(&self) -> Database {
        Database::builder()
            .create_with_backend(self.clone())
            .unwrap()
    }
}

impl StorageBackend for Drive {
    fn len(&self) -> std::io::Result<u64> {
        Ok(self.0.lock().unwrap().now.len() as u64)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> std::io::Result<()> {
        let disk = self.0.lock().unwrap();
        let at = offset as usize;
        out.copy_from_slice(&disk.now[at..at + out.len()]);
        Ok(())
    }

    fn set_len(&self, length: u64) -> std::io::Result<()> {
        let mut disk = self.0.lock().unwrap();
        disk.works()?;
        disk.now.resize(length as usize, 0);
        disk.written.push(Written::Length(length as usize));
        Ok(())
    }

    fn sync_data(&self) -> std::io::Result<()> {
        let mut disk = self.0.lock().unwrap();
        disk.works()?;
        disk.safe = disk.now.clone();
        disk.written.clear();
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> std::io::Result<()> {
        let mut disk = self.0.lock().unwrap();
        disk.works()?;
        let at = offset as usize;
        disk.now[at..at + data.len()].copy_from_slice(data);
        disk.written.push(Written::Bytes(at, data.to_vec()));
        Ok(())
    }
}

fn session() -> Change {
    Change::Session(StoredSession {
        request: Bytes::from_static(b"request"),
        ..Default::default()
    })
}

fn update(sequence: i64) -> Change {
    let stored = StoredUpdate {
        encoded: format!("update {sequence}").into_bytes().into(),
        cancelled: false,
    };
    Change::Update(sequence, stored)
}

fn result(event: i64) -> Change {
    let stored = StoredResult {
        sequence: event,
        report: vec![event as u8; 900].into(),
        last: true,
        ..Default::default()
    };
    Change::Result(event, stored, StoredFields::default())
}

fn write(database: &Database, changes: &[Change]) -> Result<usize, JournalError> {
    commit(
        database,
        changes.iter().map(|change| ("sessions/one", change)),
        Durability::Immediate,
    )
}

/// Updates and results that are found, which must be as they were written.
fn found(database: &Database) -> (i64, i64) {
    let stored = load(database, "sessions/one").unwrap().unwrap();
    for (index, (sequence, update)) in stored.updates.iter().enumerate() {
        assert_eq!(*sequence, index as i64 + 1);
        assert_eq!(update.encoded, format!("update {sequence}").into_bytes());
    }
    for (index, (event, result, _)) in stored.results.iter().enumerate() {
        assert_eq!(
            (*event, result.sequence),
            (index as i64 + 1, index as i64 + 1)
        );
        assert_eq!(result.report, vec![*event as u8; 900]);
    }
    (stored.updates.len() as i64, stored.results.len() as i64)
}

#[test]
fn a_power_cut_at_any_moment_leaves_all_that_a_commit_returned_for() {
    let mut random = fastrand::Rng::with_seed(17);
    let drive = Drive::with(Vec::new(), usize::MAX);
    let database = drive.open();
    make_tables(&database).unwrap();
    write(&database, &[session()]).unwrap();
    drop(database);
    let mut bytes = drive.0.lock().unwrap().now.clone();
    let mut safe = 0;
    for cut in 0..300 {
        let drive = Drive::with(bytes, random.usize(1..60));
        let opened = Database::builder().create_with_backend(drive.clone());
        if let Ok(database) = opened {
            for next in safe + 1.. {
                match write(&database, &[update(next), result(next)]) {
                    Ok(_) => safe = next,
                    Err(_) => break,
                }
            }
            drop(database);
        }
        bytes = drive.0.lock().unwrap().found(&mut random);
        let drive = Drive::with(bytes.clone(), usize::MAX);
        let (updates, results) = found(&drive.open());
        assert_eq!(updates, results, "a commit is whole");
        assert!(
            updates == safe || updates == safe + 1,
            "cut {cut}: {updates} of {safe}"
        );
        safe = updates;
        bytes = drive.0.lock().unwrap().now.clone();
    }
    assert!(safe > 300, "{safe}");
}

#[test]
fn a_checkpoint_drops_the_updates_that_lead_to_it_and_deletion_everything() {
    let drive = Drive::with(Vec::new(), usize::MAX);
    let database = drive.open();
    make_tables(&database).unwrap();
    let updates = (1..=4).map(update);
    let changes: Vec<Change> = std::iter::once(session()).chain(updates).collect();
    write(&database, &changes).unwrap();
    let left = |database: &Database| {
        let stored = load(database, "sessions/one").unwrap().unwrap();
        stored.updates.iter().map(|one| one.0).collect::<Vec<_>>()
    };
    let checkpoint = |sequence, done| {
        Change::Checkpoint(StoredCheckpoint {
            sequence,
            done,
            ..Default::default()
        })
    };
    write(&database, &[checkpoint(2, 1)]).unwrap();
    assert_eq!(left(&database), [2, 3, 4], "an update under way is needed");
    write(&database, &[checkpoint(2, 0)]).unwrap();
    assert_eq!(left(&database), [3, 4]);
    write(&database, &[Change::Withdraw(4)]).unwrap();
    assert_eq!(left(&database), [3]);
    write(&database, &[Change::Delete]).unwrap();
    assert_eq!(load(&database, "sessions/one"), Ok(None));
}
