//! Free functions on vectors `[f64; 3]`, component by component.
//!
//! No assumption on the values except where said; a few flops each.

/// a + b.
#[inline]
pub fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[inline]
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `factor` a.
#[inline]
pub fn scale(factor: f64, a: [f64; 3]) -> [f64; 3] {
    [factor * a[0], factor * a[1], factor * a[2]]
}

/// a · b.
#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[inline]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length. Squares underflow below about 1e-154 and overflow above 1e154.
#[inline]
pub fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Largest absolute component; NaN components are skipped.
#[inline]
pub fn max_norm(a: [f64; 3]) -> f64 {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}

/// a / |a|, of any finite length above zero; `None` for the zero vector and
/// for components that are not finite.
pub fn normalised(a: [f64; 3]) -> Option<[f64; 3]> {
    if !is_finite(a) {
        return None;
    }
    let largest = max_norm(a);
    if largest > 0.0 {
        // Dividing by the largest component first keeps the squares in range.
        let scaled = a.map(|component| component / largest);
        let length = norm(scaled);
        Some(scaled.map(|component| component / length))
    } else {
        None
    }
}

/// Whether every component is finite.
#[inline]
pub fn is_finite(a: [f64; 3]) -> bool {
    a.iter().all(|component| component.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_product_is_right_handed() {
        let product = cross([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert!(norm(sub(product, [0.0, 0.0, 1.0])) < 1e-16);
    }

    #[test]
    fn cross_product_is_orthogonal_to_both_factors() {
        let (a, b) = ([1.0, -2.0, 0.5], [0.25, 3.0, -1.0]);
        let product = cross(a, b);
        assert!(dot(product, a).abs() < 1e-14);
        assert!(dot(product, b).abs() < 1e-14);
        assert!(norm(product) > 1.0);
    }

    #[test]
    fn normalising_works_at_every_magnitude() {
        for magnitude in [1e-300, 1e-160, 1.0, 1e160, 1e300] {
            let unit = normalised(scale(magnitude, [3.0, 0.0, -4.0])).expect("not zero");
            assert!(norm(sub(unit, [0.6, 0.0, -0.8])) < 1e-15, "{magnitude}");
        }
    }

    #[test]
    fn normalising_refuses_zero_and_not_finite() {
        assert!(normalised([0.0, -0.0, 0.0]).is_none());
        assert!(normalised([f64::NAN, 1.0, 0.0]).is_none());
        assert!(normalised([f64::INFINITY, 1.0, 0.0]).is_none());
    }

    #[test]
    fn sums_and_multiples_act_by_component() {
        let combined = add(scale(2.0, [1.0, 2.0, 3.0]), [0.5, -1.0, 0.0]);
        assert!(norm(sub(combined, [2.5, 3.0, 6.0])) < 1e-15);
        assert!((max_norm(combined) - 6.0).abs() < 1e-15);
    }
}
