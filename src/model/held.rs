//! Entries of vectors that supports hold.
//!
//! Vectors are `[nodes * components]`, held entries ascending. Cost: one pass over the
//! held entries.

/// Zeroes held entries.
pub(crate) fn mask(held: &[u32], x: &mut [f64]) {
    for &index in held {
        x[index as usize] = 0.0;
    }
}

/// Euclidean norm of the held entries.
pub(crate) fn norm_of(held: &[u32], x: &[f64]) -> f64 {
    let entries = held.iter().map(|&index| x[index as usize]);
    entries.map(|value| value * value).sum::<f64>().sqrt()
}
