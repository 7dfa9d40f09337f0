//! placeholder
pub mod manufactured;
pub mod quadrature;
