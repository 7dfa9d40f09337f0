//! Isochoric laws whose energy is any function of the two invariants,
//!
//! ```text
//! W(i1, i2),   P = W1 di1/dF + W2 di2/dF
//! dP/dF = .. + W11 di1 di1 + W12 (di1 di2 + di2 di1) + W22 di2 di2
//! di1/dF = 2 J^(-2/3) n1,   di2/dF = 2 J^(-4/3) n2
//! ```
//!
//! with the invariants and directions of [`Deformation`]. A law is a file with its energy and
//! derivatives at (i1 - 3, i2 - 3); kernels take it point by point and keep its tangent. Cost at a
//! point: some 300 flops for the stress, nine times those of a direction for the tangent.

use sha2::{Digest, Sha256};

use super::arruda_boyce::ArrudaBoyce;
use super::energy::{Derivatives, Energy};
use super::gent::Gent;
use super::invariants::{Deformation, Slopes};
use super::polynomial::Polynomial;
use super::principal::TangentMatrix;
use super::van_der_waals::VanDerWaals;
use crate::geometry::tensor::{Tensor, contract, plus, scaled};

/// The laws.
#[derive(Clone, Debug, PartialEq)]
pub enum Potential {
    /// Rivlin's polynomial up to the third order.
    Polynomial(Polynomial),
    /// Limited first invariant.
    Gent(Gent),
    /// The eight-chain model.
    ArrudaBoyce(ArrudaBoyce),
    /// The van der Waals network.
    VanDerWaals(VanDerWaals),
}

impl Potential {
    fn energy_law(&self) -> &dyn Energy {
        match self {
            Self::Polynomial(law) => law,
            Self::Gent(law) => law,
            Self::ArrudaBoyce(law) => law,
            Self::VanDerWaals(law) => law,
        }
    }

    /// The law in units of `stress`.
    pub fn over(&self, stress: f64) -> Self {
        match self {
            Self::Polynomial(law) => Self::Polynomial(law.over(stress)),
            Self::Gent(law) => Self::Gent(law.over(stress)),
            Self::ArrudaBoyce(law) => Self::ArrudaBoyce(law.over(stress)),
            Self::VanDerWaals(law) => Self::VanDerWaals(law.over(stress)),
        }
    }

    /// Adds the law to a digest that tells laws apart.
    pub(super) fn hash_into(&self, hash: &mut Sha256) {
        let (name, numbers) = self.energy_law().numbers();
        hash.update(name);
        for number in numbers {
            hash.update(number.to_le_bytes());
        }
    }

    /// Shear modulus at rest, 2 (W1 + W2), stress.
    pub fn shear_modulus(&self) -> f64 {
        let rest = self.energy_law().at(0.0, 0.0);
        2.0 * (rest.first + rest.second)
    }

    /// W and its derivatives where i1 - 3 is `first` and i2 - 3 is `second`.
    pub fn at(&self, first: f64, second: f64) -> Derivatives {
        self.energy_law().at(first, second)
    }

    fn at_deformation(&self, at: &Deformation<f64>) -> Derivatives {
        self.at(at.first().first_excess, at.second().second_excess)
    }

    /// W.
    pub fn energy(&self, at: &Deformation<f64>) -> f64 {
        self.at_deformation(at).value
    }

    /// dW/dF.
    pub fn stress(&self, at: &Deformation<f64>) -> Tensor<f64> {
        let slopes = self.at_deformation(at);
        let [first, second] = directions(at);
        plus(&scaled(slopes.first, &first), slopes.second, &second)
    }

    /// d2W/dF2.
    pub fn tangent(&self, at: &Deformation<f64>) -> TangentMatrix {
        let slopes = self.at_deformation(at);
        let (one, [first, second]) = (at.first(), directions(at));
        std::array::from_fn(|place| {
            let mut change = [[0.0; 3]; 3];
            change[place / 3][place % 3] = 1.0;
            let linear = Slopes {
                first: slopes.first,
                bend: slopes.first_first,
                second: slopes.second,
            };
            let (out, _) = at.tangent((&one, linear), 0.0, &change);
            let (on_first, on_second) = (contract(&first, &change), contract(&second, &change));
            let mixed = slopes.first_second;
            let out = plus(&out, mixed * on_second, &first);
            let along_second = mixed * on_first + slopes.second_second * on_second;
            let out = plus(&out, along_second, &second);
            std::array::from_fn(|row| out[row / 3][row % 3])
        })
    }
}

