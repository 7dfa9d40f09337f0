//! What the report compares the solver with, and nothing else: the production path
//! `scene -> plan -> prepare -> session -> sqp -> model -> results` knows it only by
//! the functions below, which the choosers of each room call.
//!
//! A library built without the feature `comparisons` has `absent` in its place.

pub(crate) mod assembly;
mod contact;
mod element;
mod krylov;
mod linear;
pub(crate) mod precond;
mod saddle;
mod space;

/// Whether comparison methods are there.
pub(crate) const IS_BUILT: bool = true;

pub(crate) use contact::contact;
pub(crate) use element::prepared::ComparisonData;
pub(crate) use element::{body, prepared, unknowns};
pub(crate) use linear::linear;
pub(crate) use precond::{displacement, p1};
pub(crate) use saddle::block_step;
