//! The constants of a law as a list of numbers, with their names, bounds and first values.

use super::Test;
use super::least_squares::Unknown;
use crate::scene::RubberModel;

/// Names of a polynomial's coefficients, in the order of the scene.
const COEFFICIENTS: [&str; 9] = [
    "c10", "c01", "c20", "c11", "c02", "c30", "c21", "c12", "c03",
];
/// Order of each, i + j.
const ORDERS: [i32; 9] = [1, 1, 2, 2, 2, 3, 3, 3, 3];
/// Exponents that Ogden's law starts from, by the number of its terms; chosen: those of the
/// published fits to Treloar's data among them.
const EXPONENTS: [&[&[f64]]; 3] = [
    &[&[2.0], &[-2.0], &[4.0], &[0.8], &[-5.0]],
    &[
        &[2.0, -2.0],
        &[1.3, 5.0],
        &[1.5, 8.0],
        &[2.6, -3.5],
        &[0.7, 3.0],
        &[4.0, -1.5],
    ],
    &[
        &[1.3, 5.0, -2.0],
        &[2.0, 8.0, -2.0],
        &[0.7, 3.0, 9.0],
        &[1.8, 4.5, -4.0],
        &[2.5, -1.0, -6.0],
    ],
];
/// Exponents of Ogden's law beyond which stresses leave the range of numbers, or are all alike.
const EXPONENT_BOUNDS: [f64; 2] = [1e-2, 40.0];
/// Beyond the largest invariant of the tests, by which a limit stands at least above it; chosen,
/// without unit.
const ABOVE: f64 = 1.0 + 1e-4;

/// A constant of a law.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Constant {
    /// Its key in the scene; of lists with the place, from 0.
    pub(super) name: String,
    /// Bounds and size.
    pub(super) unknown: Unknown,
}

/// What the tests say before any fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    /// Shear modulus of the neo-Hookean law that is nearest.
    pub(super) modulus: f64,
    /// Largest i1 - 3.
    pub(super) first: f64,
}

impl Size {
    /// Of some tests.
    pub(super) fn of(tests: &[Test], modulus: f64) -> Self {
        let values = tests
            .iter()
            .map(|test| test.kind.first_invariant(test.stretch));
        Self {
            modulus,
            first: values.fold(0.0, f64::max),
        }
    }
}

fn constant(name: impl Into<String>, bounds: [f64; 2], size: f64) -> Constant {
    Constant {
        name: name.into(),
        unknown: Unknown { bounds, size },
    }
}

const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Above zero and far below what would be none of the tests' sizes.
fn positive(size: f64) -> [f64; 2] {
    [1e-6 * size, f64::INFINITY]
}

/// Places of the coefficients of a polynomial that are fitted: those that it has, or those of the
/// second order.
fn fitted(coefficients: &[f64; 9]) -> Vec<usize> {
    let own: Vec<usize> = (0..9).filter(|&i| coefficients[i] != 0.0).collect();
    if own.is_empty() {
        (0..5).collect()
    } else {
        own
    }
}

/// The constants of a law with bounds about the values `start`; none of one that is not fitted.
pub(super) fn constants(model: &RubberModel, start: &[f64], size: Size) -> Option<Vec<Constant>> {
    let Size { modulus, first, .. } = size;
    let coefficient =
        |name: &str, order: i32| constant(name, ANY, modulus / first.max(1.0).powi(order - 1));
    let shear = || constant("shear_modulus", positive(modulus), modulus);
    Some(match model {
        RubberModel::NeoHookean { .. } => vec![shear()],
        RubberModel::MooneyRivlin { .. } => vec![coefficient("c10", 1), coefficient("c01", 1)],
        RubberModel::Yeoh { .. } => vec![
            constant("c10", positive(modulus), modulus),
            coefficient("c20", 2),
            coefficient("c30", 3),
        ],
        RubberModel::Polynomial { coefficients } => {
            let own = fitted(coefficients).into_iter();
            own.map(|i| coefficient(COEFFICIENTS[i], ORDERS[i]))
                .collect()
        }
        RubberModel::Ogden { mu, .. } => {
            let alpha = start.get(mu.len()..).unwrap_or_default();
            let mu = (0..mu.len()).map(|i| constant(format!("mu[{i}]"), ANY, modulus));
            let [least, most] = EXPONENT_BOUNDS;
            let exponent = |(i, &alpha): (usize, &f64)| {
                let bounds = if alpha < 0.0 {
                    [-most, -least]
                } else {
                    [least, most]
                };
                constant(format!("alpha[{i}]"), bounds, 1.0)
            };
            mu.chain(alpha.iter().enumerate().map(exponent)).collect()
        }
        RubberModel::Gent { .. } => {
            let limit = (ABOVE * first).max(2e-3);
            vec![
                shear(),
                constant("limit", [limit, 1e4 * (1.0 + limit)], limit),
            ]
        }
        RubberModel::ArrudaBoyce { .. } => vec![
            constant("mu", positive(modulus), modulus),
            constant("locking_stretch", [1.0 + 1e-6, 1e3], 1.0),
        ],
        RubberModel::VanDerWaals { .. } => vec![
            shear(),
            constant("locking_stretch", [LEAST_LOCKING, 1e3], 1.0),
            constant("a", [0.0, 10.0], 0.1),
            constant("beta", [0.0, 1.0], 0.1),
        ],
        RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => return None,
    })
}

