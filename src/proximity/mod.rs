//! Is a tool in the body, at it, or does it pass through?
//!
//! | file | question |
//! |---|---|
//! | [`points`] | how near are points of the body at rest, before anything is solved |
//! | [`faces`] | how near are the faces that may be touched, between their nodes as well |
//! | [`cells`] | how deep does it lie inside cells, where no face feels it |
//! | [`path`] | how far does it move, and which poses on its path are far enough apart |
//!
//! All answers rest on one bound: a distance changes by no more than what moves. Lengths are those
//! of the scaled body; distances are signed, negative inside the tool.

pub mod cells;
pub mod faces;
pub mod path;
pub mod points;
