//! `fsck`: whether a data folder holds what a server can go on from.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

use prost::Message as _;
use signorini_proto::v1 as wire;

use crate::convert::{mesh, surface};
use crate::data::states::{self, State};
use crate::journal::{JournalError, Stored, inspect};
use crate::session::Recovered;

/// What a data folder holds, and every fault of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fsck {
    /// Sessions that can be read.
    pub sessions: usize,
    /// Their accepted updates that a replay may need.
    pub updates: usize,
    /// Their kept results.
    pub results: usize,
    /// Meshes that can be read.
    pub meshes: usize,
    /// Surfaces of tools that can be read.
    pub surfaces: usize,
    /// Imported states that can be read.
    pub states: usize,
    /// Bytes of everything.
    pub bytes: u64,
    /// What a server cannot go on from, each with its name.
    pub faults: Vec<String>,
}

impl fmt::Display for Fsck {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            formatter,
            "{} sessions with {} updates and {} results, {} meshes, {} tools, {} states, {} bytes",
            self.sessions,
            self.updates,
            self.results,
            self.meshes,
            self.surfaces,
            self.states,
            self.bytes
        )?;
        for fault in &self.faults {
            writeln!(formatter, "fault: {fault}")?;
        }
        Ok(())
    }
}

/// Looks at a data folder that no server uses.
///
/// # Errors
/// [`JournalError`] for a folder that is none, is in use, or cannot be opened.
pub fn fsck(folder: &Path) -> Result<Fsck, JournalError> {
    let found = inspect(folder)?;
    let mut report = Fsck {
        bytes: found.bytes,
        ..Fsck::default()
    };
    if !found.is_sound {
        report.fault("the database", &"a page was not as it was written");
    }
    let [meshes, files_of_states, surfaces] = found.files;
    let mut known = BTreeSet::new();
    for file in &meshes {
        known.extend(report.mesh(file));
    }
    for file in &surfaces {
        known.extend(report.surface(file));
    }
    for file in &files_of_states {
        report.state(file);
    }
    for name in found.meshes.into_iter().chain(found.surfaces) {
        if !known.contains(&name) {
            report.fault(&name, &"its file is missing or faulty");
        }
    }
    let is_there = |digest: &str| files_of_states.iter().any(|file| file_name(file) == digest);
    for digest in found.states.iter().filter(|digest| !is_there(digest)) {
        report.fault(&states::name(digest), &"its file is missing");
    }
    for (name, stored) in found.sessions {
        match stored {
            Ok(stored) => report.session(&name, stored, &known),
            Err(error) => report.fault(&name, &error),
        }
    }
    Ok(report)
}

impl Fsck {
    fn fault(&mut self, name: &str, why: &dyn fmt::Display) {
        self.faults.push(format!("{name}: {why}"));
    }

    /// A mesh file; its name where it holds what it is named by.
    fn mesh(&mut self, file: &Path) -> Option<String> {
        let named = mesh_name(file);
        let read = std::fs::read(file).map_err(|error| error.to_string());
        let read = read.and_then(|bytes| mesh::from_file(&bytes).map_err(|why| why.to_string()));
        match read {
            Ok(mesh) if mesh::name(mesh.id()) == named => {
                self.meshes += 1;
                return Some(named);
            }
            Ok(_) => self.fault(&named, &"its file holds another mesh"),
            Err(why) => self.fault(&named, &why),
        }
        None
    }

    /// The file of a surface; its name where it holds what it is named by.
    fn surface(&mut self, file: &Path) -> Option<String> {
        let named = surface::name(&file_name(file));
        let read = std::fs::read(file).map_err(|error| error.to_string());
        let read = read.and_then(|bytes| surface::from_file(&bytes).map_err(|why| why.to_string()));
        match read {
            Ok((digest, _)) if surface::name(&digest) == named => {
                self.surfaces += 1;
                return Some(named);
            }
            Ok(_) => self.fault(&named, &"its file holds another surface"),
            Err(why) => self.fault(&named, &why),
        }
        None
    }

    fn state(&mut self, file: &Path) {
        let named = states::name(&file_name(file));
        match std::fs::read(file) {
            Ok(bytes) if states::name(&states::digest(&bytes)) != named => {
                self.fault(&named, &"its file is not as it was written");
            }
            Ok(bytes) => match State::from_bytes(&bytes) {
                Ok(_) => self.states += 1,
                Err(why) => self.fault(&named, &why),
            },
            Err(why) => self.fault(&named, &why),
        }
    }

