//! Rivlin's polynomial: W = sum c_ij (i1 - 3)^i (i2 - 3)^j, 1 <= i + j <= 3 (Rivlin and Saunders,
//! 1951).

use super::energy::{Derivatives, Energy};

/// Powers i and j of the coefficients, in their order.
pub const POWERS: [(i32, i32); 9] = [
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (3, 0),
    (2, 1),
    (1, 2),
    (0, 3),
];

/// Coefficients, stress, in the order of [`POWERS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    /// c10, c01, c20, c11, c02, c30, c21, c12, c03.
    pub coefficients: [f64; 9],
}

/// x^n and its first two derivatives.
fn power(x: f64, n: i32) -> [f64; 3] {
    let slope = |n: i32| if n > 0 { x.powi(n - 1) } else { 0.0 };
    let (own, next) = (f64::from(n), f64::from(n - 1));
    [x.powi(n), own * slope(n), own * next * slope(n - 1)]
}

impl Energy for Polynomial {
    fn at(&self, first: f64, second: f64) -> Derivatives {
        let mut sum = Derivatives::default();
        for (c, (i, j)) in self.coefficients.iter().zip(POWERS) {
            let (x, y) = (power(first, i), power(second, j));
            sum.value += c * x[0] * y[0];
            sum.first += c * x[1] * y[0];
            sum.second += c * x[0] * y[1];
            sum.first_first += c * x[2] * y[0];
            sum.first_second += c * x[1] * y[1];
            sum.second_second += c * x[0] * y[2];
        }
        sum
    }

    fn over(&self, stress: f64) -> Self {
        Self {
            coefficients: self.coefficients.map(|c| c / stress),
        }
    }

    fn numbers(&self) -> (&'static str, Vec<f64>) {
        ("polynomial", self.coefficients.to_vec())
    }
}
