//! What holds on one element: quadrature, analytic fields, bounds on the Jacobian.

pub mod jacobian;
pub mod manufactured;
pub mod quadrature;
