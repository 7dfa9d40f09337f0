//! What counts as lying in the plane z = 0: |z| <= tolerance times the extent.

/// Relative distance from the plane z = 0 that is taken as rounding.
pub(super) const PLANE_TOLERANCE: f64 = 1e-12;

/// Largest distance from the axes of the plane.
pub(super) fn extent<'a>(points: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    points.fold(0.0_f64, |extent, [x, y, _]| {
        extent.max(x.abs()).max(y.abs())
    })
}
