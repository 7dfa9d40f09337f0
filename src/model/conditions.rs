//! What an equilibrium shall meet, fixed while it is sought: whoever wants other conditions makes
//! a run of its own under them, which ends with it.

use std::sync::Arc;

use super::friction::SlipStart;
use super::proximal::Proximal;

/// The conditions of one solve. Cheap to clone.
#[derive(Clone)]
pub(crate) struct Conditions {
    /// Bound on all four residuals: that of the scene, or a looser one on the way.
    pub(crate) tolerance: f64,
    /// Quadratic programs that may be taken.
    pub(crate) programs: u32,
    /// The proximal term; none but for the steps of a proximal flow.
    pub(crate) proximal: Option<Proximal>,
    /// Depths by which a body may still penetrate obstacles that it started in, before this part
    /// of the increment and by now `[2][multipliers]`, in units of the scaled body; empty without.
    pub(crate) admitted_penetration: [Arc<[f64]>; 2],
    /// Where the increment began, from where slip counts; none without friction.
    pub(crate) slip_start: Option<Arc<SlipStart>>,
}

impl Conditions {
    /// Equilibrium to `tolerance`, with nothing admitted.
    pub(crate) fn to(tolerance: f64) -> Self {
        Self {
            tolerance,
            programs: MOST_PROGRAMS,
            proximal: None,
            admitted_penetration: Default::default(),
            slip_start: None,
        }
    }
}

/// Quadratic programs that one solve may take.
pub(crate) const MOST_PROGRAMS: u32 = 40;
