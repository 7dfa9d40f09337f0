//! The last equilibrium of a load path, which a failed attempt goes back to.

use crate::model::state::State;
use crate::sqp::lowest_mode::LowestMode;
use crate::sqp::run::Run;

/// A state to go back to, with the softest motion of its equilibrium.
pub(crate) struct Checkpoint {
    /// The state to go back to.
    pub(super) state: State,
    /// Softest motion of its equilibrium, which belongs to the state and not to what
    /// was tried since.
    lowest_mode: Option<LowestMode>,
}

impl Checkpoint {
    /// The present one.
    pub(super) fn of(run: &Run<'_>) -> Self {
        Self {
            state: run.state.clone(),
            lowest_mode: run.learned.lowest_mode.clone(),
        }
    }

    /// Goes back to it.
    pub(super) fn restore(&self, run: &mut Run<'_>) {
        run.state.clone_from(&self.state);
        run.learned.lowest_mode.clone_from(&self.lowest_mode);
    }
}
