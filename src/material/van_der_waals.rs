//! The van der Waals network of Kilian:
//!
//! ```text
//! W = mu { -L [ln(1 - eta) + eta] - 2/3 a (x / 2)^(3/2) },   x = (1 - beta) i1 + beta i2 - 3
//! dW/dx = mu / 2 { 1 / (1 - eta) - a sqrt(x / 2) },   eta = sqrt(x / L),   L = l^2 - 3
//! ```
//!
//! (Kilian, Equation of state of real networks, 1981; Enderle and Kilian, General deformation modes
//! of a van der Waals network, 1987.) l is the locking stretch, a the interaction of the chains.
//! dW/dx is mu / 2 at rest. d2W/dx2 grows there as 1 / sqrt(x), that is as one over the strain; the
//! square of dx/dF goes with it to zero, and below [`LEAST`] the root stays what it is.
//!
//! From [`LAST`] of L on the slope goes on along its tangent, as in Gent's law, so that steps of the
//! solver which lead too far still have an energy that calls them back: dW/dx is 1000 mu there.

use super::energy::{Derivatives, Energy};

/// Share of L, without unit, from which on the slope is linear: eta is 0.9995 there; chosen as in
/// Gent's law.
const LAST: f64 = 0.999;
/// Least sqrt(x) of the second derivative: a strain below which no digit of a stress sees it.
const LEAST: f64 = 1e-12;

/// The law.
#[derive(Clone, Debug, PartialEq)]
pub struct VanDerWaals {
    /// mu at rest, stress, above zero.
    pub shear_modulus: f64,
    /// l, above sqrt(3), without unit.
    pub locking_stretch: f64,
    /// a, at least zero, without unit.
    pub interaction: f64,
    /// beta, from zero to one: the share of the second invariant.
    pub second_share: f64,
}

/// -ln(1 - y) - y for y from zero to below one.
fn second_logarithm(y: f64) -> f64 {
    if y > 0.1 {
        return -(-y).ln_1p() - y;
    }
    // y^2 (1/2 + y/3 + y^2/4 + ..): the last term is below 1e-17.
    let tail = (2..=18)
        .rev()
        .fold(0.0, |sum, n| 1.0 / f64::from(n) + y * sum);
    y * y * tail
}

impl VanDerWaals {
    /// W / mu, and its first and second derivative by x.
    fn along(&self, x: f64) -> [f64; 3] {
        let limit = self.locking_stretch * self.locking_stretch - 3.0;
        // Rounding may take x below zero; a limit below zero is refused and has no numbers.
        let inside = x.max(0.0).min(LAST * limit);
        let root = inside.sqrt();
        let eta = root / limit.sqrt();
        let left = 1.0 / (1.0 - eta);
        let (a, half) = (self.interaction, std::f64::consts::FRAC_1_SQRT_2);
        let value = limit * second_logarithm(eta) - a / 3.0 * half * inside * root;
        let slope = 0.5 * left - 0.5 * a * half * root;
        let bend = (left * left / limit.sqrt() - a * half) / (4.0 * root.max(LEAST));
        let beyond = x - inside;
        let bend_beyond = if beyond > 0.0 { bend } else { 0.0 };
        [
            value + beyond * (slope + 0.5 * bend_beyond * beyond),
            slope + bend_beyond * beyond,
            bend,
        ]
    }
}

impl Energy for VanDerWaals {
    fn at(&self, first: f64, second: f64) -> Derivatives {
        let shares = [1.0 - self.second_share, self.second_share];
        let along = self.along(shares[0] * first + shares[1] * second);
        let [value, slope, bend] = along.map(|one| self.shear_modulus * one);
        Derivatives {
            value,
            first: shares[0] * slope,
            second: shares[1] * slope,
            first_first: shares[0] * shares[0] * bend,
            first_second: shares[0] * shares[1] * bend,
            second_second: shares[1] * shares[1] * bend,
        }
    }

    fn over(&self, stress: f64) -> Self {
        Self {
            shear_modulus: self.shear_modulus / stress,
            ..self.clone()
        }
    }

    fn numbers(&self) -> (&'static str, Vec<f64>) {
        let numbers = vec![
            self.shear_modulus,
            self.locking_stretch,
            self.interaction,
            self.second_share,
        ];
        ("van-der-waals", numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_near_rest_is_that_of_its_series() {
        let law = VanDerWaals {
            shear_modulus: 1.0,
            locking_stretch: 3.0,
            interaction: 0.3,
            second_share: 0.0,
        };
        for x in [1e-16_f64, 1e-10, 1e-6] {
            // mu x / 2 (1 + 2/3 eta + eta^2 / 2 + ..) - mu a / 3 x^(3/2) / sqrt 2.
            let eta = (x / 6.0).sqrt();
            let series = 1.0 + eta * (2.0 / 3.0 + eta * (0.5 + eta * (0.4 + eta / 3.0)));
            let exact = 0.5 * x * series - 0.1 * x * (0.5 * x).sqrt();
            let at = law.at(x, 0.0);
            assert!((at.value - exact).abs() < 1e-14 * exact, "{x}");
            assert!(at.first_first.is_finite());
        }
        let rest = law.at(-1e-17, 0.0);
        assert!((rest.first - 0.5).abs() < 1e-15 && rest.value.abs() < 1e-16);
    }
}
