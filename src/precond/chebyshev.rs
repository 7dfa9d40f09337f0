//! Coefficients of the Chebyshev iteration for `A x = b`, the spectrum of A in `[low, high]`:
//! with the residual r, scaled by whatever the spectrum belongs to,
//!
//! ```text
//! d' = keep d + gain r,   x' = x + d'
//! ```
//!
//! Y. Saad, Iterative Methods for Sparse Linear Systems, algorithm 12.1 (2003).

/// The steps of the iteration, one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chebyshev {
    half: f64,
    sigma: f64,
    rho: f64,
    next: Step,
}

/// One step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// What stays of the last direction; none in the first step.
    pub(super) keep: f64,
    /// What the residual adds.
    pub(super) gain: f64,
}

impl Chebyshev {
    /// For a spectrum in `[low, high]`.
    pub(super) fn new(low: f64, high: f64) -> Self {
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / half;
        Self {
            half,
            sigma,
            rho: 1.0 / sigma,
            next: Step {
                keep: 0.0,
                gain: 1.0 / centre,
            },
        }
    }

    /// The next step.
    pub(super) fn advance(&mut self) -> Step {
        let rho = 1.0 / (2.0 * self.sigma - self.rho);
        let following = Step {
            keep: rho * self.rho,
            gain: 2.0 * rho / self.half,
        };
        self.rho = rho;
        std::mem::replace(&mut self.next, following)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residual polynomial T_k((centre - a) / half) / T_k(sigma) after k steps.
    #[test]
    fn the_residual_is_the_polynomial_of_chebyshev() {
        let (low, high, a) = (0.5_f64, 4.0, 1.3);
        let mut chebyshev = Chebyshev::new(low, high);
        let (mut r, mut d) = (1.0, 0.0);
        for degree in 1..=4 {
            let step = chebyshev.advance();
            d = step.keep * d + step.gain * r;
            r -= a * d;
            let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
            let of = |t: f64| {
                let (mut before, mut now) = (1.0, t);
                for _ in 1..degree {
                    (before, now) = (now, 2.0 * t * now - before);
                }
                now
            };
            let expected = of((centre - a) / half) / of(centre / half);
            assert!((r - expected).abs() < 1e-14, "{degree}: {r} {expected}");
        }
    }
}
