//! The eight-chain model of Arruda and Boyce, by five terms of its series:
//!
//! ```text
//! W = mu sum_i a_i / l^(2 i - 2) (i1^i - 3^i),   a = 1/2, 1/20, 11/1050, 19/7000, 519/673750
//! ```
//!
//! (Arruda and Boyce, A three-dimensional constitutive model for the large stretch behavior of
//! rubber elastic materials, 1993.) i1^i - 3^i is written in x = i1 - 3, so that small strains keep
//! their digits. The shear modulus at rest is
//! mu (1 + 3/5 l^-2 + 99/175 l^-4 + 513/875 l^-6 + 42039/67375 l^-8).

use super::energy::{Derivatives, Energy};

/// a_i of the series.
const SERIES: [f64; 5] = [
    1.0 / 2.0,
    1.0 / 20.0,
    11.0 / 1050.0,
    19.0 / 7000.0,
    519.0 / 673_750.0,
];

/// The law.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrudaBoyce {
    /// mu, stress, above zero.
    pub modulus: f64,
    /// l, the locking stretch of the full model, above one; the series is finite there.
    pub locking_stretch: f64,
}

impl Energy for ArrudaBoyce {
    fn at(&self, first: f64, _second: f64) -> Derivatives {
        let whole = 3.0 + first;
        let shrink = self.locking_stretch.powi(-2);
        let mut sum = Derivatives::default();
        let mut weight = self.modulus;
        // i1^n - 3^n = i1 (i1^(n-1) - 3^(n-1)) + 3^(n-1) (i1 - 3).
        let (mut excess, mut power, mut rest) = (first, [1.0, 0.0], 1.0);
        for (n, a) in (1u8..).zip(SERIES) {
            let n = f64::from(n);
            sum.value += weight * a * excess;
            sum.first += weight * a * n * power[0];
            sum.first_first += weight * a * n * (n - 1.0) * power[1];
            rest *= 3.0;
            excess = whole * excess + rest * first;
            power = [whole * power[0], power[0]];
            weight *= shrink;
        }
        sum
    }

    fn over(&self, stress: f64) -> Self {
        Self {
            modulus: self.modulus / stress,
            locking_stretch: self.locking_stretch,
        }
    }

    fn numbers(&self) -> (&'static str, Vec<f64>) {
        ("arruda-boyce", vec![self.modulus, self.locking_stretch])
    }
}
