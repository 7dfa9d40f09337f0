//! The outer loop: an increment in parts with cut-back; in each part the gap is
//! linearised, the inequality problem solved inexactly, the step accepted by a filter,
//! until all four criteria hold.
//!
//! ```text
//! f - A u - B^T p - C(u)^T l = 0,   B u - S p = 0,   g(u) >= 0, l >= 0, l g(u) = 0
//! ```
//!
//! | file | station |
//! |---|---|
//! | [`run`] | everything that one increment reads and changes |
//! | [`approach`] | the way to the increment's end, in parts: [`step_control`], [`initial_penetration`], [`passing`], [`penalty`] |
//! | [`attempt`] | one part, solved and judged |
//! | [`balance`] | the poses of pushed obstacles: [`push_stiffness`] |
//! | [`accuracy`] | how far residuals are reduced |
//! | [`increment`] | programs until the four criteria hold: [`predictor`], [`left_tools`], [`program`], [`search`], [`verdict`], measured by [`scales`] |
//! | [`response`] | linear bodies whose response at the contact surface is known: a small problem instead of programs |
//! | [`viscous`] | a body that contact alone holds, brought to rest slowly where programs throw it away |
//! | [`certificate`] | whether the equilibrium is a minimum |
//! | [`descent`] | down the energy where an equilibrium is lost |
//! | [`diagnosis`], [`enclosure`], [`site`] | causes that only the end shows, and where they lie |
//! | [`contact_metric`], [`volumes`] | what the programs know of the compliance of surface and volume |
//! | [`factored_body`], [`near_compliance`] | the same by a factor of the body, once that is cheaper |
//! | [`learned`] | what is kept for the next increment: [`trend`], [`lowest_mode`], [`preconditioner_refresh`], [`saddle_layout`] |
//!
//! Everything is non-dimensional inside.

mod accuracy;
pub(crate) mod approach;
mod attempt;
mod balance;
mod certificate;
pub(crate) mod chooser;
pub(crate) mod contact_metric;
mod descent;
mod diagnosis;
mod enclosure;
mod factored_body;
pub(crate) mod increment;
mod initial_penetration;
pub(crate) mod learned;
mod left_tools;
pub(crate) mod linear;
mod lowest_mode;
mod near_compliance;
mod passing;
mod penalty;
mod preconditioner_refresh;
mod predictor;
pub(crate) mod program;
mod push_stiffness;
pub(crate) mod response;
mod rigid_predictor;
pub(crate) mod run;
mod saddle_layout;
mod scales;
mod search;
pub(crate) mod site;
mod step_control;
mod trend;
mod uniqueness;
pub(crate) mod verdict;
mod viscous;
mod volumes;
pub(crate) mod watch;
