//! From a state to what callers read of it, in their units: the report of an
//! increment, fields, error norms and estimates.
//!
//! Nothing here changes a state, and nothing here is read by the solver but the estimate
//! of the error, which the tolerance `discretisation` asks for. Cost: some passes over
//! cells and faces for a report, one for a field.

pub(crate) mod coarse_turn;
pub(crate) mod coarse_volume;
pub(crate) mod contact_alone;
mod digits;
pub(crate) mod errors;
pub(crate) mod estimate;
pub(crate) mod exerted;
pub(crate) mod fields;
pub(crate) mod finite_strain;
pub(crate) mod fluids;
pub(crate) mod friction;
pub(crate) mod geometry_error;
pub(crate) mod nodal_force;
pub(crate) mod passage;
mod reactions;
pub(crate) mod step;
mod ties;
pub(crate) mod touch;
pub(crate) mod touching;
pub(crate) mod warnings;
