//! What holds on one element: quadrature, analytic fields, curved edges, bounds on the Jacobian.

pub mod curved_cell;
pub mod jacobian;
pub mod manufactured;
pub mod quadrature;
