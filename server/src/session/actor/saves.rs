//! States that a client may go back to, kept in the session.

use std::collections::VecDeque;

use bytes::Bytes;

/// States that a session keeps; the oldest makes room.
const MOST_KEPT: usize = 8;

/// The kept states, oldest first.
#[derive(Default)]
pub(super) struct Saves {
    kept: VecDeque<(i64, Bytes)>,
    /// Number of the newest, kept or not.
    newest: i64,
}

impl Saves {
    /// Those of an earlier server, ascending.
    pub(super) fn new(kept: Vec<(i64, Bytes)>) -> Self {
        let newest = kept.last().map_or(0, |(number, _)| *number);
        let kept = kept.into();
        Self { kept, newest }
    }

    /// Bytes of all.
    pub(super) fn bytes(&self) -> u64 {
        let kept = self.kept.iter();
        kept.map(|(_, state)| state.len() as u64).sum()
    }

    /// Bytes of all once `state` is kept too.
    pub(super) fn bytes_with(&self, state: &Bytes) -> u64 {
        let leaves = match self.kept.front() {
            Some((_, oldest)) if self.kept.len() >= MOST_KEPT => oldest.len() as u64,
            Some(_) | None => 0,
        };
        self.bytes() - leaves + state.len() as u64
    }

    /// Keeps a state; its number.
    pub(super) fn keep(&mut self, state: Bytes) -> i64 {
        self.newest += 1;
        self.kept.push_back((self.newest, state));
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
    pub(super) fn get(&self, number: i64) -> Option<Bytes> {
        let mut kept = self.kept.iter();
        kept.find(|(own, _)| *own == number)
            .map(|(_, state)| state.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_makes_room_and_numbers_go_on() {
        let mut saves = Saves::default();
        let state = Bytes::from_static(b"state");
        for number in 1..=10 {
            let expected = saves.bytes_with(&state);
            assert_eq!(saves.keep(state.clone()), number);
            assert_eq!(saves.bytes(), expected);
        }
        assert_eq!((saves.first(), saves.bytes()), (3, 40));
        assert_eq!((saves.get(2), saves.get(3)), (None, Some(state.clone())));
        let mut later = Saves::new(vec![(7, state.clone()), (9, state.clone())]);
        assert_eq!((later.first(), later.keep(state)), (7, 10));
        assert_eq!(Saves::default().first(), 1);
    }
}
