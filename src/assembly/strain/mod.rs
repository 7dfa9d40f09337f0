//! Finite strain on the blocks of a grid, matrix-free:
//!
//! ```text
//! f(u, p) = int (dW/dF - p cof F) : grad v,   c(u) = -int q (J - 1),   F = I + grad u
//! A = d2W/dF2 - p d(cof F)/dF,   B = -int q cof F : grad v
//! ```
//!
//! On a straight-sided P2 element grad u is linear, so that its values G_j at the
//! vertices are all there is: grad u = sum_j lambda_j G_j at any point, and forces
//! follow from the moments T_j = sum_q w lambda_j P. A rule of any degree fits
//! between the two. What is linearised about are the G_j, the pressures and
//! J^(-1/3) at the points: 380 bytes per tetrahedron with four points; stresses and
//! tangents are computed anew in every product in space, once a state in the plane; the smoother of
//! an inverse about a state takes one tangent a cell (`single`). Laws by point are
//! taken lane by lane; they leave their tangent at the points too, 360 bytes each.
//! About an axis the stretch around it is kept at each point too.
//!
//! [`StrainGrid::penalised`] adds s mu / 2 int (J - 1 + p / K)^2 to the energy, p / K
//! being the mean of 1 - J that the pressures see: nothing in the exact solution, and
//! what keeps the pair from moving volume where its pressures do not look (the energy
//! loses convexity there once p is some mu; Auricchio et al., Comput. Mech. 52, 2013).
//!
//! Curved edges bend the cells without stress (`bend`); their gradients are no longer linear, but
//! those on the straight cell are.
//!
//! Vectors are hierarchical or Lagrange like those of the linear passes. Cost of a
//! product with the tangent: some 2000 products per tetrahedron with four points,
//! six (scalars) to twelve (wide vectors) times the linear one (decision 20).

mod batch_pass;
mod bend;
mod by_point;
mod cell_tangents;
mod cells;
mod kernel;
mod laws;
mod linear;
mod operator;
mod pass;
mod points;
mod products;
mod response;
mod ring;
mod single;
mod stored;
mod tangent;

pub(super) use bend::Curve;
pub use cell_tangents::{CellStates, CellTangents};
pub use cells::{CellLaws, Linearised, StrainGrid};
pub use linear::CURVED_DEGREE;
pub(super) use linear::{PointPass, Terms};
pub use operator::{TangentBody, TangentDivergence, TangentStiffness};
pub use pass::Mixed;
pub use products::TangentProducts;
pub use response::Response;
pub use single::SingleTangent;
pub use tangent::{StiffnessTerm, TangentAt};
