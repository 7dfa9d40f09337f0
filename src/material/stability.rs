//! Where a law of rubber is stable: its energy in logarithmic strains is convex, at constant volume,
//!
//! ```text
//! d tau : d eps = sum_ij d2W / d eps_i d eps_j  d eps_i d eps_j > 0,   eps_3 = -eps_1 - eps_2
//! ```
//!
//! of a foam with the changes of volume that its free directions ask for ([`foams`]).
//!
//! (D. C. Drucker, A definition of stable inelastic material, 1959; the check of hyperelastic laws
//! that programs of finite elements make.) Exact for Ogden's law, elsewhere by differences of the
//! stress; cost: some 10^4 stresses.

mod foams;
mod search;

use super::{Isochoric, Ogden};
use crate::geometry::tensor::Tensor;

/// Strain of the differences; their error, STEP^2 a^2 / 6, is 1e-7 at an exponent a of 8.
const STEP: f64 = 1e-4;
/// Error of the differences over the largest second derivative that is no loss of stability: ten
/// times that.
const ROUNDING: f64 = 1e-6;

/// A way of deformation: its name, logarithmic strains 1 and 2 over that along it, its sign.
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
    match law {
        Isochoric::Hyperfoam(law) => return foams::unstable(law),
        Isochoric::Sheet(sheet) => return unstable(sheet.body()),
        Isochoric::Invariants(_) | Isochoric::Ogden(_) | Isochoric::Potential(_) => {}
    }
    let of_way = |(way, strains, sign): (&'static str, [f64; 2], f64)| {
        let is_stable = |size: f64| is_stable(law, strains.map(|strain| sign * size * strain));
        let stretch = (sign * search::first_unstable(is_stable)?).exp();
        Some(Unstable { way, stretch })
    };
    WAYS.into_iter().filter_map(of_way).collect()
}

/// Whether the energy is convex at logarithmic strains, to the rounding of its derivatives.
fn is_stable(law: &Isochoric, strains: [f64; 2]) -> bool {
    let [along, across, mixed] = match law {
        Isochoric::Ogden(law) => return is_stable_ogden(law, strains),
        Isochoric::Invariants(_)
        | Isochoric::Potential(_)
        | Isochoric::Hyperfoam(_)
        | Isochoric::Sheet(_) => second_derivatives(law, strains),
    };
    let size = along.abs().max(across.abs());
    let determinant = (along / size) * (across / size) - (mixed / size) * (mixed / size);
    along.min(across) > -ROUNDING * size && determinant > -ROUNDING
}

/// Of d2W = diag(p_1, p_2) + p_3, with p_k = sum mu alpha m_k^alpha.
fn is_stable_ogden(law: &Ogden, [first, second]: [f64; 2]) -> bool {
    let slope = |strain: f64| -> f64 {
        let slope =
            |(modulus, exponent): (f64, f64)| modulus * exponent * (exponent * strain).exp();
        let terms = law.terms.iter();
        terms.map(|term| slope((term.modulus, term.exponent))).sum()
    };
    let [a, b, c] = [first, second, -first - second].map(slope);
    a + c > 0.0 && b + c > 0.0 && a * b + b * c + c * a > 0.0
}

/// Along strain 1, along strain 2 and mixed, by differences of the first derivatives.
fn second_derivatives(law: &Isochoric, [first, second]: [f64; 2]) -> [f64; 3] {
    let at = |a: f64, b: f64| slopes(law, [first + a * STEP, second + b * STEP]);
    let [east, west] = [at(1.0, 0.0), at(-1.0, 0.0)];
    let [north, south] = [at(0.0, 1.0), at(0.0, -1.0)];
    let over = 0.5 / STEP;
    [
        over * (east[0] - west[0]),
        over * (north[1] - south[1]),
        0.5 * over * (east[1] - west[1] + north[0] - south[0]),
    ]
}

/// dW / d eps_k = tau_k - tau_3, tau = P F^T.
fn slopes(law: &Isochoric, [first, second]: [f64; 2]) -> [f64; 2] {
    let strains = [first, second, -first - second];
    let mut h: Tensor<f64> = [[0.0; 3]; 3];
    for (axis, strain) in strains.into_iter().enumerate() {
        h[axis][axis] = strain.exp_m1();
    }
    let stress = law.stress(&h);
    let [a, b, c] = [0, 1, 2].map(|axis| stress[axis][axis] * strains[axis].exp());
    [a - c, b - c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{InvariantLaw, OgdenTerm, Potential, examples};

    fn invariants(c10: f64, c01: f64, c20: f64, c30: f64) -> Isochoric {
        Isochoric::Invariants(InvariantLaw { c10, c01, c20, c30 })
    }

    fn stretch(law: &Isochoric, way: &str) -> Option<f64> {
        let found = unstable(law);
        let own = found.iter().find(|one| one.way == way);
        own.map(|one| one.stretch)
    }

    #[test]
    fn convex_laws_are_stable() {
        assert!(unstable(&invariants(0.5, 0.0, 0.0, 0.0)).is_empty());
        assert!(unstable(&invariants(0.4, 0.1, 0.01, 0.001)).is_empty());
        let terms = [
            (1.0, 2.0),
            (-1.0, -4.7),
            (-1.0, -8.0),
            (0.1, 9.0),
            (0.1, 20.0),
        ];
        for (modulus, exponent) in terms {
            let terms = vec![OgdenTerm { modulus, exponent }];
            let found = unstable(&Isochoric::Ogden(Ogden { terms }));
            assert!(found.is_empty(), "{exponent}: {found:?}");
        }
        for law in examples() {
            let is_polynomial = matches!(law, Potential::Polynomial(_));
            let found = unstable(&Isochoric::Potential(law));
            assert!(is_polynomial || found.is_empty(), "{found:?}");
        }
    }

    #[test]
    fn a_negative_second_constant_is_unstable_where_its_matrix_says() {
        let law = invariants(1.0, -0.2, 0.0, 0.0);
        let found = stretch(&law, "equibiaxial tension").expect("it is unstable");
        // i1 = sum e^(2 eps), i2 = sum e^(-2 eps), about (x, x, -2 x): by symmetry the
        // eigenvectors are (1, 1) and (1, -1).
        let matrix = |x: f64| {
            let [a, b] = [(2.0 * x).exp(), (-4.0 * x).exp()];
            let [c, d] = [(-2.0 * x).exp(), (4.0 * x).exp()];
            let along = 4.0 * (a + b) - 0.2 * 4.0 * (c + d);
            let mixed = 4.0 * b - 0.2 * 4.0 * d;
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
