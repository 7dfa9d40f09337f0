//! Copies of a session in the memory of its process, to go back to: the state and what the solver
//! has learnt, so that what follows has the same bits as what followed the copy, and no bit
//! depends on whether one was made.

use super::Session;
use super::checkpoint::Checkpoint;
use crate::sqp::learned::Learned;

/// A copy of all of a session that later bits depend on.
#[derive(Debug)]
pub struct Snapshot {
    checkpoint: Checkpoint,
    learned: Learned,
}

impl Snapshot {
    /// Bytes held, what is shared with the session included.
    pub fn bytes(&self) -> u64 {
        self.checkpoint.state.bytes() + self.learned.bytes()
    }
}

impl Session {
    /// A copy between two increments. Cost: a copy of the state and of what the solver has
    /// learnt.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            checkpoint: self.checkpoint(),
            learned: self.learned.copy(),
        }
    }

    /// Goes back to where this session was copied, and on from there with the same bits as
    /// then. A step under way is forgotten, and [`Session::take_back`] has nothing to undo.
    /// Cost: as of the copy.
    pub fn go_back(&mut self, to: &Snapshot) {
        self.take_up(to.checkpoint.clone());
        self.learned.take_up(&to.learned);
        self.previous = None;
    }
}
