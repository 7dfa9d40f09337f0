//! Limits of mesh sequences by Richardson's extrapolation, with an uncertainty.
//!
//! Model: v(h) = limit + c h^p. Three meshes fix limit, c and p. Every three of
//! the four finest meshes give an estimate, taken where its order lies in
//! [0.5, 4]; with fewer than three such estimates the orders 1, 1.5, 2, 2.5 and
//! 3 are prescribed and the limit fitted to the finest two, three and four
//! meshes. The limit is the median of the estimates. Its uncertainty is their
//! whole range, but never less than a quarter of the way from the finest value to
//! the limit: meshes that are not similar can agree on a wrong order. (The quarter
//! is the safety factor 1.25 of Roache's grid convergence index, 1994.)

/// Orders of convergence that an estimate is believed with.
const ORDERS: std::ops::RangeInclusive<f64> = 0.5..=4.0;
/// Orders where the values fix none.
const PRESCRIBED: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];
/// Meshes that take part.
const FINEST: usize = 4;
/// Share of the extrapolated distance that stays uncertain.
const DOUBT: f64 = 0.25;

/// A value on a mesh of size `h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Mesh size where the solution is hardest, length.
    pub(crate) h: f64,
    /// The quantity.
    pub(crate) value: f64,
}

/// A limit for h to 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    /// The quantity.
    pub(crate) value: f64,
    /// Plus or minus, same unit.
    pub(crate) uncertainty: f64,
}

impl Limit {
    /// Relative distance of a value.
    pub(crate) fn error(&self, value: f64) -> f64 {
        ((value - self.value) / self.value).abs()
    }

    /// Whether it is the exact solution, not an extrapolated one.
    pub(crate) fn is_exact(&self) -> bool {
        self.uncertainty == 0.0
    }

    /// Relative uncertainty.
    pub(crate) fn relative(&self) -> f64 {
        (self.uncertainty / self.value).abs()
    }
}

/// The limit of samples, coarsest first; none for fewer than three. A last one of
/// size zero is the limit itself.
pub(crate) fn extrapolate(samples: &[Sample]) -> Option<Limit> {
    if let Some(&Sample { value, h: 0.0 }) = samples.last() {
        let uncertainty = 0.0;
        return Some(Limit { value, uncertainty });
    }
    let finest = samples.get(samples.len().saturating_sub(FINEST)..)?;
    let mut estimates = free_orders(finest);
    if estimates.len() < 3 {
        estimates = prescribed_orders(finest);
    }
    estimates.sort_by(f64::total_cmp);
    let value = *estimates.get(estimates.len() / 2)?;
    let range = estimates.last()? - estimates.first()?;
    let distance = (value - finest.last()?.value).abs();
    let uncertainty = range.max(DOUBT * distance);
    Some(Limit { value, uncertainty })
}

fn free_orders(samples: &[Sample]) -> Vec<f64> {
    let mut estimates = Vec::new();
    for (i, first) in samples.iter().enumerate() {
        for (j, second) in samples.iter().enumerate().skip(i + 1) {
            for third in samples.iter().skip(j + 1) {
                estimates.extend(richardson([*first, *second, *third]));
            }
        }
    }
    estimates
}

/// The order by bisection: the ratio of the differences grows with it.
fn richardson([a, b, c]: [Sample; 3]) -> Option<f64> {
    let ratio = (a.value - b.value) / (b.value - c.value);
    let excess = |p: f64| {
        let power = |sample: Sample| sample.h.powf(p);
        (power(a) - power(b)) / (power(b) - power(c)) - ratio
    };
    let (mut low, mut high) = (*ORDERS.start(), *ORDERS.end());
    if !(excess(low) <= 0.0 && excess(high) >= 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) <= 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let coefficient = (b.value - c.value) / (b.h.powf(low) - c.h.powf(low));
    Some(c.value - coefficient * c.h.powf(low))
}

fn prescribed_orders(samples: &[Sample]) -> Vec<f64> {
    let counts = 2..=samples.len();
    let parts = counts.filter_map(|count| samples.get(samples.len() - count..));
    if samples.len() < 3 {
        return Vec::new();
    }
    parts
        .flat_map(|part| PRESCRIBED.map(|order| fitted(part, order)))
        .collect()
}

/// Least squares for limit and coefficient at a known order.
fn fitted(samples: &[Sample], order: f64) -> f64 {
    let count = samples.len() as f64;
    let powers = || samples.iter().map(|sample| sample.h.powf(order));
    let mean = powers().sum::<f64>() / count;
    let mean_value = samples.iter().map(|sample| sample.value).sum::<f64>() / count;
    let spread: f64 = powers().map(|power| (power - mean).powi(2)).sum();
    let products = powers()
        .zip(samples)
        .map(|(power, sample)| (power - mean) * (sample.value - mean_value));
    mean_value - products.sum::<f64>() / spread * mean
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(values: impl Fn(f64) -> f64) -> Vec<Sample> {
        let sizes = [0.2, 0.1, 0.06, 0.04, 0.03];
        sizes
            .map(|h| Sample {
                h,
                value: values(h),
            })
            .to_vec()
    }

    #[test]
    fn a_pure_power_is_extrapolated_exactly() {
        for order in [0.7, 1.18, 2.0, 3.5] {
            let limit = extrapolate(&sequence(|h| 5.0 - 3.0 * h.powf(order))).unwrap();
            assert!((limit.value - 5.0).abs() < 1e-9, "{limit:?}");
            let distance = 3.0 * 0.03_f64.powf(order);
            let uncertainty = limit.uncertainty;
            assert!((uncertainty - DOUBT * distance).abs() < 1e-8, "{limit:?}");
        }
    }

    #[test]
    fn the_uncertainty_covers_a_second_term() {
        let limit = extrapolate(&sequence(|h| 1.0 + h.powf(1.2) - 2.0 * h.powi(3))).unwrap();
        assert!((limit.value - 1.0).abs() <= limit.uncertainty, "{limit:?}");
        assert!(limit.uncertainty < 0.05, "{limit:?}");
    }

    #[test]
    fn values_without_an_order_have_a_wide_uncertainty() {
        let values = [1.0, 1.02, 1.01, 1.012, 1.008];
        let mut next = values.iter();
        let sizes = [0.2, 0.1, 0.06, 0.04, 0.03];
        let samples = sizes.map(|h| Sample {
            h,
            value: *next.next().unwrap(),
        });
        let limit = extrapolate(&samples).unwrap();
        assert!(limit.uncertainty > 0.004, "{limit:?}");
        assert!((limit.value - 1.0).abs() < 0.05, "{limit:?}");
    }

    #[test]
    fn an_exact_solution_is_its_own_limit() {
        let mut samples = sequence(|h| 1.0 + h);
        samples.push(Sample { h: 0.0, value: 1.0 });
        let limit = extrapolate(&samples).unwrap();
        assert!(limit.is_exact());
        assert!((limit.error(1.5) - 0.5).abs() < 1e-15);
        assert!(!extrapolate(&sequence(|h| 1.0 + h)).unwrap().is_exact());
    }

    #[test]
    fn two_meshes_have_no_limit() {
        assert_eq!(extrapolate(&sequence(|h| h)[..2]), None);
        assert_eq!(extrapolate(&[]), None);
    }
}
