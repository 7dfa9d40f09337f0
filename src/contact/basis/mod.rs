//! The functions psi_k of the contact pressure on one face: lambda = sum Lam_k psi_k.
//!
//! A basis is positive and sums to one on every face; function k belongs to node k
//! of the face (corners, then edges (0,1), (0,2), (1,2)), so that faces with a node
//! in common share its multiplier. All integrals are over the undeformed face.
//! Reference: Wohlmuth, Acta Numerica 20 (2011), on multiplier spaces of contact.

mod bernstein;
mod hats;

use std::fmt;

pub use bernstein::Bernstein;
pub use hats::Hats;

use super::face::ContactFace;

/// Multiplier functions of a face. Two are there: [`Hats`] and [`Bernstein`].
pub trait ContactBasis: fmt::Debug + Send + Sync {
    /// Number of functions on a face with that many corners.
    fn functions(&self, corners: usize) -> usize;

    /// Values at the barycentric coordinates `l` `[corners]` into `out` `[functions]`.
    fn values(&self, l: &[f64], out: &mut [f64]);

    /// Values at the nodes of a face where the functions with these coefficients
    /// `[functions]` can be largest.
    fn at_nodes(&self, corners: usize, coefficients: &[f64]) -> Vec<f64>;

    /// The largest value on a face of the functions with these coefficients `[functions]`, not
    /// negative, and its barycentric coordinates `[3]`.
    fn largest(&self, corners: usize, coefficients: &[f64]) -> (f64, [f64; 3]);

    /// int psi_k dS, an area.
    fn weight(&self, face: &ContactFace, k: usize) -> f64;

    /// int psi_i psi_j dS, an area; about an axis at the mean radius.
    fn mass(&self, face: &ContactFace, i: usize, j: usize) -> f64;

    /// int grad psi_i . grad psi_j dS along the face, from `hats(a, b)`, the same of
    /// the barycentric coordinates of two corners.
    fn laplacian(
        &self,
        corners: usize,
        hats: &dyn Fn(usize, usize) -> f64,
        pair: [usize; 2],
    ) -> f64;
}

#[cfg(test)]
mod tests;
