//! Factors of the assembled saddle point of a quadratic program, indefinite and symmetric:
//!
//! ```text
//! [ A - G  B^T  C^T ] [du]   [f]
//! [ B      -S       ] [dp] = [g]    on a face: rows of C that stick, l_i = 0 elsewhere
//! [ C               ] [dl]   [s]
//! ```
//!
//! The body alone, for many loads and as a preconditioner ([`BodyFactor`], [`FactorStep`]); its
//! motions of negative energy, counted ([`inertia`](fn@inertia)) and turned. Only size makes a
//! factor fail: its entries grow as n^1.4 in space.

mod body;
mod circulation;
mod inertia;
mod step;
mod system;
mod turned;

pub use body::BodyFactor;
pub use inertia::{Inertia, inertia};
pub use step::FactorStep;
pub use system::Matrices;

#[cfg(test)]
mod body_tests;
#[cfg(test)]
mod tests;
