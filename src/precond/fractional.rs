//! The fractional metric of the contact pressure:
//!
//! ```text
//! K ~ M (M^-1 (L + c M))^(-1/2) M
//! ```
//!
//! M, L: mass and Laplacian of the contact surface, c about 10 over its area. The
//! compliance of a half space is the inverse square root of the Laplacian, so that
//! the condition against K stays between 2 and 4 for homogeneous bodies of any mesh
//! size; thin layers lose a factor, contrast is not seen (Arioli and Loghin, SIAM J.
//! Numer. Anal. 47, 2009). Needs no factor of the body. Cost about 20 m^3 for m
//! multipliers, once.

use crate::linalg::eigen::pencil_power;
use crate::linalg::{DenseMatrix, FactoriseError};

/// c times the area of the surface (in two dimensions times its squared length).
const SHIFT: f64 = 10.0;

/// The metric, up to a factor; `extent` is the area of the surface, or its squared
/// length.
///
/// # Errors
/// When the mass is not positive definite.
pub fn fractional(
    mass: &DenseMatrix,
    mut laplacian: DenseMatrix,
    extent: f64,
) -> Result<DenseMatrix, FactoriseError> {
    let shift = SHIFT / extent;
    for j in 0..mass.columns() {
        let column = laplacian.column_mut(j).iter_mut();
        for (value, mass) in column.zip(mass.column(j)) {
            *value += shift * mass;
        }
    }
    pencil_power(&laplacian, mass, -0.5)
}
