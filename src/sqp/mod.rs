//! Equilibrium under one drive by sequential quadratic programs: the gap is linearised, the
//! inequality problem solved inexactly, the step accepted by a filter, until all four criteria
//! hold.
//!
//! ```text
//! f - A u - B^T p - C(u)^T l = 0,   B u - S p = 0,   g(u) >= 0, l >= 0, l g(u) = 0
//! ```
//!
//! | file | part |
//! |---|---|
//! | [`run`], [`watch`] | everything that one increment reads and changes, who follows it |
//! | [`increment`] | programs until the four criteria hold: [`predictor`], [`left_tools`], [`program`], [`search`], [`verdict`], measured by [`scales`] |
//! | [`accuracy`] | how far residuals are reduced |
//! | [`proximal_flow`], [`proximal_rest`] | a sequence of equilibria, each held back to the one before |
//! | [`condensation`] | linear bodies whose response at the contact surface is known: a small problem instead of programs |
//! | [`contact_metric`], [`volumes`] | what the programs know of the compliance of surface and volume |
//! | [`factored_body`], [`near_compliance`] | the same by a factor of the body, once that is cheaper |
//! | [`learned`] | what is kept for the next increment: [`trend`], [`lowest_mode`], [`push_stiffness`], [`preconditioner_refresh`], [`saddle_layout`] |
//!
//! Above it: [`crate::force_control`], [`crate::stability`], [`crate::diagnosis`] and, over all of
//! them, [`crate::continuation`], which alone decides what follows a failure.
//!
//! Everything is non-dimensional inside.

pub(crate) mod accuracy;
pub(crate) mod chooser;
pub(crate) mod condensation;
pub(crate) mod contact_metric;
mod factored_body;
pub(crate) mod fields;
pub(crate) mod increment;
mod known_duals;
pub(crate) mod learned;
mod left_tools;
pub(crate) mod linear;
pub(crate) mod lowest_mode;
mod near_compliance;
mod preconditioner_refresh;
mod predictor;
pub(crate) mod program;
pub(crate) mod proximal_flow;
mod proximal_rest;
pub(crate) mod push_stiffness;
mod rigid_predictor;
pub(crate) mod run;
mod saddle_layout;
mod scales;
mod search;
pub(crate) mod trend;
pub(crate) mod verdict;
pub(crate) mod volumes;
pub(crate) mod watch;

/// The numeric constants of this room.
pub(crate) fn constants() -> Vec<crate::constants::Constant> {
    [
        accuracy::own_constants(),
        condensation::constants(),
        condensation::contact_alone::own_constants(),
        contact_metric::own_constants(),
        increment::own_constants(),
        known_duals::own_constants(),
        near_compliance::own_constants(),
        preconditioner_refresh::own_constants(),
        predictor::own_constants(),
        program::constants(),
        proximal_rest::own_constants(),
        push_stiffness::own_constants(),
        rigid_predictor::own_constants(),
        run::own_constants(),
        scales::own_constants(),
        search::own_constants(),
        trend::own_constants(),
        verdict::own_constants(),
    ]
    .concat()
}
