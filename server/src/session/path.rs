//! How a session came to its state since its solver last knew nothing: a state, and what was done
//! after it.
//!
//! The bits of what follows depend on what the solver has learnt, which does not travel. Whoever
//! does the same on the same state has learnt the same, so this is what is saved and exported,
//! and the session itself goes on as if nobody had looked.

use bytes::Bytes;

use crate::journal::{StoredSave, StoredWork};

/// What an update did to the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passage {
    /// One increment more.
    Done,
    /// It was stopped.
    Stopped,
}

/// From a state at which the solver knew nothing to the present one.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// That state; none: at rest.
    start: Option<Bytes>,
    since: Vec<StoredWork>,
    /// Update of the last entry; 0 where no further increment belongs to it.
    newest: i64,
}

impl Path {
    /// At a state, where the solver knows nothing.
    pub(super) fn at(state: Bytes) -> Self {
        Self {
            start: Some(state),
            ..Self::default()
        }
    }

    /// As saved.
    pub(super) fn of(save: &StoredSave) -> Self {
        Self {
            start: Some(save.state.clone()),
            since: save.since.clone(),
            newest: 0,
        }
    }

    /// Counts what an update did, of which `before` increments came before that.
    pub(super) fn count(
        &mut self,
        (sequence, encoded): (i64, &Bytes),
        before: u32,
        passage: Passage,
    ) {
        if self.newest != sequence || self.since.is_empty() {
            self.since.push(StoredWork {
                encoded: encoded.clone(),
                before,
                ..StoredWork::default()
            });
        }
        self.newest = sequence;
        if let Some(work) = self.since.last_mut() {
            match passage {
                Passage::Done => work.done += 1,
                Passage::Stopped => work.stopped = true,
            }
        }
    }

    /// Updates of other numbers follow.
    pub(super) fn close(&mut self) {
        self.newest = 0;
    }

    /// Goes on with what was counted elsewhere meanwhile.
    pub(super) fn append(&mut self, later: Self) {
        if !later.since.is_empty() {
            self.newest = later.newest;
            self.since.extend(later.since);
        }
    }

    /// Whether the state is known from which it leads; `state` where it is not.
    pub(super) fn start_at(&mut self, state: Bytes) {
        self.start.get_or_insert(state);
    }

    /// Whether it leads from the state at rest, which nobody has written yet.
    pub(super) fn is_from_rest(&self) -> bool {
        self.start.is_none()
    }

    /// What has to be done again.
    pub(super) fn save(&self) -> StoredSave {
        StoredSave {
            state: self.start.clone().unwrap_or_default(),
            since: self.since.clone(),
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        let start = self.start.as_ref().map_or(0, Bytes::len);
        start as u64 + since_bytes(&self.since)
    }
}

/// Bytes of what is to be done again.
pub(super) fn since_bytes(since: &[StoredWork]) -> u64 {
    since.iter().map(|work| work.encoded.len() as u64).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(path: &Path) -> Vec<(u32, u32, bool)> {
        let of = |work: &StoredWork| (work.before, work.done, work.stopped);
        path.since.iter().map(of).collect()
    }

    #[test]
    fn increments_of_one_update_are_one_entry_and_a_new_state_drops_all() {
        let update = Bytes::from_static(b"update");
        let mut path = Path::default();
        assert!(path.is_from_rest());
        for before in 0..3 {
            path.count((1, &update), before, Passage::Done);
        }
        path.count((1, &update), 3, Passage::Stopped);
        path.count((2, &update), 0, Passage::Stopped);
        assert_eq!(counts(&path), [(0, 3, true), (0, 0, true)]);
        assert_eq!(path.bytes(), 12);
        path = Path::at(Bytes::from_static(b"state"));
        path.count((3, &update), 4, Passage::Done);
        assert_eq!(counts(&path), [(4, 1, false)]);
        assert_eq!(path.bytes(), 11);
    }

    #[test]
    fn an_update_of_the_same_number_behind_a_saved_path_is_another_one() {
        let update = Bytes::from_static(b"update");
        let mut path = Path::at(Bytes::new());
        path.count((1, &update), 0, Passage::Done);
        let mut again = Path::of(&path.save());
        again.count((1, &update), 0, Passage::Done);
        assert_eq!(counts(&again), [(0, 1, false); 2]);
        let mut later = Path::default();
        later.count((2, &update), 0, Passage::Stopped);
        again.append(later);
        assert_eq!(counts(&again).len(), 3);
    }
}