/// di1/dF and di2/dF.
fn directions(at: &Deformation<f64>) -> [Tensor<f64>; 2] {
    let square = at.square();
    let first = scaled(2.0 * square, &at.first().first);
    let second = scaled(2.0 * square * square, &at.second().second);
    [first, second]
}

/// Each law.
#[cfg(test)]
pub(crate) fn examples() -> [Potential; 5] {
    let gent = |limit| {
        Potential::Gent(Gent {
            shear_modulus: 0.8,
            limit,
        })
    };
    [
        Potential::Polynomial(Polynomial {
            coefficients: [0.4, 0.1, 0.03, 0.02, 0.01, 0.004, 0.003, 0.002, 0.001],
        }),
        gent(5.0),
        Potential::ArrudaBoyce(ArrudaBoyce {
            modulus: 0.9,
            locking_stretch: 2.5,
        }),
        gent(20.0),
        Potential::VanDerWaals(VanDerWaals {
            shear_modulus: 0.8,
            locking_stretch: 3.0,
            interaction: 0.2,
            second_share: 0.3,
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_the_slopes_of_the_energy_on_both_sides_of_the_limit() {
        let beyond = Potential::Gent(Gent {
            shear_modulus: 0.8,
            limit: 0.5,
        });
        let locked = Potential::VanDerWaals(VanDerWaals {
            shear_modulus: 0.8,
            locking_stretch: 1.8,
            interaction: 0.1,
            second_share: 0.6,
        });
        for law in examples().into_iter().chain([beyond, locked]) {
            // Some laws are no polynomials at rest.
            for (x, y) in [(0.3, 0.4), (2.0, 1.0), (0.0, 0.0)] {
                if x == 0.0 && matches!(law, Potential::VanDerWaals(_)) {
                    continue;
                }
                let at = law.at(x, y);
                let (e, near) = (1e-5, 1e-7);
                let [up, down] = [law.at(x + e, y), law.at(x - e, y)];
                let [over, under] = [law.at(x, y + e), law.at(x, y - e)];
                let slope = |one: f64, other: f64| (one - other) / (2.0 * e);
                for (found, exact) in [
                    (slope(up.value, down.value), at.first),
                    (slope(over.value, under.value), at.second),
                    (slope(up.first, down.first), at.first_first),
                    (slope(over.first, under.first), at.first_second),
                    (slope(over.second, under.second), at.second_second),
                ] {
                    let error = (found - exact).abs() / (1.0 + exact.abs());
                    assert!(error < near, "{law:?} {x} {y}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn tiny_strains_keep_their_digits() {
        // W = (W1 + W2) x at first order, where i1 and i2 change alike.
        for law in examples() {
            if matches!(law, Potential::VanDerWaals(_)) {
                // Its third derivative by the strain is there; a test of its own looks at it.
                continue;
            }
            let energy = law.at(1e-14, 1e-14).value;
            let exact = 0.5 * law.shear_modulus() * 1e-14;
            assert!((energy - exact).abs() < 1e-12 * exact, "{law:?} {energy}");
        }
    }

    #[test]
    fn the_modulus_of_eight_chains_is_that_of_its_series() {
        let l: f64 = 2.5;
        let series = 1.0
            + 3.0 / (5.0 * l.powi(2))
            + 99.0 / (175.0 * l.powi(4))
            + 513.0 / (875.0 * l.powi(6))
            + 42_039.0 / (67_375.0 * l.powi(8));
        assert!((examples()[2].shear_modulus() - 0.9 * series).abs() < 1e-15);
    }
}
