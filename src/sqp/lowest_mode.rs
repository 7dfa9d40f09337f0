//! The softest motion of an equilibrium of rubber and its eigenvalue,
//!
//! ```text
//! K x = l P x,   B x = 0,   C_A x = 0
//! ```
//!
//! as [`super::certificate`] finds it, P = int 2 mu eps : eps, and for a body that contact
//! alone holds + int x . x in units of its length, for its rigid motions have no stiffness.
//! Shape `[displacement unknowns]`.

use crate::linalg::vector::dot;
use crate::linalg::{LinearOperator, Workspace};
use crate::model::Model;
use crate::model::held::mask;
use crate::model::proximal::mass;
use crate::report::Stability;

/// The softest motion of the last equilibrium.
#[derive(Clone, Debug)]
pub(crate) struct LowestMode {
    /// x, of unit length in P `[displacement unknowns]`.
    pub(crate) motion: Vec<f64>,
    /// The eigenvalue l of the softest motion, in units of the stiffness at rest;
    /// negative at a saddle.
    pub(crate) eigenvalue: f64,
    /// What is known of the signs of all eigenvalues.
    pub(crate) stability: Stability,
}

impl LowestMode {
    /// Bytes held.
    pub(crate) fn bytes(&self) -> u64 {
        8 * self.motion.len() as u64
    }
}

/// P x.
pub(crate) fn at_rest(model: &Model<'_>, x: &[f64], work: &mut Workspace) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    model.prepared.stiffness.apply(x, &mut product, work);
    if model.plan.is_shifted() {
        let shares = mass(model);
        let terms = product.iter_mut().zip(x.iter().zip(&shares));
        terms.for_each(|(product, (x, share))| *product += share * x);
    }
    mask(&model.prepared.held, &mut product);
    product
}

/// The length of a motion, sqrt(x.P x).
pub(crate) fn length_at_rest(model: &Model<'_>, x: &[f64], work: &mut Workspace) -> f64 {
    dot(x, &at_rest(model, x, work)).sqrt()
}
