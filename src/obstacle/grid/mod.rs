//! Tools given by numbers on a regular grid: signed distances in space, or heights over a plane.
//!
//! ```text
//! F(x) = s(x)  or  z - h(x, y),   s, h = sum_i c_i prod_k b(x_k / spacing_k - i_k)
//! foot y of x:   F(y) = 0,   x - y = m grad F(y)
//! d = m |grad F|,   n = grad F / |grad F|,   H = T B (I + d B)^-1 T^T,   B = T^T hess F T / |grad F|
//! ```
//!
//! b is the cubic B-spline, the c_i those that meet the numbers at the nodes, without a knot
//! beside the ends (De Boor, A Practical Guide to Splines, IV): s and h have continuous second
//! derivatives and an error of the fourth order up to the border. Not F is taken as the
//! distance but that of the surface F = 0 itself, by Newton's method from the place that F
//! points to; F need be a distance to first order near zero only. T are two tangents at the
//! foot. Cost: some evaluations of 64 (16) coefficients a point; making one, a pass over the
//! nodes an axis.

mod checks;
mod distance;
mod error;
mod foot;
mod height;
mod lattice;
mod spline;
mod tool;

pub use distance::DistanceGrid;
pub use error::GridError;
pub use height::HeightField;
pub use lattice::{Lattice, MOST_NODES};
pub use tool::Sampled;

#[cfg(test)]
mod refusals;
#[cfg(test)]
mod tests;
