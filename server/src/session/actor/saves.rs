//! States that a client may go back to, kept in the session.

use std::collections::VecDeque;

use std::sync::Arc;

use signorini::Snapshot;

use crate::journal::StoredSave;
use crate::session::ledger::Ledger;
use crate::session::path::since_bytes;

/// States that a session keeps; the oldest makes room.
const MOST_KEPT: usize = 8;

/// A state to go back to.
#[derive(Clone, Debug, Default)]
pub(super) struct Save {
    /// What leads to it.
    pub(super) stored: StoredSave,
    /// What a replay would have to do again there; none of one that was not made here.
    pub(super) ledger: Option<Ledger>,
    /// A copy, which is there at once: of the newest, where there is memory for it.
    pub(super) copy: Option<Arc<Snapshot>>,
}

impl Save {
    /// Bytes of what leads to it.
    pub(super) fn stored_bytes(&self) -> u64 {
        self.stored.state.len() as u64 + since_bytes(&self.stored.since)
    }

    fn copy_bytes(&self) -> u64 {
        self.copy.as_ref().map_or(0, |copy| copy.bytes())
    }

    /// Bytes of all of it.
    fn bytes(&self) -> u64 {
        self.stored_bytes() + self.copy_bytes()
    }
}

/// The kept states, oldest first.
#[derive(Default)]
pub(super) struct Saves {
    kept: VecDeque<(i64, Save)>,
    /// Number of the newest, kept or not.
    newest: i64,
}

impl Saves {
    /// Those of an earlier server, ascending.
    pub(super) fn new(kept: Vec<(i64, StoredSave)>) -> Self {
        let newest = kept.last().map_or(0, |(number, _)| *number);
        let save = |stored| Save {
            stored,
            ..Save::default()
        };
        let kept = kept.into_iter();
        Self {
            kept: kept
                .map(|(number, stored)| (number, save(stored)))
                .collect(),
            newest,
        }
    }

    /// Bytes of all.
    pub(super) fn bytes(&self) -> u64 {
        self.kept.iter().map(|(_, save)| save.bytes()).sum()
    }

    /// Bytes of all once `save` is kept too.
    pub(super) fn bytes_with(&self, save: &Save) -> u64 {
        let leave = (self.kept.len() + 1).saturating_sub(MOST_KEPT);
        let stay = self.kept.iter().skip(leave);
        let others: u64 = stay.map(|(_, one)| one.stored_bytes()).sum();
        others + save.bytes()
    }

    /// Keeps a state, without the copies of those before; its number.
    pub(super) fn keep(&mut self, save: Save) -> i64 {
        for (_, earlier) in &mut self.kept {
            earlier.copy = None;
        }
        self.newest += 1;
        self.kept.push_back((self.newest, save));
        while self.kept.len() > MOST_KEPT {
            self.kept.pop_front();
        }
        self.newest
    }

    /// Number of the oldest that is kept.
    pub(super) fn first(&self) -> i64 {
        self.kept
            .front()
            .map_or(self.newest + 1, |(number, _)| *number)
    }

    /// The state of that number.
    pub(super) fn get(&self, number: i64) -> Option<&Save> {
        let mut kept = self.kept.iter();
        kept.find(|(own, _)| *own == number).map(|(_, save)| save)
    }

    /// Notes what going back to a state has shown of it.
    pub(super) fn note(&mut self, number: i64, ledger: Option<Ledger>, copy: Arc<Snapshot>) {
        let newest = self.newest;
        let mut kept = self.kept.iter_mut();
        if let Some((_, save)) = kept.find(|(own, _)| *own == number) {
            save.ledger = ledger;
            save.copy = Some(copy).filter(|_| number == newest);
        }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;
    use crate::journal::StoredWork;

    fn save() -> Save {
        let state = Bytes::from_static(b"state");
        let work = StoredWork {
            encoded: Bytes::from_static(b"work"),
            ..StoredWork::default()
        };
        let since = vec![work];
        Save {
            stored: StoredSave { state, since },
            ..Save::default()
        }
    }

    #[test]
    fn the_oldest_makes_room_and_numbers_go_on() {
        let mut saves = Saves::default();
        for number in 1..=10 {
            let expected = saves.bytes_with(&save());
            assert_eq!(saves.keep(save()), number);
            assert_eq!(saves.bytes(), expected);
        }
        assert_eq!((saves.first(), saves.bytes()), (3, 72));
        assert!(saves.get(2).is_none());
        let kept = saves.get(3).map(|one| &one.stored);
        assert_eq!(kept, Some(&save().stored));
        let mut later = Saves::new(vec![(7, save().stored), (9, save().stored)]);
        assert_eq!((later.first(), later.keep(save())), (7, 10));
        assert_eq!(Saves::default().first(), 1);
    }
}
