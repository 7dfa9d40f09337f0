//! Where a law of rubber is stable at constant volume: its energy in logarithmic strains is convex,
//!
//! ```text
//! d tau : d eps = sum_ij d2W / d eps_i d eps_j  d eps_i d eps_j > 0,   eps_3 = -eps_1 - eps_2
//! ```
//!
//! (D. C. Drucker, A definition of stable inelastic material, 1959; the check of hyperelastic laws
//! that programs of finite elements make.) Second differences of the energy; cost: some 10^4
//! energies.

use super::Isochoric;
use crate::geometry::tensor::Tensor;

/// Stretch up to which a law is looked at, and its inverse.
const FARTHEST: f64 = 10.0;
/// Strains that are looked at on a way.
const STRAINS: u32 = 400;
/// Strain of the second differences.
const STEP: f64 = 1e-3;
/// Least eigenvalue over the shear modulus that rounding leaves of a stable law.
const ROUNDING: f64 = 1e-6;

/// A way of deformation: its name, and logarithmic strains 1 and 2 over that along it.
const WAYS: [(&str, [f64; 2], f64); 4] = [
    ("uniaxial tension", [1.0, -0.5], 1.0),
    ("uniaxial compression", [1.0, -0.5], -1.0),
    ("equibiaxial tension", [1.0, 1.0], 1.0),
    ("planar tension", [1.0, 0.0], 1.0),
];

/// Where a law stops being stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unstable {
    /// On which way of deformation.
    pub(crate) way: &'static str,
    /// The first stretch along it.
    pub(crate) stretch: f64,
}

/// The ways on which `law` is not stable to the end, with the first stretch of each.
pub(crate) fn unstable(law: &Isochoric) -> Vec<Unstable> {
    let of_way = |(way, strains, sign): (&'static str, [f64; 2], f64)| {
        let is_stable = |size: f64| is_stable(law, strains.map(|strain| sign * size * strain));
        let size = |place: u32| FARTHEST.ln() * f64::from(place) / f64::from(STRAINS);
        let last = (0..=STRAINS).find(|&place| !is_stable(size(place)))?;
        let [mut least, mut most] = [last.saturating_sub(1), last].map(size);
        for _ in 0..20 {
            let middle = 0.5 * (least + most);
            if is_stable(middle) {
                least = middle;
            } else {
                most = middle;
            }
        }
        let stretch = (sign * most).exp();
        Some(Unstable { way, stretch })
    };
    WAYS.into_iter().filter_map(of_way).collect()
}

/// Whether the energy is convex at logarithmic strains.
fn is_stable(law: &Isochoric, [first, second]: [f64; 2]) -> bool {
    let energy = |a: f64, b: f64| energy(law, [first + a * STEP, second + b * STEP]);
    let here = energy(0.0, 0.0);
    let square = STEP * STEP * law.shear_modulus();
    let along = (energy(1.0, 0.0) - 2.0 * here + energy(-1.0, 0.0)) / square;
    let across = (energy(0.0, 1.0) - 2.0 * here + energy(0.0, -1.0)) / square;
    let mixed = energy(1.0, 1.0) - energy(1.0, -1.0) - energy(-1.0, 1.0) + energy(-1.0, -1.0);
    let mixed = 0.25 * mixed / square;
    let (mean, half) = (0.5 * (along + across), 0.5 * (along - across));
    mean - half.hypot(mixed) > ROUNDING
}

fn energy(law: &Isochoric, [first, second]: [f64; 2]) -> f64 {
    let strains = [first, second, -first - second];
    let mut h: Tensor<f64> = [[0.0; 3]; 3];
    for (axis, strain) in strains.into_iter().enumerate() {
        h[axis][axis] = strain.exp_m1();
    }
    law.energy(&h)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{InvariantLaw, Ogden, OgdenTerm};

    fn invariants(c10: f64, c01: f64, c20: f64, c30: f64) -> Isochoric {
        Isochoric::Invariants(InvariantLaw { c10, c01, c20, c30 })
    }

    fn stretch(law: &Isochoric, way: &str) -> Option<f64> {
        let found = unstable(law);
        found
            .iter()
            .find(|one| one.way == way)
            .map(|one| one.stretch)
    }

    #[test]
    fn laws_of_positive_constants_are_stable() {
        assert!(unstable(&invariants(0.5, 0.0, 0.0, 0.0)).is_empty());
        assert!(unstable(&invariants(0.4, 0.1, 0.01, 0.001)).is_empty());
        let terms =
            [(1.0, 2.0), (-0.2, -1.5)].map(|(modulus, exponent)| OgdenTerm { modulus, exponent });
        let ogden = Ogden {
            terms: terms.to_vec(),
        };
        assert!(unstable(&Isochoric::Ogden(ogden)).is_empty());
    }

    /// Of Mooney and Rivlin in planar tension the energy is (c10 + c01) (l^2 + l^-2), so that along
    /// the way it is convex; across it, by eps_2 = y with eps_1 = x, d2W/dy2 and the mixed one decide.
    #[test]
    fn a_negative_second_constant_is_unstable_where_its_matrix_says() {
        let law = invariants(1.0, -0.2, 0.0, 0.0);
        let found = stretch(&law, "equibiaxial tension").expect("it is unstable");
        // About (x, x, -2 x) by symmetry the eigenvectors are (1, 1) and (1, -1).
        let matrix = |x: f64| {
            let [a, b] = [(2.0 * x).exp(), (-4.0 * x).exp()];
            let [c, d] = [(-2.0 * x).exp(), (4.0 * x).exp()];
            // i1 = sum e^(2 eps), i2 = sum e^(-2 eps).
            let along = 1.0 * (4.0 * a + 4.0 * b) - 0.2 * (4.0 * c + 4.0 * d);
            let mixed = 1.0 * 4.0 * b - 0.2 * 4.0 * d;
            (along + mixed).min(along - mixed)
        };
        let x = found.ln();
        assert!(matrix(x - 1e-3) > 0.0 && matrix(x + 1e-3) < 0.0, "{found}");
    }

    #[test]
    fn a_cubic_that_falls_is_unstable_in_tension() {
        let law = invariants(0.5, 0.0, -0.05, 0.0);
        let found = stretch(&law, "uniaxial tension").expect("it is unstable");
        assert!((1.2..4.0).contains(&found), "{found}");
    }
}