    fn session(&mut self, name: &str, stored: Stored, uploads: &BTreeSet<String>) {
        if !uploads.contains(&stored.session.mesh) {
            self.fault(name, &"its mesh is missing or faulty");
        }
        match wire::CreateSessionRequest::decode(stored.session.request.clone()) {
            Ok(request) => {
                let named = surface::names(&request.scene.unwrap_or_default());
                for missing in named.iter().filter(|one| !uploads.contains(*one)) {
                    self.fault(name, &format!("its tool {missing} is missing or faulty"));
                }
            }
            Err(_) => self.fault(name, &"its request cannot be read"),
        }
        if let Some(gap) = gap(stored.updates.iter().map(|one| one.0)) {
            self.fault(name, &format!("update {gap} is missing"));
        }
        if let Some(gap) = gap(stored.results.iter().map(|one| one.0)) {
            self.fault(name, &format!("result {gap} is missing"));
        }
        self.updates += stored.updates.len();
        self.results += stored.results.len();
        match Recovered::new(name, stored) {
            Ok(_) => self.sessions += 1,
            Err(why) => self.fault(name, &why),
        }
    }
}

/// The first number that is missing between others.
fn gap(numbers: impl Iterator<Item = i64>) -> Option<i64> {
    let numbers: Vec<i64> = numbers.collect();
    let mut pairs = numbers.iter().zip(numbers.iter().skip(1));
    let broken = pairs.find(|(one, next)| **next != *one + 1);
    broken.map(|(one, _)| one + 1)
}

fn file_name(file: &Path) -> String {
    file.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn mesh_name(file: &Path) -> String {
    format!("meshes/{}", file_name(file))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use bytes::Bytes;

    use super::*;
    use crate::journal::{
        Change, Journal, StoredFields, StoredResult, StoredSession, StoredUpdate,
    };
    use crate::watch::metrics::Metrics;

    const PAGE: usize = 4096;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("signorini-{name}-{}", std::process::id()));
        // Of an earlier process of the same number.
        drop(std::fs::remove_dir_all(&folder));
        folder
    }

    /// A journal with a few sessions, and its bytes.
    async fn journal(folder: &Path) -> Vec<u8> {
        let journal = Journal::open(folder, &Metrics::new().unwrap()).unwrap();
        for number in 0..20 {
            let mut changes = vec![Change::Session(StoredSession::default())];
            for sequence in 1..10 {
                let update = StoredUpdate {
                    encoded: Bytes::from(vec![7; 300]),
                    cancelled: false,
                };
                changes.push(Change::Update(sequence, update));
                let (result, fields) = (StoredResult::default(), StoredFields::default());
                changes.push(Change::Result(sequence, result, fields));
            }
            let name = format!("sessions/one-{number}");
            journal.store(&name, changes).await.unwrap();
        }
        journal.close();
        std::fs::read(folder.join("journal.redb")).unwrap()
    }

    /// Changes bytes, a page, or the length.
    fn mutate(bytes: &mut Vec<u8>, random: &mut fastrand::Rng) {
        let is_used = |page: &usize| {
            bytes
                .chunks(PAGE)
                .nth(*page)
                .is_some_and(|all| all.iter().any(|byte| *byte != 0))
        };
        let used: Vec<usize> = (0..bytes.len() / PAGE).filter(is_used).collect();
        let page = random.choice(used).unwrap() * PAGE;
        match random.usize(..8) {
            0 => bytes.truncate(random.usize(..bytes.len())),
            1 => random.fill(&mut bytes[page..page + PAGE]),
            2 => bytes[page..page + PAGE].fill(0),
            _ => {
                for _ in 0..random.usize(1..20) {
                    bytes[page + random.usize(..PAGE)] = random.u8(..);
                }
            }
        }
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn damaged_pages_are_told_and_no_panic() {
        let folder = folder("pages");
        let whole = journal(&folder).await;
        let (metrics, mut random) = (Metrics::new().unwrap(), fastrand::Rng::with_seed(17));
        let mut refused = 0;
        for _ in 0..200 {
            let mut bytes = whole.clone();
            mutate(&mut bytes, &mut random);
            std::fs::write(folder.join("journal.redb"), &bytes).unwrap();
            let looked = fsck(&folder);
            std::fs::write(folder.join("journal.redb"), &bytes).unwrap();
            match Journal::open(&folder, &metrics) {
                Ok(journal) => journal.close(),
                Err(_) => refused += usize::from(looked.is_err()),
            }
        }
        assert!(refused > 0);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
