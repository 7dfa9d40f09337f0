//! The moduli that weigh gaps and multipliers on a face besides the common weight: the same
//! gap is as many times more force where the body is stiffer.

/// Multiplies what belongs to multipliers by the moduli at them; nothing where there are
/// none.
pub(super) fn weigh(moduli: &[f64], x: &mut [f64]) {
    x.iter_mut()
        .zip(moduli)
        .for_each(|(x, modulus)| *x *= modulus);
}

/// Takes the moduli off again.
pub(super) fn unweigh(moduli: &[f64], x: &mut [f64]) {
    x.iter_mut()
        .zip(moduli)
        .for_each(|(x, modulus)| *x /= modulus);
}
