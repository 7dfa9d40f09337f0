//! The heap of a fuzzing binary: counted, and limited for good.

use std::alloc::System;
use std::sync::{Mutex, MutexGuard, PoisonError};

use cap::Cap;

/// Stops the process; a finding below is told with its input by [`Budget::check`].
const HARD_LIMIT: usize = 4 << 30;

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, HARD_LIMIT);

/// Campaigns of one program take turns: the heap is counted for all of it.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// What the cases of a campaign may hold beyond what was held at its start.
pub(crate) struct Budget {
    start: usize,
    allowance: usize,
    _alone: MutexGuard<'static, ()>,
}

impl Budget {
    /// Waits until no other campaign is under way.
    pub(crate) fn of_mebibytes(allowance: usize) -> Self {
        // A campaign that failed has told so.
        let alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        Self {
            start: HEAP.allocated(),
            allowance: allowance << 20,
            _alone: alone,
        }
    }

    /// Fails when any moment since the start of the process was beyond the budget.
    pub(crate) fn check(&self) {
        self.check_for(String::new);
    }

    /// As [`Budget::check`]; `case` tells what was tried.
    pub(crate) fn check_for(&self, case: impl FnOnce() -> String) {
        let peak = HEAP.max_allocated().saturating_sub(self.start);
        assert!(
            peak <= self.allowance,
            "the heap grew by {peak} bytes; the budget is {} bytes {}",
            self.allowance,
            case()
        );
    }
}
