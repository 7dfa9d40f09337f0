//! The way back to the admissible set, for methods whose steps may leave it.

use signorini::inequality::condensed::Condensed;
use signorini::inequality::{QpIterate, QpStatus};
use signorini::linalg::vector::largest;

/// Violations this small against the largest multiplier are rounding.
const ROUNDING: f64 = 1e-14;

/// Projects multipliers on their set; one product where there is more to it than
/// rounding. Returns whether there was.
///
/// # Errors
/// Why the inner solve failed.
pub(super) fn clip(
    condensed: &mut Condensed<'_, '_, '_>,
    iterate: &mut QpIterate,
) -> Result<bool, QpStatus> {
    let (set, place) = (condensed.contact().set, condensed.place());
    let multiplier = &iterate.blocks[place].multiplier;
    let mut excess = set.violation(multiplier);
    excess.iter_mut().for_each(|value| *value = -*value);
    let counts = largest(&excess) > ROUNDING * largest(multiplier);
    if counts {
        condensed.shift(iterate, &excess)?;
    }
    set.project(&mut iterate.blocks[place].multiplier);
    Ok(counts)
}
