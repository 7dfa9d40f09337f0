//! Parts of vectors that supports hold. Cost: one pass over what is held.

use crate::linalg::Held;

/// Takes off what is held.
pub(crate) fn mask(held: &Held, x: &mut [f64]) {
    held.mask(x);
}

/// Euclidean norm of what is held.
pub(crate) fn norm_of(held: &Held, x: &[f64]) -> f64 {
    held.square(x).sqrt()
}
