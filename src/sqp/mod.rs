//! The outer loop: load steps in increments with cut-back; in each increment
//! the gap is linearised, the inequality problem solved inexactly, the step
//! accepted by a filter, until all four criteria hold.
//!
//! ```text
//! f - A u - B^T p - C(u)^T l = 0,   B u - S p = 0,   g(u) >= 0, l >= 0, l g(u) = 0
//! ```
//!
//! Everything is non-dimensional inside; [`Session`] speaks the caller's units.

mod accuracy;
mod any_session;
mod carry;
mod comparison;
mod constraints;
mod contact_metric;
mod counters;
mod drive;
mod errors;
mod estimate;
mod evaluate;
mod fields;
mod finite_strain;
mod increment;
mod linear;
mod loads;
mod longest_step;
mod predictor;
mod pressures;
mod program;
mod results;
mod search;
mod session;
mod stability;
mod state;
mod tangent;
mod touching;
mod upkeep;
mod verification;
mod watch;

pub use any_session::Session;
pub use drive::ObstaclePose;
pub use session::{Reuse, StepRun};
