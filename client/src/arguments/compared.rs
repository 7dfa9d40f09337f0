//! The methods that the solver is compared with, where this program has them.

use signorini_server::Compared;

/// Those of `signorini-compare`.
#[cfg(feature = "compare")]
pub(crate) fn compared() -> Compared {
    Compared::with(signorini_compare::Methods)
}

/// None.
#[cfg(not(feature = "compare"))]
pub(crate) fn compared() -> Compared {
    Compared::default()
}
