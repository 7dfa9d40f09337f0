//! Contact of the body's surface with rigid obstacles: the weighted gap
//! g_i = int psi_i d(x + u) dS over the undeformed surface, its derivative, and
//! the resultants of the contact pressure lambda = sum Lam_i psi_i.
//!
//! psi_i are the functions of a [`ContactBasis`], one multiplier per obstacle and
//! node that carries one: P1 hats at the vertices, or quadratic Bernstein polynomials
//! at all nodes; never nodal P2 functions, whose vertex functions have zero mean on a
//! quadratic face. d > 0 outside the obstacle.

mod admitted;
mod advancing;
pub mod area_change;
mod area_element;
pub mod basis;
mod closing;
mod counterpart;
pub mod curvature;
mod deformed;
mod deformed_area;
mod edge;
mod extent;
mod face;
pub mod gap;
mod incidence;
mod intervals;
pub mod layout;
mod node_gaps;
pub mod patches;
mod path;
mod point_values;
mod portion;
pub(crate) mod quadratic_face;
pub mod resultant;
pub(crate) mod shares;
pub mod smooth;
mod stretches;
pub mod surface;
pub mod surface_metric;

pub use admitted::AdmittedDepth;
pub use advancing::Advancing;
pub use basis::ContactBasis;
pub use closing::{Closing, closing};
pub use counterpart::{Counterpart, Guide, Places};
pub use curvature::{curvature, curvature_where_held, traction_change};
pub use deformed::{Deformed, Measure};
pub use extent::{ContactExtent, extent, pressed};
pub use face::ContactFace;
pub use gap::{Linearisation, area_rows, evaluate_gaps, linearise, linearise_advanced};
pub use intervals::ContactInterval;
pub use path::{PathPoint, path};
pub use point_values::{FaceFields, values_at_points};
pub use resultant::{Acting, Resultant, resultant};
pub use surface::ContactSurface;

#[cfg(test)]
mod tests;
