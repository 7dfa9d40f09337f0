//! Contact of the body's surface with rigid obstacles: the weighted gap
//! g_i = int phi_i d(x + u) dS over the undeformed surface, its derivative, and
//! the resultants of the contact pressure.
//!
//! phi_i are the P1 hats of the contact surface, one multiplier per obstacle
//! and vertex; never nodal P2 multipliers, whose vertex functions have zero
//! mean on a quadratic face. d > 0 outside the obstacle.

mod deformed_area;
pub mod gap;
pub mod resultant;
pub mod surface;
pub mod surface_metric;

pub use gap::{Linearisation, curvature, evaluate_gaps, linearise};
pub use resultant::{Resultant, resultant};
pub use surface::{ContactFace, ContactSurface};

#[cfg(test)]
mod tests;