/// Locking stretch of the van der Waals network at the least: the law goes on beyond it, so that a
/// fit may pass it. Without unit; chosen, no test measures it.
const LEAST_LOCKING: f64 = 1.8;

/// The values of the constants in the order of [`constants`].
pub(super) fn values(model: &RubberModel) -> Vec<f64> {
    match model {
        &RubberModel::NeoHookean { shear_modulus } => vec![shear_modulus],
        &RubberModel::MooneyRivlin { c10, c01 } => vec![c10, c01],
        &RubberModel::Yeoh { c10, c20, c30 } => vec![c10, c20, c30],
        RubberModel::Polynomial { coefficients } => fitted(coefficients)
            .into_iter()
            .map(|i| coefficients[i])
            .collect(),
        RubberModel::Ogden { mu, alpha } => [&mu[..], alpha].concat(),
        &RubberModel::Gent {
            shear_modulus,
            limit,
        } => vec![shear_modulus, limit],
        &RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => vec![mu, locking_stretch],
        &RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a,
            beta,
        } => vec![shear_modulus, locking_stretch, a, beta],
        RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => Vec::new(),
    }
}

/// The law with these values of its constants; missing ones stay.
pub(super) fn with_values(model: &RubberModel, values: &[f64]) -> RubberModel {
    let mut changed = model.clone();
    let slots: Vec<&mut f64> = match &mut changed {
        RubberModel::NeoHookean { shear_modulus } => vec![shear_modulus],
        RubberModel::MooneyRivlin { c10, c01 } => vec![c10, c01],
        RubberModel::Yeoh { c10, c20, c30 } => vec![c10, c20, c30],
        RubberModel::Polynomial { coefficients } => {
            let own = fitted(coefficients);
            let all = coefficients.iter_mut().enumerate();
            all.filter(|(i, _)| own.contains(i))
                .map(|(_, slot)| slot)
                .collect()
        }
        RubberModel::Ogden { mu, alpha } => mu.iter_mut().chain(alpha).collect(),
        RubberModel::Gent {
            shear_modulus,
            limit,
        } => vec![shear_modulus, limit],
        RubberModel::ArrudaBoyce {
            mu,
            locking_stretch,
        } => vec![mu, locking_stretch],
        RubberModel::VanDerWaals {
            shear_modulus,
            locking_stretch,
            a,
            beta,
        } => vec![shear_modulus, locking_stretch, a, beta],
        RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => Vec::new(),
    };
    slots
        .into_iter()
        .zip(values)
        .for_each(|(slot, value)| *slot = *value);
    changed
}

/// Values to start from: those of the law first, then some of the size that the tests say.
pub(super) fn starts(model: &RubberModel, size: Size) -> Vec<Vec<f64>> {
    let g = size.modulus;
    let mut starts = vec![values(model)];
    starts.extend(match model {
        RubberModel::NeoHookean { .. } => vec![vec![g]],
        RubberModel::MooneyRivlin { .. } => vec![vec![0.4 * g, 0.1 * g]],
        RubberModel::Yeoh { .. } => vec![vec![0.5 * g, 0.0, 0.0]],
        RubberModel::Polynomial { coefficients } => {
            let own = fitted(coefficients).into_iter();
            let first = own.map(|i| if ORDERS[i] == 1 { 0.25 * g } else { 0.0 });
            vec![first.collect()]
        }
        RubberModel::Ogden { mu, .. } => ogden_starts(mu.len(), g),
        RubberModel::Gent { .. } => {
            let limits = [1.1, 1.5, 5.0].map(|x| x * size.first.max(0.1));
            limits.map(|limit| vec![g, limit]).to_vec()
        }
        RubberModel::ArrudaBoyce { .. } => {
            let chain = ((size.first + 3.0) / 3.0).sqrt();
            [1.05, 1.5, 4.0].map(|x| vec![g, x * chain]).to_vec()
        }
        RubberModel::VanDerWaals { .. } => {
            let locking = (size.first + 3.0).sqrt().max(LEAST_LOCKING);
            let at = |[x, beta]: [f64; 2]| vec![g, x * locking, 0.2, beta];
            [[1.1, 0.05], [1.3, 0.3], [2.0, 0.1]].map(at).to_vec()
        }
        RubberModel::Hyperfoam { .. } | RubberModel::BlatzKo { .. } => Vec::new(),
    });
    starts
}

/// Terms of equal shares in the modulus, sum mu alpha / 2.
fn ogden_starts(terms: usize, modulus: f64) -> Vec<Vec<f64>> {
    let exponents = EXPONENTS
        .get(terms.wrapping_sub(1))
        .copied()
        .unwrap_or_default();
    let start = |alpha: &&[f64]| {
        let mu = alpha.iter().map(|a| 2.0 * modulus / (a * terms as f64));
        mu.chain(alpha.iter().copied()).collect()
    };
    exponents.iter().map(start).collect()
}
